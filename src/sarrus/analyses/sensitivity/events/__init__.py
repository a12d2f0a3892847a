"""Events differentiated once and twice, and the chain of a run that has some."""
