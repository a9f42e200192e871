"""Virtual constraints: curves, surfaces and fixtures that a machine presents to its user, and the tasks made of them."""
