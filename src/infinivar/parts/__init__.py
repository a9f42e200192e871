"""Machine parts as frozen values, each with its own law, and the catalogue they can be taken from."""
