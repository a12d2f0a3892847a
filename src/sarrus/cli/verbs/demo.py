"""``sarrus demo``: the shipped slider-crank, from its model file to a gradient, a range of motion and a page."""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..answer import Answer
from ..progress import Bar
from ..values import refuse_unwritable

UNTIL = 10.0
RESPONSE = "slider.x"
LARGEST = 5  # influences that are listed
REPEATS = 10  # starts in a row that lead to nothing new, a third of what is usual
FRAMES = 300  # of the motion on the page: 30 in each second
PAGE = "slider_crank.html"
PURPOSE = "assemble, simulate, differentiate and check the shipped slider-crank, and show it on a page"
EXAMPLES = ("sarrus demo", "sarrus demo --output pages")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments: the output folder."""
    parser.add_argument(
        "--output", type=Path, default="sarrus-demo", help="folder for the page (sarrus-demo)"
    )


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Load, assemble, simulate, differentiate, check, find the range, write the page; each with its time."""
    from ...analyses import Final, assemble, simulate
    from ...analyses.sensitivity import sensitivity
    from ...analyses.workspace import workspace_range
    from ...mechanisms import path
    from ...model import load
    from ...system import System
    from ...views import animate

    began = time.perf_counter()
    page = _folder(chosen.output) / PAGE
    system = System(load(path("slider_crank")))
    counts = system.counts()
    answer.show(
        f"{system.name}: {counts['bodies']} bodies, {counts['coordinates']} coordinates, "
        f"{counts['joint_equations']} + {counts['normalizations']} constraint equations, "
        f"degrees of freedom: {counts['degrees_of_freedom']}"
    )
    laps = _Laps(answer)
    with _compiled_beside():
        start = assemble(system)
        laps.show(f"{system.name}: {start.message}")
        motion = simulate(system, start, until=UNTIL, store="steps")
        laps.show(motion.summary())
        operators = [names for names in system.compilable() if len(names) == 1]
        with Bar("compiling kernels (the first time only)", len(operators)) as bar:
            system.compile(bar.step, operators)
    laps.restart()
    gradient = sensitivity(motion, Final(RESPONSE))
    laps.show(
        f"{system.name}: derivatives by {len(gradient.names)} parameters, from one sweep backward in time"
    )
    answer.show(gradient.table(most=LARGEST))
    laps.restart()
    report = system.check_derivatives()
    laps.show(report.verdict)
    reach = workspace_range(system, RESPONSE, repeats=REPEATS)
    laps.show(reach.summary())
    outputs = [RESPONSE, "spring.tension", "pin.angle"]
    animate(motion, page, traces=["rod"], outputs=outputs, gradient=gradient, count=FRAMES)
    answer.wrote(page)
    elapsed = time.perf_counter() - began
    answer.put(model=system.name, counts=counts, message=motion.message, seconds=elapsed)
    answer.put(violation=motion.violation.max(), derivatives_agree=report.ok, nsteps=motion.nsteps)
    answer.put(gradient=dict(gradient), range=reach.intervals)
    answer.show(
        f"all in {elapsed:.1f} s. Motion, curves and influences: open {page.resolve().as_uri()} in a browser"
    )
    return 0 if start.success and report.ok and motion.success and reach.success else 1


def _folder(folder: Path) -> Path:
    """Create the folder for the page, or raise an error, before anything is computed."""
    from ...model.errors import SarrusError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise SarrusError(f"{folder}: is a file, not a folder. Choose another --output.") from None
    refuse_unwritable([folder / PAGE])
    return folder


@contextmanager
def _compiled_beside() -> Iterator[None]:
    """Compile kernels in another process meanwhile, if there are none yet and a processor is free.

    A kernel that one process compiles is not compiled by the other.
    """
    from ..._jit.linking.cache import folder
    from ..._jit.linking.shipped import shipped
    from ...studies.pool import available

    if shipped() or any(folder().glob("*.kernel")) or available() == 1:
        yield
        return
    # -P: no modules of this folder
    command = [sys.executable, "-P", "-m", "sarrus", "compile", "slider_crank"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as other:
        try:
            yield
        finally:
            other.kill()


class _Laps:
    """Prints what was done with the time since the last."""

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        self.restart()

    def restart(self) -> None:
        self._since = time.perf_counter()

    def show(self, text: str) -> None:
        self._answer.show(f"{text} ({time.perf_counter() - self._since:.2f} s)")
        self.restart()
