"""Machines of rolling contacts, and their rivals with a motor for each link: kinds, equations in time, and control."""
