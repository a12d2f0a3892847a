"""``sarrus compile MODEL``: the kernels of a model's analyses, compiled now instead of at their first use."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from .. import model_file
from ..answer import Answer
from ..progress import Bar

if TYPE_CHECKING:
    from ...system import System

SHORT = 1e-3  # s: kernels do not depend on the end of a run
PURPOSE = "compile the kernels of a model's analyses now, instead of at their first use"
EXAMPLES = ("sarrus compile", "sarrus compile crank.yaml --method hht")
Stage = Callable[[], object]


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, by default the mechanisms of the package; the integration method, by default all."""
    from ...analyses.integration_methods import METHODS

    model_file.arguments(parser, optional=True)
    parser.add_argument("--method", choices=[*METHODS], help="only this integration method (all of Sarrus)")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Run each analysis for a moment; analyses that a model does not have are left out."""
    from ... import mechanisms
    from ...analyses.integration_methods import STORING_STEPS
    from ...model.announcement import collecting
    from ...model.errors import SarrusError
    from ...system import System

    began, done = time.perf_counter(), list[str]()
    methods = [chosen.method] if chosen.method else STORING_STEPS
    for name in [chosen.model] if chosen.model else mechanisms.names():
        chosen.model = name
        system = System(model_file.read(chosen, answer))
        stages = dict(_stages(system, methods))
        with Bar(f"compiling kernels of {system.name}", len(stages)) as bar, collecting():
            for title, stage in stages.items():
                bar.step(title)
                with suppress(SarrusError, ValueError):
                    stage()
                    done.append(f"{system.name}: {title}")
    elapsed = time.perf_counter() - began
    message = f"compiled or found in the cache: {len(done)} analyses in {elapsed:.0f} s"
    answer.show(message)
    answer.put(message=message, analyses=done, seconds=elapsed)
    return 0


def _stages(system: System, methods: list[str]) -> Iterator[tuple[str, Stage]]:
    """Analyses by name; the first ones have the kernels that others need, too."""
    from ...analyses import assemble, equilibrium, kinematics, modes

    yield "operators", system.compile
    yield "assembly", lambda: assemble(system)
    for method in methods:
        yield from _motion(system, method)
    yield "equilibrium", lambda: equilibrium(system)
    yield "modes", lambda: modes(system, equilibrium(system))
    yield "kinematics", lambda: kinematics(system, [0.0, SHORT])
    yield "check of derivatives", system.check_derivatives


def _motion(system: System, method: str) -> Iterator[tuple[str, Stage]]:
    """A run and its derivatives; by SciPy's and SUNDIALS' methods there are none."""
    from ...analyses import Final, hessian, simulate, state_derivatives
    from ...analyses.integration_methods import STORING_STEPS, method_named
    from ...analyses.sensitivity import sensitivity

    stores = method in STORING_STEPS
    runs: list[Any] = []
    some, response = [*system.parameter_names][:1], Final("energy.kinetic")

    def motion() -> None:
        chosen = method_named(method)()
        runs.append(simulate(system, until=SHORT, method=chosen, store="steps" if stores else "samples"))

    yield f"simulation by {method}", motion
    if stores:
        yield f"gradient by {method}", lambda: sensitivity(runs[-1], response)
        yield (
            f"direct derivatives by {method}",
            lambda: sensitivity(runs[-1], response, some, method="direct"),
        )
        yield f"Hessian by {method}", lambda: hessian(runs[-1], response, some)
        yield f"derivatives of states by {method}", lambda: state_derivatives(runs[-1], some)
