"""Positions of the feet of a planar platform, each in its box, that maximize the workspace at a fixed orientation.

    python examples/largest_workspace.py [FOLDER]

A quasi-Newton method with bounds uses the exact gradient of the area with respect to the positions of the feet. Every
evaluation maps the workspace again.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import sarrus as sr

CORNERS = [(-0.5, -0.29), (0.5, -0.29), (0.0, 0.58)]
BOXES = [(0.0, 0.6), (0.0, 0.6), (2.4, 3.0), (0.0, 0.6), (1.0, 2.0), (1.8, 2.6)]  # x1, y1, x2, y2, x3, y3 [m]
LEGS = (0.8, 2.2)
START = np.array([0.1, 0.2, 2.8, 0.1, 1.2, 2.5])


def mapped(feet: np.ndarray) -> sr.Workspace:
    """Workspace of the centre of the platform, without rotation, for the feet x1, y1, x2, y2, x3, y3."""
    plate = sr.Body("platform", mass=1, inertia=(1, 1, 1), position=(1.5, 1.0, 0))
    plane = sr.Planar("plane", sr.ground, plate, point=(0, 0, 0), axis=(0, 0, 1))
    legs = {
        sr.Length(sr.ground.point(*foot, 0), plate.point(*corner, 0), f"leg {n}"): LEGS
        for n, (foot, corner) in enumerate(zip(feet.reshape(3, 2), CORNERS, strict=True), start=1)
    }
    system = sr.System(sr.Model("platform", bodies=[plate], joints=[plane]))
    output = plate.point(0, 0, 0)["x", "y"]
    return sr.workspace(system, output, limits=legs, fixed={sr.Rotation(plate): 0.0}, verify=False)


def less_area(feet: np.ndarray) -> tuple[float, np.ndarray]:
    """The negative area with its gradient."""
    found = mapped(feet)
    names = [f"leg {n}[length].s_i.{axis}" for n in (1, 2, 3) for axis in "xy"]
    by = sr.area_gradient(found, names)
    print(f"area {found.area:.6f} m² for feet {np.round(feet, 4)}")
    return -found.area, -np.array([by[name] for name in names])


def main(folder: str | Path = ".", iterations: int = 12) -> tuple[float, float]:
    best = minimize(
        less_area, START, jac=True, method="L-BFGS-B", bounds=BOXES, options={"maxiter": iterations}
    )
    before, after = mapped(START), mapped(best.x)
    print(f"from {before.area:.4f} to {after.area:.4f} m² in {best.nfev} maps")
    draw(before, after, Path(folder))
    return before.area, after.area


def draw(before: sr.Workspace, after: sr.Workspace, folder: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.6), layout="constrained")
    for ax, found, told in zip(figure.subplots(1, 2), (before, after), ("at first", "best")):
        found.plot(ax)
        ax.set_title(f"{told}: {found.area:.3f} m²", loc="left", fontsize=10)
    figure.savefig(folder / "largest_workspace.png", dpi=60)


if __name__ == "__main__":
    main(*sys.argv[1:])
