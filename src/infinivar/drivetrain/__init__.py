"""Whole drive-trains, composed from elements and parts, and the requirement they must meet."""
