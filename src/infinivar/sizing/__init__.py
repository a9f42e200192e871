"""Search for the best drive among parts that can be bought."""
