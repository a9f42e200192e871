"""Drives over a cycle: energy, heat and limits of a motion, the shaking plane, the cylinder's speed."""
