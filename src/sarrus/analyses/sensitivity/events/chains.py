"""The derivatives that belong to the steps of a run, without events or with some."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from ....results import Segments, StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ...position.assembly_derivatives import AssemblyDerivatives
from ..chain.chain import Chain
from .segment_chain import SegmentChain

AnyChain: TypeAlias = Chain | SegmentChain


def chain_of(system: System, steps: StepsTaken | Segments, restitutions: Iterable[str] = ()) -> AnyChain:
    """The chain of a run, for first derivatives, by restitutions of impacts too."""
    if isinstance(steps, Segments):
        moving = timed(system)
        chains = [Chain(system, segment, moving and n > 0) for n, segment in enumerate(steps.segments)]
        return SegmentChain(system, steps, chains, list(restitutions))
    return Chain(system, steps)


def first_of(chain: AnyChain) -> Chain:
    """The chain with which a run begins."""
    return chain if isinstance(chain, Chain) else chain.chains[0]


def assembly_of(chain: AnyChain) -> AssemblyDerivatives:
    """The derivatives of the assembly from which a run started."""
    return first_of(chain).assembly
