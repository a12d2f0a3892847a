"""Kernels: a recorded formula written as a compiled function, for one element or a lane of many."""
