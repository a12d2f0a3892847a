"""The segments of a run differentiated: the start, the steps, and the sweeps over them."""
