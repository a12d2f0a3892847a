"""Plots, with Matplotlib (the extra `plot`), which is imported when the first one is drawn."""

from .mechanism import mechanism_figure
from .plots import check_figure, motion_figure, plot
from .tables import paper_tables

__all__ = ["check_figure", "mechanism_figure", "motion_figure", "paper_tables", "plot"]
