"""The operators of a system by the name of the field: constraints, inertia, forces, joints, reactions."""
