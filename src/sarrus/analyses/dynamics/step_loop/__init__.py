"""The compiled loop of steps of described methods."""
