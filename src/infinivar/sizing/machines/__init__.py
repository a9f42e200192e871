"""Search for the best motors, gearheads and wheels of machines with several coordinates."""
