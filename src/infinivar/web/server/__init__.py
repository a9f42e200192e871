"""The local server of the explorer."""
