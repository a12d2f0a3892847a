"""Events of a run: their functions, and the search for their times."""
