"""Displays and machines in the hand of a user: stability, impedances that can be felt, passivity, and limits."""
