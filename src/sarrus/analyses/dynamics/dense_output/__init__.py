"""The motion between the nodes of a run: compiled interpolation, and revolutions of angles."""
