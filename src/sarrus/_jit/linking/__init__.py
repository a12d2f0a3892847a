"""Compiled functions: linked, cached on disk, checked for references."""
