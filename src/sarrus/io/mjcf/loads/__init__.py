"""Loads of an MJCF model: joint dynamics, limits, contacts, tendons, actuators and compensated weights."""
