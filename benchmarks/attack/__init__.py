"""Attacks on the readers and functions of Sarrus; see ``benchmarks/fuzz.py``."""
