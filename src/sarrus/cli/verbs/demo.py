"""``sarrus demo``: the shipped slider-crank, from its model file to plots."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from ..answer import Answer
from ..progress import Bar
from ..values import refuse_unwritable

UNTIL = 10.0
PURPOSE = "assemble, check, simulate and plot the shipped slider-crank"
EXAMPLES = ("sarrus demo", "sarrus demo --output plots")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Where to write."""
    parser.add_argument(
        "--output", type=Path, default="sarrus-demo", help="folder for the plots (sarrus-demo)"
    )


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Load, assemble, check, simulate, plot, and print what was done and how fast."""
    from ...analyses import ODE, assemble, simulate
    from ...mechanisms import path
    from ...model import load
    from ...system import System

    began = time.perf_counter()
    folder = _folder(chosen.output)
    system = System(load(path("slider_crank")))
    counts = system.counts()
    answer.show(
        f"{system.name}: {counts['bodies']} bodies, {counts['coordinates']} coordinates, "
        f"{counts['joint_equations']} + {counts['normalizations']} constraint equations, "
        f"degrees of freedom: {counts['degrees_of_freedom']}"
    )
    with Bar("compiling kernels (the first time only)", len(system.compilable())) as bar:
        system.compile(bar.step)
    start = assemble(system)
    answer.show(start.message)
    report = system.check_derivatives()
    answer.show(report)
    simulated = time.perf_counter()
    with Bar(f"simulating {UNTIL:g} s", UNTIL) as bar:
        motion = simulate(
            system, start, until=UNTIL, method=ODE(), rtol=1e-10, atol=1e-12, progress=bar.reach
        )
    simulated = time.perf_counter() - simulated
    answer.show(f"{motion.message}: {motion.nsteps} steps, {motion.nfev} evaluations, {simulated:.2f} s")
    answer.show(
        f"constraints satisfied to {motion.violation.max():.0e}; slider at x = {motion['slider'].position[-1, 0]:.9f} m"
    )
    answer.show(_times(system, start))
    for file in _plots(folder, motion, report):
        answer.wrote(file)
    seconds = time.perf_counter() - began
    answer.show(f"all in {seconds:.1f} s")
    answer.put(model=system.name, counts=counts, message=motion.message, seconds=seconds)
    answer.put(violation=motion.violation.max(), derivatives_agree=report.ok, nsteps=motion.nsteps)
    return 0 if start.success and report.ok and motion.success else 1


def _folder(folder: Path) -> Path:
    """Create the folder for the plots, or raise an error, before anything is computed."""
    from ...model.errors import SarrusError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise SarrusError(f"{folder}: is a file, not a folder. Choose another --output.") from None
    refuse_unwritable([folder / "slider_crank_motion.png"])
    return folder


def _times(system: Any, start: Any) -> str:
    """One line: microseconds of each group of derivatives."""
    from ...analyses.paper import consistent_state, exact_seconds
    from ...elements import GROUPS

    state = consistent_state(system, seed=1)
    found = (f"{name} {1e6 * exact_seconds(system, name, state):.2f} µs" for name in GROUPS)
    return "all derivatives of a group, once: " + ", ".join(found)


def _plots(folder: Path, motion: Any, report: Any) -> list[Path]:
    from ...results.saving.exported_file import exporting
    from ...system.check import TOLERANCE
    from ...views import check_figure, motion_figure

    figures = {"motion": motion_figure(motion, "slider", "crank"), "check": check_figure(report, TOLERANCE)}
    files = [motion.animate(folder / "motion.html", traces=["rod"])]
    for name, figure in figures.items():
        for ending in ("png", "svg"):
            files.append(folder / f"slider_crank_{name}.{ending}")
            with exporting(files[-1]):
                figure.savefig(files[-1], dpi=130)
            figure.set_layout_engine(None)  # the layout is computed once, and used for the next file too
    return files
