"""The text of a model file, YAML or JSON, read to plain data with the line of every entry."""
