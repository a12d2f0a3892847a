"""The derivatives that belong to the steps of a run, without events or with some."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from ....results import Pieces, StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ...position.assembly_derivatives import AssemblyDerivatives
from ..chain.chain import Chain
from .piece_chain import PieceChain

AnyChain: TypeAlias = Chain | PieceChain


def chain_of(system: System, steps: StepsTaken | Pieces, restitutions: Iterable[str] = ()) -> AnyChain:
    """The chain of a run, for first derivatives, by restitutions of impacts too."""
    if isinstance(steps, Pieces):
        moving = timed(system)
        chains = [Chain(system, piece, moving and n > 0) for n, piece in enumerate(steps.pieces)]
        return PieceChain(system, steps, chains, list(restitutions))
    return Chain(system, steps)


def first_of(chain: AnyChain) -> Chain:
    """The chain with which a run begins."""
    return chain if isinstance(chain, Chain) else chain.chains[0]


def assembly_of(chain: AnyChain) -> AssemblyDerivatives:
    """The derivatives of the assembly from which a run started."""
    return first_of(chain).assembly
