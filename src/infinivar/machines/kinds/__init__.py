"""Kinds of machine, one module each; what a kind must and may define is in `infinivar.machines.kind`."""
