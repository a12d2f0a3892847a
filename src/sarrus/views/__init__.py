"""Pictures: figures with Matplotlib (the extra `plot`), imported when the first is drawn, and pages for the browser."""

from .gradients import gradient_table, optimum_table, plot_convergence, plot_gradient
from .mechanism import mechanism_figure
from .modes import modes_table, plot_modes
from .plots import check_figure, motion_figure, plot
from .reactions import plot_reaction
from .shows import animate, view
from .studies import plot_study
from .tables import paper_tables
from .workspace import plot_input_singularities, plot_workspace, workspace_report
from .workspace_volume import plot_workspace_volume

__all__ = [
    "animate",
    "check_figure",
    "gradient_table",
    "mechanism_figure",
    "modes_table",
    "motion_figure",
    "optimum_table",
    "paper_tables",
    "plot",
    "plot_convergence",
    "plot_gradient",
    "plot_input_singularities",
    "plot_modes",
    "plot_reaction",
    "plot_study",
    "plot_workspace",
    "plot_workspace_volume",
    "view",
    "workspace_report",
]
