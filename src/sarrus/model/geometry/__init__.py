"""Points, frames, poses and rotations of the initial position, and functions of the position."""
