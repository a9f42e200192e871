"""Transmission elements between the cylinder and the link."""
