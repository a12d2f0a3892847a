"""Contracted second derivatives of forward dynamics: calls from Python and from Numba code.

    python -m benchmarks.forward_hessians

Least processor time of a call in several batches; the difference is what Python adds. Also allocations in Numba code.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from benchmarks.forward_dynamics import in_numba, in_python, least
from benchmarks.linearize import JOINTS, arm

import sarrus as sr


def servo() -> sr.System:
    """A slider-crank whose crank a motor turns."""
    model = sr.load("slider_crank")
    motor = sr.DCMotor("motor", "pin", voltage="u", resistance=0.5, inductance=0.02, constant=0.4, gear=3.0)
    u = sr.Input("u", 1.5, unit="V")
    return sr.System(sr.Model("servo", model.bodies, model.joints, [*model.forces, u, motor]))


def subjects() -> Iterator[tuple[sr.System, list[str], dict[str, float]]]:
    """Systems with their independent coordinates, and rates of motion."""
    yield arm(), [f"joint{k}.angle" for k in range(JOINTS)], {"joint0": 0.3, "joint3": -0.2}
    yield sr.System(sr.load("slider_crank")), ["pin.angle"], {"pin": 2.0}
    yield servo(), ["pin.angle"], {"pin": 2.0}


def main() -> None:
    """The table of the documentation."""
    for system, names, rates in subjects():
        start, b, f = sr.assemble(system, rates=rates), system.b, system.forward_dynamics
        q, v = start.q.copy(), start.v.copy()
        for title, of in (("independent", f.in_coordinates(names).hessian), ("all", f.hessian)):
            size = 2 * system.nq if of is f.hessian else 2 * len(names) + len(system.states)
            weights = np.ones((system.nq if of is f.hessian else size) + system.m)
            H = of(q, v, weights)
            arguments = 1e-3, b, 0.0, q, v, weights, H.copy()
            times = least(
                in_python(lambda of=of, q=q, v=v, w=weights: of(q, v, w)),
                in_numba(of.function, of.data, arguments),
            )
            print(
                f"{system.name}, {title}: {len(H)} variables, {times[0]:.1f} µs from Python, {times[1]:.1f} from"
            )
            print(f"    Numba, {times[0] - times[1]:.1f} between")


if __name__ == "__main__":
    main()
