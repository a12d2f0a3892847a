"""Figures with Matplotlib (the extra `plot`), and the tables of the same results as text.

A figure draws one result, and imports Matplotlib when it is called. Drawings in three dimensions are in `sarrus.views`.
"""
