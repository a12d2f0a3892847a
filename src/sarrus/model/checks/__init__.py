"""Checks of user input: arguments, names, units, connections, rates; and where in a file an error is."""
