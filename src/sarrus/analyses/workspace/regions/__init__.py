"""Regions of two outputs: the plane divided by curves, its cells labelled, and the map verified."""
