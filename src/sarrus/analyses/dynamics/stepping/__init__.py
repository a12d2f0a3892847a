"""One step of an implicit method: its compiled loop, its size, its tolerances, its matrices, and why it fails."""
