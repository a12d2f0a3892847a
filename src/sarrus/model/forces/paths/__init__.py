"""Parts of the path of a tendon: segments around shapes, and the inertia of what moves along with it."""
