"""Drives as bond graphs: their plants, controllers and closed loops."""
