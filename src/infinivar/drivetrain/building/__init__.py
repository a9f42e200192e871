"""How a drive is built: every body of both architectures, bought or derived from what it has to carry."""
