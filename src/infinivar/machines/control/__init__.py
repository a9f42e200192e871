"""Controllers that guide a user at the handle of a machine: paths, walls, free mode and displays, with the sensors they use."""
