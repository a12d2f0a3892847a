"""The arm with the largest workspace in a box: its lengths, position and joint limits are design variables.

    python examples/workspace_in_a_box.py [FOLDER]

The area is maximized, and tip and elbow must remain in the box. SciPy's SLSQP uses the exact gradients of the area and
of the extreme positions.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import LinearConstraint, minimize

import sarrus as sr

DEGREE = np.pi / 180
BOX = np.array([[-1.0, 1.0], [0.0, 1.1]])  # lowest and highest x, y [m]
WIDEST = 150 * DEGREE  # range of a hinge
# pivot x, y; lengths of the links; lowest and highest angle of the shoulder, of the elbow
START = np.array([0.0, 0.05, 0.4, 0.35, *(np.array([40, 110, 25, 100]) * DEGREE)])
BOUNDS = [
    (-1, 1),
    (0, 1.1),
    (0.1, 2),
    (0.1, 2),
    (-np.pi, np.pi),
    (-np.pi, np.pi),
    (15 * DEGREE, 3.0),
    (0.3, 3.0),
]
NARROW = LinearConstraint([[0, 0, 0, 0, -1, 1, 0, 0], [0, 0, 0, 0, 0, 0, -1, 1]], 10 * DEGREE, WIDEST)


class Arm:
    """Two links with revolute joints; `x` as in `START`."""

    def __init__(self, x: np.ndarray) -> None:
        px, py, first, second, *angles = (float(number) for number in x)
        upper = sr.Body("upper", mass=1, inertia=(1, 1, 1), position=(px, py, 0))
        lower = sr.Body("lower", mass=1, inertia=(1, 1, 1), position=(px + first, py, 0))
        shoulder = sr.Revolute("q1", sr.ground, upper, point=(px, py, 0), axis=(0, 0, 1))
        elbow = sr.Revolute("q2", upper, lower, point=(px + first, py, 0), axis=(0, 0, 1))
        self.system = sr.System(sr.Model("arm", bodies=[upper, lower], joints=[shoulder, elbow]))
        self.tip, self.elbow = lower.point(second, 0, 0), lower.point(0, 0, 0)
        self.limits = {"q1": (angles[0], angles[1]), "q2": (angles[2], angles[3])}

    def area(self) -> tuple[sr.Workspace, np.ndarray]:
        """The workspace of the tip, and the gradient of its area."""
        found = sr.workspace(self.system, self.tip["x", "y"], limits=self.limits, verify=False)
        return found, gathered(sr.area_gradient(found, [*COMMON, *TIP.values()]), TIP.values())

    def reaches(self) -> tuple[np.ndarray, np.ndarray]:
        """Distances of tip and elbow from the four sides of the box, with their gradients."""
        rooms, rates = [], []
        for point in (self.tip, self.elbow):
            for k, axis in enumerate("xy"):
                found = sr.workspace_range(self.system, point[axis], limits=self.limits, repeats=12)
                for sign, value, side in zip(
                    (1, -1), (found.intervals[0][0], found.intervals[-1][1]), BOX[k]
                ):
                    own = [TIP[axis]] if point is self.tip else []
                    by = sr.end_gradient(found, value, [*COMMON, *own])
                    rooms.append(sign * (value - side))
                    rates.append(sign * gathered(by, own))
        return np.array(rooms), np.array(rates)


COMMON = [  # parameters of the model and limits, in the order of the design without the second length
    *(f"q1[point].s_i.{axis}" for axis in "xy"),
    "q2[point].s_i.x",
    *(f"{hinge}.angle {end}" for hinge in ("q1", "q2") for end in ("lowest", "highest")),
]
TIP = {
    axis: f"lower.{axis}[{axis}].s_j.x" for axis in "xy"
}  # the name of the second length in each coordinate of the tip


def gathered(by: sr.ShapeDerivative, lengths: object) -> np.ndarray:
    """A derivative with respect to the design."""
    common = [by[name] for name in COMMON]
    return np.array([*common[:3], sum(by[name] for name in lengths), *common[3:]])


class Search:
    """Objective and constraints for SLSQP; each design is evaluated once."""

    def __init__(self) -> None:
        self.count, self._last, self._known = 0, None, {}

    def __call__(self, x: np.ndarray, what: str) -> tuple:
        if self._last is None or not np.array_equal(x, self._last):
            self._last, self._known = x.copy(), {}
        if what not in self._known:
            arm = Arm(x)
            self._known[what] = arm.area() if what == "area" else arm.reaches()
            self.count += what == "area"
        return self._known[what]

    def best(self, iterations: int) -> np.ndarray:
        inside = {"type": "ineq", "fun": lambda x: self(x, "reach")[0], "jac": lambda x: self(x, "reach")[1]}
        found = minimize(
            lambda x: -self(x, "area")[0].area,
            START,
            jac=lambda x: -self(x, "area")[1],
            method="SLSQP",
            bounds=BOUNDS,
            constraints=[inside, NARROW],
            options={"maxiter": iterations, "ftol": 1e-7},
            callback=lambda x: print(f"area {self(x, 'area')[0].area:.5f} m²"),
        )
        return np.asarray(found.x)


def main(folder: str | Path = ".", iterations: int = 40) -> tuple[float, float, float]:
    """Area before and after, and the least distance from the sides of the box."""
    search = Search()
    x = search.best(iterations)
    before, after = Arm(START), Arm(x)
    first, last, room = before.area()[0], after.area()[0], float(after.reaches()[0].min())
    print(f"from {first.area:.4f} to {last.area:.4f} m² in {search.count} maps; margin {room:.1e} m")
    print(
        f"pivot {x[0]:.3f}, {x[1]:.3f}; links {x[2]:.3f}, {x[3]:.3f} m; angles {np.round(x[4:] / DEGREE, 1)}°"
    )
    draw([first, last], Path(folder))
    return first.area, last.area, room


def draw(maps: list[sr.Workspace], folder: Path) -> None:
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    figure = Figure(figsize=(10, 4.4), layout="constrained")
    for ax, found, told in zip(figure.subplots(1, 2), maps, ("at first", "best")):
        found.plot(ax)
        ax.add_patch(
            Rectangle(BOX[:, 0], *np.ptp(BOX, axis=1), fill=False, linestyle="--", edgecolor="black")
        )
        ax.set_title(f"{told}: {found.area:.3f} m²", loc="left", fontsize=10)
        ax.margins(0.06)
    figure.savefig(folder / "workspace_in_a_box.png", dpi=70)


if __name__ == "__main__":
    main(*sys.argv[1:])
