"""Contact mechanics: pure functions over arrays."""
