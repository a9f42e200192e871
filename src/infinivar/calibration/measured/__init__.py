"""Measured sets: folders of rows and what is known of them, a bench for each kind, and what the models leave of them."""
