"""Steps against stiffness: implicit methods follow the motion, explicit ones the fastest vibration.

    python benchmarks/stiff.py [--json] [--quick]

Three models, each over four stiffnesses, 2 s with a tolerance of 1e-5: a rod that swings on a bushing, with vibrations
of up to 6e4 rad/s; a ball that swings on a spring instead of a thread, with up to 1e5 rad/s; and a mass of 1 kg on a
soft spring that carries one of 1e-8 kg on a stiff one, with up to 3e8 rad/s. Errors are those of the place at the end,
in m, against Radau with a tolerance of 1e-10. Where the explicit method would need more than some ten thousand steps it
goes over a part of the time alone, `DOP853.span` s, and `DOP853.steps` are those counted, times 2 s over the span.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import sarrus as sr

STIFFNESSES = (1e3, 1e5, 1e7, 1e9)
RADIANS = 2e4  # of the fastest vibration that the explicit method goes through: 4,000 to 10,000 steps
UNTIL = 2.0
RTOL = 1e-5


def swinging(k: float) -> sr.Model:
    """A rod of 1 kg, let go at rest from the horizontal, on a bushing free to turn."""
    rod = sr.Body("rod", mass=1.0, inertia=(0.001, 1 / 12, 1 / 12), position=(0.5, 0, 0))
    stiffness, damping = (k, k, k, 0, 0, 0), (1, 1, 1, 0, 0, 0)
    bushing = sr.Bushing("bushing", sr.ground, rod, point=(0, 0, 0), stiffness=stiffness, damping=damping)
    return sr.Model("rod on a bushing", [rod], forces=[bushing], gravity=(0, 0, -9.81))


def carried(k: float) -> sr.Model:
    """A mass on a spring of 100 N/m, and above it one of a hundred millionth of it."""
    heavy = sr.Body("heavy", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1.0), velocity=(0, 0, 1.0))
    light = sr.Body("rod", mass=1e-8, inertia=(1e-8, 1e-8, 1e-8), position=(0, 0, 1.5), velocity=(0, 0, 1.0))
    soft = sr.TSDA("soft", sr.ground.point(0, 0, 0), heavy.point(0, 0, 0), k=100.0, c=0.0, length=1.0)
    stiff = sr.TSDA("stiff", heavy.point(0, 0, 0), light.point(0, 0, 0), k=k, c=0.0, length=0.5)
    guides = [
        sr.Translational(f"guide_{b.name}", sr.ground, b, point=(0, 0, 0), axis=(0, 0, 1))
        for b in (heavy, light)
    ]
    return sr.Model("mass on a mass", [heavy, light], guides, [soft, stiff], gravity=(0, 0, -9.81))


def hung(k: float) -> sr.Model:
    """A ball of 1 kg on a spring of 1 m, let go at rest from the horizontal."""
    ball = sr.Body("rod", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(1.0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), ball.point(0, 0, 0), k=k, c=0.0, length=1.0)
    return sr.Model("ball on a spring", [ball], forces=[spring], gravity=(0, 0, -9.81))


MODELS: dict[str, tuple[Callable[[float], sr.Model], Callable[[float], float], float]] = {
    "bushing": (swinging, lambda k: (4 * k) ** 0.5, 1.0),
    "spring": (hung, lambda k: k**0.5, 10.0),
    "masses": (carried, lambda k: (1e8 * k) ** 0.5, 1.0),
}  # the model of a stiffness, its highest frequency [rad/s], and a factor of the stiffnesses


def measured(name: str, k: float, methods: dict[str, Any]) -> Iterator[tuple[str, float]]:
    """Steps and error of each method, under names like ``bushing.1e+05.HHT.steps``."""
    model, fastest, _ = MODELS[name]
    system = sr.System(model(k))
    exact = sr.simulate(system, until=UNTIL, t_eval=[UNTIL], method=sr.Radau(rtol=1e-10, atol=1e-12))
    yield f"{name}.{k:.0e}.fastest", fastest(k)
    for label, method in methods.items():
        span = min(UNTIL, RADIANS / fastest(k)) if label == "DOP853" else UNTIL
        run = sr.simulate(system, until=span, t_eval=[span], method=replace(method, rtol=RTOL, atol=RTOL))
        error = abs(run["rod"].position - exact["rod"].position).max() if run.success else float("nan")
        yield f"{name}.{k:.0e}.{label}.steps", run.nsteps * UNTIL / span
        if span == UNTIL:
            yield f"{name}.{k:.0e}.{label}.error", float(error)
        else:
            yield f"{name}.{k:.0e}.{label}.span", span


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="implicit methods on the bushing")
    given = parser.parse_args()
    methods: dict[str, Any] = {"HHT": sr.HHT(-0.3), "alpha": sr.GeneralizedAlpha(0.5), "Radau": sr.Radau()}
    methods["DOP853"] = sr.ODE()
    if given.quick:
        del methods["DOP853"]
    found = {}
    cases = [(name, factor * k) for name, (_, _, factor) in MODELS.items() for k in STIFFNESSES]
    if given.quick:
        cases = cases[: len(STIFFNESSES)]
    for key, value in (pair for name, k in cases for pair in measured(name, k, methods)):
        found[key] = value
        if not given.json:
            print(f"{key:32s} {value:.3g}", flush=True)
    if given.json:
        print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
