"""Pictures: figures with Matplotlib (the extra `plot`), imported when the first is drawn, and pages for the browser."""

from .gradients import gradient_table, optimum_table, plot_convergence, plot_gradient, tornado_figure
from .histories import plot, plot_energies, plot_phase, plot_sensitivities, plot_steps, plot_violation
from .input_singularities import plot_input_singularities
from .mechanism import mechanism_figure
from .mode_shapes import animate_mode
from .modes import modes_table, plot_modes
from .plots import check_figure, motion_figure
from .reactions import plot_reaction
from .shows import animate, view
from .studies import plot_study
from .tables import paper_tables
from .workspace import plot_workspace
from .workspace_field import plot_workspace_field
from .workspace_surface import view_workspace
from .workspace_volume import plot_workspace_volume
from .workspace_words import workspace_report

__all__ = [
    "animate",
    "animate_mode",
    "check_figure",
    "gradient_table",
    "mechanism_figure",
    "modes_table",
    "motion_figure",
    "optimum_table",
    "paper_tables",
    "plot",
    "plot_convergence",
    "plot_energies",
    "plot_gradient",
    "plot_input_singularities",
    "plot_modes",
    "plot_phase",
    "plot_reaction",
    "plot_sensitivities",
    "plot_steps",
    "plot_study",
    "plot_violation",
    "plot_workspace",
    "plot_workspace_field",
    "plot_workspace_volume",
    "tornado_figure",
    "view",
    "view_workspace",
    "workspace_report",
]
