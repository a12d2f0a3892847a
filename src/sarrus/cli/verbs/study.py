"""``sarrus study FILE``: many runs of one model with other numbers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .. import shared
from ..answer import Answer, log
from ..progress import Bar
from ..values import natural, refuse_unwritable

if TYPE_CHECKING:
    from ...studies import StudyTable
    from ...studies.conduct import Request

PURPOSE = "run a model for many values of its parameters, and tabulate the responses"
EXAMPLES = (
    "sarrus study springs.yaml",
    "sarrus study springs.yaml --workers 4 --csv springs.csv --figure springs.png",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The study file, who runs the cases, and what to write."""
    parser.add_argument("study", type=Path, help="a .yaml or .json study file")
    parser.add_argument(
        "--folder",
        type=Path,
        help="folder for the results; a study that was stopped goes on from it (the study file's name, without ending)",
    )
    parser.add_argument(
        "--workers", type=natural, help="processes (as many as pay, measured on the first cases)"
    )
    shared.total_time_limit(parser)
    parser.add_argument("--retry-failed", action="store_true", help="run cases that failed once more")
    parser.add_argument(
        "--linear",
        action="store_true",
        help="also the spread of the responses to first order, by derivatives",
    )
    shared.table(parser, "all cases")
    shared.figure(parser, "plots of the responses")
    parser.add_argument("--plot", nargs="+", metavar="RESPONSE", help="responses to draw (all)")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Run what is left of the study; 1 if every case failed, or the folder could not be written."""
    from ...io import load_any
    from ...studies.conduct import carry_out
    from ...studies.file import read_study_file

    refuse_unwritable([chosen.csv, chosen.figure])
    asked = read_study_file(chosen.study, lambda file: answer.noted(load_any(file)))
    _refuse_unknown(chosen.plot, [one.name for one in asked.task.responses])
    folder = chosen.folder or chosen.study.with_suffix("")
    total = len(asked.cases)
    with Bar(f"{asked.name}: {total} cases", total) as bar:
        limit = chosen.total_time_limit
        table = carry_out(asked, folder, chosen.workers, None, chosen.retry_failed, bar.reach, limit)
    if table.status != "finished":
        log.info("%s holds the cases that are done; the same command goes on with the others", folder)
    if table.status == "stopped":
        raise KeyboardInterrupt
    answer.show(table)
    answer.put(study=table.name, message=table.summary().splitlines()[0], folder=folder, cases=len(table))
    answer.put(statistics=table.statistics(), failures=table.failures, columns=table.columns)
    answer.wrote(folder)
    if chosen.linear:
        _linear(asked, answer)
    _write(chosen, table, answer)
    return 0 if table.success.any() and table.status != "not saved" else 1


def _linear(asked: Request, answer: Answer) -> None:
    """Means and standard deviations by one run and its derivatives."""
    from ...studies.first_order import uncertainty_of

    found = uncertainty_of(asked)
    answer.show(f"\nto first order, by one run and its derivatives:\n{found.summary()}")
    spread = zip(found.responses, found.values, found.std, strict=True)
    answer.put(linear={name: {"mean": mean, "std": std} for name, mean, std in spread})


def _refuse_unknown(responses: list[str] | None, known: list[str]) -> None:
    from ...model.errors import SarrusError

    for response in responses or ():
        if response not in known:
            raise SarrusError(f"--plot: there is no response {response!r}. Choose from {', '.join(known)}.")


def _write(chosen: argparse.Namespace, table: StudyTable, answer: Answer) -> None:
    if chosen.csv:
        table.to_csv(chosen.csv)
        answer.wrote(chosen.csv)
    if chosen.figure:
        answer.draw(table.plot(*(chosen.plot or ()))[0].figure, chosen.figure)
