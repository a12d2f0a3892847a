"""A model expanded to bodies, coordinates and elements, and checked as a whole."""
