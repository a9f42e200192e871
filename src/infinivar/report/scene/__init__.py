"""Scenes of machines in motion for MuJoCo: bodies with their masses, what guides the handle, and the recorded motion."""
