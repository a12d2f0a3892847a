"""Pictures: figures with Matplotlib (the extra `plot`), imported when the first is drawn, and pages for the browser."""

from .mechanism import mechanism_figure
from .modes import modes_table, plot_modes
from .plots import check_figure, motion_figure, plot
from .reactions import plot_reaction
from .shows import animate, view
from .tables import paper_tables
from .workspace import plot_workspace, workspace_report

__all__ = [
    "animate",
    "check_figure",
    "mechanism_figure",
    "modes_table",
    "motion_figure",
    "paper_tables",
    "plot",
    "plot_modes",
    "plot_reaction",
    "plot_workspace",
    "view",
    "workspace_report",
]
