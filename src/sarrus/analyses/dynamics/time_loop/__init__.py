"""The time integration loop, the same for all methods, and the checks that it makes of a motion."""
