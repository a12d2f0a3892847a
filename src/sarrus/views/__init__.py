"""Figures with Matplotlib (`figures`, the extra `plot`), and drawings in three dimensions: pages, pictures, films, GLB.

A drawing is made in three steps: `meshes` are triangles, `looks` makes a model into moving meshes, and `browser`,
`film` or `glb` write them. Views compute nothing that a result could hold. Matplotlib is imported when the first figure
is drawn.
"""

from .figures.gradients import (
    gradient_table,
    optimum_table,
    plot_convergence,
    plot_gradient,
    plot_study,
    tornado_figure,
)
from .figures.histories import (
    plot,
    plot_energies,
    plot_phase,
    plot_reaction,
    plot_sensitivities,
    plot_steps,
    plot_violation,
)
from .figures.input_singularities import plot_input_singularities
from .figures.mechanism import mechanism_figure
from .figures.modes import modes_table, plot_modes
from .figures.paper_tables import paper_tables
from .figures.workspace import plot_workspace, plot_workspace_field
from .figures.workspace_report import workspace_report
from .notebook import notebook_html
from .shows import animate, animate_mode, view
from .workspace_volume import plot_workspace_volume, view_workspace

__all__ = [
    "animate",
    "animate_mode",
    "gradient_table",
    "mechanism_figure",
    "modes_table",
    "notebook_html",
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
