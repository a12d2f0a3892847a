"""XML files with line numbers: elements, their attributes as numbers and poses, and what an import does not use."""
