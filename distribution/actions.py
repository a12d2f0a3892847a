"""First uses of Sarrus, whose kernels a wheel holds: `python distribution/actions.py NAME` runs one and times it.

It prints the processor time of the first call of an action in this process, and of the second, which compiles and
loads nothing.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.integration_methods import STORING_STEPS, method_named
from sarrus.cli import main as cli

ROOT = Path(__file__).resolve().parent.parent
Action = Callable[[], object]
TRACED: dict[str, Callable[[], Any]] = {  # their steps have derivatives
    **{name: method_named(name) for name in STORING_STEPS},
    "stabilized": partial(sr.HHT, stabilized=True),
}
METHODS = {**TRACED, "ode": sr.ODE}  # the other solvers need packages that a wheel does not ask for


def shipped(name: str) -> sr.System:
    """A mechanism of the package."""
    return sr.System(sr.load(mechanisms.path(name)))


def zoo(name: str) -> sr.System:
    """A mechanism with every built-in element."""
    sys.path.insert(0, str(ROOT))
    from tests.sensitivity.zoo import zoo as made

    return made()


def motion(system: Callable[[str], sr.System], name: str, **options: Any) -> sr.Trajectory:
    """A short run."""
    return sr.simulate(system(name), until=0.2, rtol=1e-4, atol=1e-5, **options)


def stored(system: Callable[[str], sr.System], name: str, method: str | None) -> sr.Trajectory:
    """A short run that can be differentiated; by the default method without a name."""
    chosen = {} if method is None else {"method": METHODS[method]()}
    return motion(system, name, store_steps=True, **chosen)


def responses(run: sr.Trajectory) -> list[Any]:
    """A final value, an extreme and an integral of the last body's place, and one of energy."""
    output = f"{list(run.system.model.bodies)[-1].name}.z"
    return [sr.Final(output), sr.Maximum(output), sr.Integral(output), sr.Final("energy.kinetic")]


def some(run: sr.Trajectory) -> list[str]:
    """Three parameters."""
    return list(run.system.parameter_names)[:3]


def gradient(system: Any, name: str, method: str | None, direction: str = "adjoint") -> object:
    run = stored(system, name, method)
    wrt = None if direction == "adjoint" else some(run)
    return sr.sensitivity(run, responses(run), wrt, method=direction)


def hessian(system: Any, name: str, method: str | None) -> object:
    run = stored(system, name, method)
    return sr.hessian(run, responses(run)[0], some(run))


def states(system: Any, name: str, method: str | None) -> object:
    run = stored(system, name, method)
    return sr.state_derivatives(run, some(run))


def driven_arm() -> sr.System:
    """An arm of two links with motors."""
    links = [sr.Body(f"link_{n}", mass=1.0, inertia=(1, 1, 1), position=(n + 0.5, 0, 0)) for n in (0, 1)]
    ends = [sr.ground, *links]
    pins = [sr.Revolute(f"q{n}", *ends[n : n + 2], point=(n, 0, 0), axis=(0, 0, 1)) for n in (0, 1)]
    return sr.System(sr.Model("arm", links, pins, gravity=(0, 0, -9.81)))


def pendulum() -> sr.System:
    """An arm with gravity in its plane."""
    model = driven_arm().model
    return sr.System(sr.Model("pendulum", model.bodies, model.joints, gravity=(0, -9.81, 0)))


LIMITS = {"q0": (-1.0, 1.0), "q1": (0.3, 1.2)}


def tip(system: sr.System) -> Any:
    return list(system.model.bodies)[-1].point(0.5, 0, 0)


def workspace() -> object:
    system = driven_arm()
    return sr.workspace(system, tip(system)["x", "y"], limits=LIMITS, samples=100, rays=6)


def field() -> object:
    system = driven_arm()
    found = sr.workspace(system, tip(system)["x", "y"], limits=LIMITS, verify=False)
    return sr.workspace_field(found, inputs=("q0", "q1"), cells=8, starts=20)


def reach() -> object:
    return sr.workspace_range(shipped("slider_crank"), "slider.x")


def kinematics() -> object:
    """The arm, moved by two motors."""
    arm = driven_arm().model
    motors = [sr.AngleDriver(f"motor_{n}", f"q{n}", f"{n + 1}*t") for n in (0, 1)]
    model = sr.Model("driven", arm.bodies, arm.joints, drivers=motors)
    return sr.kinematics(sr.System(model), [0.0, 0.1, 0.2])


def equilibrium() -> object:
    return sr.equilibrium(pendulum())


def modes() -> object:
    system = pendulum()
    return sr.modes(system, sr.equilibrium(system))


def linearize() -> object:
    system = pendulum()
    return sr.linearize(system, sr.equilibrium(system))


def events() -> object:
    stop = sr.Event("slider.x - 4.17", terminal=True)
    run = motion(shipped, "slider_crank", store_steps=True, events=[stop])
    return sr.sensitivity(run, sr.Final("slider.x"))


def check() -> object:
    return shipped("slider_crank").check_derivatives()


def view() -> object:
    """The page of a model."""
    with tempfile.TemporaryDirectory() as folder:
        return sr.load(mechanisms.path("slider_crank")).view(Path(folder) / "page.html")


def demo() -> object:
    """The command `sarrus demo`; what it prints does not mix with the times."""
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(sys.stderr):
        code = cli(["demo", "--quiet", "--output", folder])
    if code:
        raise RuntimeError(f"sarrus demo: it ended with code {code}. Run it to see why.")
    return code


def _actions() -> Mapping[str, Action]:
    """All actions by name."""
    found: dict[str, Action] = {
        "simulate": partial(motion, shipped, "slider_crank"),
        "sensitivity": partial(gradient, shipped, "slider_crank", None),
        "hessian": partial(hessian, shipped, "slider_crank", None),
        "equilibrium": equilibrium,
        "modes": modes,
        "linearize": linearize,
        "kinematics": kinematics,
        "workspace": workspace,
        "workspace_range": reach,
        "workspace_field": field,
        "events": events,
        "check_derivatives": check,
        "view": view,
        "demo": demo,
    }
    for name in mechanisms.names():
        for method in METHODS:
            run = stored if method in TRACED else partial(motion, method=METHODS[method]())
            found[f"simulate-{name}-{method}"] = partial(run, shipped, name, *[method] * (method in TRACED))
        for method in TRACED:
            found[f"sensitivity-{name}-{method}"] = partial(gradient, shipped, name, method)
            found[f"direct-{name}-{method}"] = partial(gradient, shipped, name, method, "direct")
            found[f"hessian-{name}-{method}"] = partial(hessian, shipped, name, method)
            found[f"states-{name}-{method}"] = partial(states, shipped, name, method)
    found["elements-sensitivity"] = partial(gradient, zoo, "all", None)
    found["elements-direct"] = partial(gradient, zoo, "all", None, "direct")
    found["elements-hessian"] = partial(hessian, zoo, "all", None)
    return found


ACTIONS = _actions()


def timed(action: Action) -> tuple[float, float]:
    """Processor time [s] of a first call and of a second."""
    moments = [time.process_time()]
    for _ in range(2):
        action()
        moments.append(time.process_time())
    return moments[1] - moments[0], moments[2] - moments[1]


def main(names: list[str]) -> int:
    """Run the actions with these names; print name, first and second time as lines of JSON."""
    if unknown := [name for name in names if name not in ACTIONS]:
        print(f"{', '.join(unknown)}: unknown. There are: {', '.join(ACTIONS)}", file=sys.stderr)
        return 2
    for name in names or ACTIONS:
        print(json.dumps([name, *timed(ACTIONS[name])]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
