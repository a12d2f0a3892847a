"""Workspaces of three outputs: slices, their integral between critical heights, surfaces and shape derivatives."""
