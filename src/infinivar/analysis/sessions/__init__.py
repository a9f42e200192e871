"""Sessions of a user at the handle of a machine: their runs, measures and guides."""
