"""The tree of a robot: spanning a graph of links and joints, merging links that move as one, placing coordinates."""
