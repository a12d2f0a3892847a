"""A run without events differentiated: its start, its steps, and the sweeps over all of them."""
