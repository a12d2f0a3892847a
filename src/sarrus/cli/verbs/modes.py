"""``sarrus modes MODEL``: vibration modes about the equilibrium in which a mechanism comes to rest."""

from __future__ import annotations

import argparse

from .. import model_file, shared
from ..answer import Answer
from ..values import refuse_unwritable

PURPOSE = "print the vibration modes of a model file about its equilibrium"
EXAMPLES = ("sarrus modes crank.yaml", "sarrus modes crank.yaml --figure modes.svg")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, which equilibrium is wanted, and what to write."""
    model_file.arguments(parser)
    shared.rest(parser)
    shared.figure(parser, "the eigenvalues in the complex plane")


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Find the equilibrium and print the modes; 1 if there is none."""
    from ...analyses import equilibrium, modes
    from ...system import System

    refuse_unwritable([chosen.figure])
    system = System(model_file.read(chosen, answer))
    at = equilibrium(system, t=chosen.time, stable=not chosen.nearest)
    answer.show(at.message)
    answer.put(model=system.name, equilibrium=at.message, message=at.message)
    if not at.success:
        return 1
    found = modes(system, at, t=chosen.time)
    answer.show(found)
    answer.put(message=found.message, stability=found.stability, eigenvalues=found.eigenvalues)
    answer.put(frequencies=found.frequencies, damping_ratios=found.damping_ratios)
    if chosen.figure:
        answer.draw(found.plot()[0].figure, chosen.figure)
    return 0 if found.success else 1
