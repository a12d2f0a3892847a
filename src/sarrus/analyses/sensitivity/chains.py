"""The derivatives that belong to the steps of a run, without events or with some."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from ...results import Pieces, StepsTaken
from ...system import System
from ...system.time_derivatives import timed
from .chain import Chain
from .parameters import Parameters
from .piece_chain import PieceChain

AnyChain: TypeAlias = Chain | PieceChain


def chain_of(system: System, steps: StepsTaken | Pieces, restitutions: Iterable[str] = ()) -> AnyChain:
    """The chain of a run, for first derivatives, by restitutions of impacts too."""
    if isinstance(steps, Pieces):
        moving = timed(system)
        chains = [Chain(system, piece, moving and n > 0) for n, piece in enumerate(steps.pieces)]
        return PieceChain(system, steps, chains, list(restitutions))
    return Chain(system, steps)


def curved_chain(system: System, steps: StepsTaken | Pieces, parameters: Parameters) -> Chain:
    """The chain of a run, for second derivatives too.

    Raises
    ------
    ValueError
        For runs with events, and for numbers of tables and functions, which have first derivatives only.
    """
    if parameters.in_curves:
        raise ValueError(
            "second derivatives by numbers of tables and functions are not there; leave them out of wrt"
        )
    if isinstance(steps, Pieces):
        raise ValueError("second derivatives need a run without events; leave the events out")
    return Chain(system, steps)
