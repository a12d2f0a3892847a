"""Dexterity of a mechanism over its workspace: values on a grid."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ...algebra import Array
from ...deferred import renderer
from ...model import ModelError
from ...model.show import show
from ..saving.exported_file import exports, write_table
from ..saving.netcdf import Column, write_netcdf
from .workspace import MapResult, Status, Workspace

Quantity = Literal[
    "solutions",
    "manipulability",
    "worst_manipulability",
    "conditioning",
    "worst_conditioning",
    "turn",
]
MEANINGS: dict[Quantity, str] = {
    "solutions": "solutions of the inverse kinematics",
    "manipulability": "manipulability √det J Jᵀ, of the best solution",
    "worst_manipulability": "manipulability √det J Jᵀ, of the worst solution",
    "conditioning": "conditioning (smallest over largest singular value of J), of the best solution",
    "worst_conditioning": "conditioning (smallest over largest singular value of J), of the worst solution",
    "turn": "range of orientation",
}


@dataclass(frozen=True)
class WorkspaceField(MapResult):
    """Result of `workspace_field`: quantities on a grid, nan outside of the workspace.

    Attributes
    ----------
    workspace : on which the grid lies
    inputs : by which J takes derivatives; `turn` the name of the function whose range is computed
    x, y : (nx,), (ny,) values of the outputs
    values : quantity -> (ny, nx)
    positions : number of positions of the mechanism
    missed : cells inside the boundary without a solution
    status : "mapped"; "incomplete" if cells were missed; "time limit" or "stopped" (by the user)
    """

    workspace: Workspace = field(repr=False)
    inputs: tuple[str, ...]
    turn: str
    x: Array = field(repr=False)
    y: Array = field(repr=False)
    values: dict[Quantity, Array] = field(repr=False)
    positions: int
    missed: int
    status: Status = "mapped"

    @property
    def name(self) -> str:
        """The name of the system."""
        return self.workspace.name

    def meaning(self, quantity: Quantity) -> str:
        """Return the meaning of a quantity as text."""
        if quantity not in (*MEANINGS,):
            raise ModelError(f"quantity: there is no {show(quantity)}. Choose one of {', '.join(MEANINGS)}.")
        message = MEANINGS[quantity]
        return f"{message} {self.turn} [rad]" if quantity == "turn" else message

    def to_csv(self, path: Any) -> None:
        """Write one line for each cell inside: both outputs, then all quantities."""
        x, y = np.meshgrid(self.x, self.y)
        columns = [x, y, *self.values.values()]
        inside = np.isfinite(columns[2:]).any(axis=0)
        rows = np.stack([one[inside] for one in columns], axis=1).tolist()
        write_table(path, [*self.workspace.outputs, *self.values], rows)

    @exports
    def to_netcdf(self, path: Any) -> None:
        """Write the grid in the NetCDF format: x, y, and an array (y, x) for each quantity."""
        names, units = self.workspace.outputs, self.workspace.units
        message = [{"long_name": name, "units": unit} for name, unit in zip(names, units, strict=True)]
        columns = {"x": Column(("x",), self.x, message[0]), "y": Column(("y",), self.y, message[1])}
        for quantity, values in self.values.items():
            meaning = {"long_name": self.meaning(quantity)}
            columns[quantity] = Column(("y", "x"), values, meaning)
        write_netcdf(path, columns, {"title": self.name, "inputs": ", ".join(self.inputs)})

    def plot(self, quantity: Quantity | None = None, ax: Any = None) -> Any:
        """Draw one quantity inside the boundary; see `sarrus.views.plot_workspace_field`."""
        return renderer().plot_workspace_field(self, quantity, ax)

    def summary(self) -> str:
        """The result in words."""
        inside = np.count_nonzero(np.isfinite(next(iter(self.values.values()))))
        lines = [
            f"{self.name}: a grid of {len(self.x)} x {len(self.y)} places, {self.positions} positions of the "
            f"mechanism, on {inside} places inside the boundary."
        ]
        for quantity, values in self.values.items():
            known = values[np.isfinite(values)]
            if len(known):
                message = f"from {known.min():.4g} to {known.max():.4g}, median {np.median(known):.4g}"
                message = f"{known.min():.4g} everywhere" if known.min() == known.max() else message
                meaning = self.meaning(quantity)
                lines.append(f"{meaning[0].upper()}{meaning[1:]}: {message}.")
        if self.missed:
            lines.append(f"At {self.missed} places inside the boundary no position was found.")
        return "\n".join(lines)
