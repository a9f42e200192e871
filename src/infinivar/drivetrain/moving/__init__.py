"""Machines of rolling contacts in motion: equations in time of a mechanism with its motors, steering and user."""
