"""Figures with Matplotlib (`figures`, the extra `plot`), and drawings in three dimensions: pages, pictures, films, GLB.

A drawing is made in three steps: `meshes` are triangles, `looks` makes a model into moving meshes, and `browser`,
`film` or `glb` write them. Views compute nothing that a result could hold. Matplotlib is imported when the first figure
is drawn.
"""

from typing import TYPE_CHECKING

from ..exports import on_demand

if TYPE_CHECKING:
    from .figures.fit import plot_fit as plot_fit
    from .figures.frequency_response import plot_frequency_response as plot_frequency_response
    from .figures.gradients import gradient_table as gradient_table
    from .figures.gradients import optimum_table as optimum_table
    from .figures.gradients import plot_convergence as plot_convergence
    from .figures.gradients import plot_gradient as plot_gradient
    from .figures.histories import plot as plot
    from .figures.histories import plot_energies as plot_energies
    from .figures.histories import plot_energy_balance as plot_energy_balance
    from .figures.histories import plot_phase as plot_phase
    from .figures.histories import plot_reaction as plot_reaction
    from .figures.histories import plot_sensitivities as plot_sensitivities
    from .figures.histories import plot_steps as plot_steps
    from .figures.histories import plot_violation as plot_violation
    from .figures.input_singularities import plot_input_singularities as plot_input_singularities
    from .figures.mechanism import mechanism_figure as mechanism_figure
    from .figures.modes import modes_table as modes_table
    from .figures.modes import plot_modes as plot_modes
    from .figures.study import plot_study as plot_study
    from .figures.suspension import plot_suspension as plot_suspension
    from .figures.tyre import tyre_figure as tyre_figure
    from .figures.workspace import plot_workspace as plot_workspace
    from .figures.workspace import plot_workspace_field as plot_workspace_field
    from .figures.workspace_report import workspace_report as workspace_report
    from .notebook import notebook_html as notebook_html
    from .shows import animate as animate
    from .shows import animate_mode as animate_mode
    from .shows import view as view
    from .workspace_volume import plot_workspace_volume as plot_workspace_volume
    from .workspace_volume import view_workspace as view_workspace
else:
    __getattr__ = on_demand(__name__, __file__)
