"""Implicit methods as data: each file describes the step of one method, see `description`. No algorithm lives here."""
