"""Transmission elements: what turns cylinder or motor power into link or load power."""
