"""Driven motion: kinematics, inverse dynamics and singular configurations of systems without freedom."""
