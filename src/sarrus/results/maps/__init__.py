"""Results of workspace analyses: regions, volumes, ranges, fields, singular curves, and tests of points."""
