"""Loads of a robot: springs, dampers, friction, stops, tendons and actuators of a description, as parts of a model."""
