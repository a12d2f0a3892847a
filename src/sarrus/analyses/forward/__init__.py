"""Forward dynamics as a function of the state, with derivatives."""
