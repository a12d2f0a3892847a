"""Bodies: mass, inertia, shape, and the ground."""
