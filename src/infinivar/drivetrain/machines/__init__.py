"""Machines as drives of a study: platform, arm, sphere and planar cart, behind one protocol."""
