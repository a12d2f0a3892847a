"""Events differentiated once and twice."""
