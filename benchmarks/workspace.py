"""Workspaces by continuation: time, work and error, beside maps by grids of kinematic solutions.

    python benchmarks/workspace.py [--json] [--repeats 3]

Every mechanism is mapped with all its barriers, warm, on one core (its processor time is told); the error is that of
the area, known in closed form. A grid map takes one kinematic solution for each of its points; its error is found
with the exact boundary, so that only the number of solutions is compared, not anybody's inverse kinematics.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

AREAS = {
    "arm_3r": 31.497510350119,
    "five_bar": 11.788984798867766,
    "platform": 4.160783189447891,
    "platform_with_legs": 4.160783189447891,
}
ENOUGH = 1e-4  # error of the area, relative, at which numbers of kinematic solutions are compared
GRIDS = (50, 100, 200, 400, 800, 1600)


def platform_with_legs() -> Any:
    """The platform of Haug et al. with legs of two bodies each: 7 bodies, three redundant equations in each loop."""
    import sarrus as sr

    feet, radius = [np.array(foot) for foot in ((-1.0, 0.0), (1.0, 0.0), (2.0, 0.0))], 1.0
    limits = [(2**0.5, 2.0), (2**0.5, 2.0), (1.0, 3.0)]
    centre = np.array([1.0, 1.6])
    plate = sr.Body("platform", mass=1, inertia=(1, 1, 1), position=(*centre, 0))
    ends = [centre - (radius, 0), centre - (radius, 0), centre + (radius, 0)]
    bodies, joints, lengths = [plate], [], {}
    for n, (foot, end, pair) in enumerate(zip(feet, ends, limits, strict=True), start=1):
        along = (end - foot) / np.linalg.norm(end - foot)
        frame = {"orientation": _turned(along)}
        barrel = sr.Body(f"barrel_{n}", mass=1, inertia=(1, 1, 1), position=(*foot, 0), **frame)
        rod = sr.Body(f"rod_{n}", mass=1, inertia=(1, 1, 1), position=(*end, 0), **frame)
        joints += [
            sr.Revolute(f"foot_{n}", sr.ground, barrel, point=(*foot, 0), axis=(0, 0, 1)),
            sr.Translational(f"leg_{n}", barrel, rod, point=(*foot, 0), axis=(*along, 0)),
            sr.Revolute(f"corner_{n}", rod, plate, point=(*end, 0), axis=(0, 0, 1)),
        ]
        bodies += [barrel, rod]
        drawn = float(np.linalg.norm(end - foot))  # where the displacement is zero
        lengths[f"leg_{n}"] = (pair[0] - drawn, pair[1] - drawn)
    system = sr.System(sr.Model("3-RPR with legs", bodies=bodies, joints=joints))
    return system, plate.point(0, 0, 0)["x", "y"], lengths


def _turned(along: Any) -> tuple[float, ...]:
    half = 0.5 * float(np.arctan2(along[1], along[0]))
    return (np.cos(half), 0.0, 0.0, np.sin(half))


def cases() -> dict[str, Any]:
    from tests.workspace.mechanisms import arm_3r, five_bar, platform_haug

    return {
        "arm_3r": arm_3r,
        "five_bar": five_bar,
        "platform": platform_haug,
        "platform_with_legs": platform_with_legs,
    }


@contextmanager
def counting() -> Iterator[Callable[[], tuple[int, int]]]:
    """Count the points of curves and Newton's steps, those of searches for starting points among them.

    Each of Newton's steps on a curve solves with its factors once, the tangent at each point twice, and only a tangent
    takes their sign.
    """
    from sarrus.analyses.workspace.problem import settle
    from sarrus.analyses.workspace.tracing.stratum import Factors

    def counted(owner: Any, name: str) -> Any:
        return patch.object(owner, name, autospec=True, side_effect=getattr(owner, name))

    with (
        counted(Factors, "solve") as solved,
        counted(Factors, "sign") as signs,
        counted(settle, "damped_step") as damped,
    ):
        yield lambda: (signs.call_count, solved.call_count - 2 * signs.call_count + damped.call_count)


def measured(case: Any, area: float, repeats: int) -> tuple[dict[str, float], Any]:
    """The best of some runs, after one that compiles."""
    import sarrus as sr
    from sarrus.analyses.workspace.analysis import checked_workspace

    system, output, limits = case()
    best = np.inf
    with counting() as count:
        found = sr.workspace(system, output, limits=limits, verify=False)
    for _ in range(repeats):
        start = time.process_time()
        found = sr.workspace(system, output, limits=limits, verify=False)
        best = min(best, time.process_time() - start)
    start = time.process_time()
    tested = checked_workspace(found, samples=2000, rays=40)
    testing = time.process_time() - start
    points, newton_steps = count()
    return {
        "seconds": best,
        "testing_seconds": testing,
        "tests_passed": bool(tested.success),
        "curves": len(found.curves),
        "points": points,
        "points_per_second": points / best,
        "newton_steps_per_point": newton_steps / points,
        "solutions": newton_steps,
        "area_error": abs(found.area / area - 1),
        "unknowns": found.map.problem.n,
    }, found


def grids(found: Any, area: float) -> dict[int, float]:
    """The error of the area by grids of points, each of which costs a kinematic solution."""
    corners = np.concatenate([curve.u for curve in found.boundary])
    low, high = corners.min(axis=0), corners.max(axis=0)
    errors = {}
    for n in GRIDS:
        x, y = (a + (b - a) * (np.arange(n) + 0.5) / n for a, b in zip(low, high, strict=True))
        inside = found.contains(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
        errors[n] = abs(float(np.count_nonzero(inside)) / n**2 * float((high - low).prod()) / area - 1)
    return errors


def area_of_box(found: Any) -> float:
    """The area of the box around the boundary."""
    corners = np.concatenate([curve.u for curve in found.boundary])
    return float(np.ptp(corners, axis=0).prod())


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--repeats", type=int, default=3)
    chosen = parser.parse_args()
    figures: dict[str, Any] = {}
    for name, case in cases().items():
        mine, found = measured(case, AREAS[name], chosen.repeats)
        figures |= {f"{name}.{key}": value for key, value in mine.items()}
        if name == "platform":
            errors = grids(found, AREAS[name])
            figures |= {f"grid.{n}x{n}.area_error": error for n, error in errors.items()}
            n, error = max(errors.items())
            figures["platform.grid_solutions_over_ours"] = n * n / mine["solutions"]
            figures["platform.grid_error_over_ours"] = error / mine["area_error"]
            enough = [size for size, error in errors.items() if error < ENOUGH]
            figures["platform.grid_solutions_for_1e-4_over_ours"] = min(enough) ** 2 / mine["solutions"]
            share = AREAS[name] / area_of_box(found)
            monte_carlo = (1 - share) / share / ENOUGH**2  # samples for this standard deviation
            figures["platform.monte_carlo_solutions_for_1e-4_over_ours"] = monte_carlo / mine["solutions"]
    if chosen.json:
        print(json.dumps(figures, indent=1))
        return
    for name, value in figures.items():
        print(f"{name:<42} {value:.6g}" if isinstance(value, float) else f"{name:<42} {value}")


if __name__ == "__main__":
    main()
