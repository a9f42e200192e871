"""Sessions of a user at the handle of a machine, and displays in the hand: stability, impedances, passivity, and limits."""
