"""Linear algebra without mechanics: sparse and dense factors, pivots, rank, least-norm solutions.

Nothing here knows a system; only this folder chooses between dense and sparse.
"""
