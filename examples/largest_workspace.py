"""Where the feet of a planar platform should stand, each in its box, so that it reaches most at a fixed orientation.

    python examples/largest_workspace.py

The area's exact gradient by the feet's places drives a quasi-Newton method within bounds; every evaluation maps the
workspace anew.
"""

import numpy as np
from scipy.optimize import minimize

import sarrus as sr

CORNERS = [(-0.5, -0.29), (0.5, -0.29), (0.0, 0.58)]
BOXES = [(0.0, 0.6), (0.0, 0.6), (2.4, 3.0), (0.0, 0.6), (1.0, 2.0), (1.8, 2.6)]  # x1, y1, x2, y2, x3, y3 [m]
LEGS = (0.8, 2.2)
START = np.array([0.1, 0.2, 2.8, 0.1, 1.2, 2.5])


def mapped(feet: np.ndarray) -> sr.Workspace:
    """The places of the platform's middle, the platform not turned, with feet x1, y1, x2, y2, x3, y3."""
    plate = sr.Body("platform", mass=1, inertia=(1, 1, 1), position=(1.5, 1.0, 0))
    plane = sr.Planar("plane", sr.ground, plate, point=(0, 0, 0), axis=(0, 0, 1))
    legs = {
        sr.Length(sr.ground.point(*foot, 0), plate.point(*corner, 0), f"leg {n}"): LEGS
        for n, (foot, corner) in enumerate(zip(feet.reshape(3, 2), CORNERS, strict=True), start=1)
    }
    system = sr.System(sr.Model("platform", bodies=[plate], joints=[plane]))
    output = plate.point(0, 0, 0)["x", "y"]
    return sr.workspace(system, output, limits=legs, fixed={sr.Turn(plate): 0.0}, verify=False)


def less_area(feet: np.ndarray) -> tuple[float, np.ndarray]:
    """The negative area with its gradient."""
    found = mapped(feet)
    names = [f"leg {n}[length].s_i.{axis}" for n in (1, 2, 3) for axis in "xy"]
    by = sr.area_gradient(found, names)
    print(f"area {found.area:.6f} m² for feet {np.round(feet, 4)}")
    return -found.area, -np.array([by[name] for name in names])


def main() -> None:
    best = minimize(less_area, START, jac=True, method="L-BFGS-B", bounds=BOXES, options={"maxiter": 12})
    print(f"from {mapped(START).area:.4f} to {-best.fun:.4f} m² in {best.nfev} maps")


if __name__ == "__main__":
    main()
