"""Measuring a transmission: the virtual rig, reduction of its data, fitting the losses, and what to measure next."""
