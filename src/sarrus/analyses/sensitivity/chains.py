"""Which chain of derivatives belongs to the steps of a run: as many as there are methods that keep steps."""

from __future__ import annotations

from typing import TypeAlias

from ...results import RadauSteps, Steps, StepsTaken
from ...system import System
from .chain import Chain
from .parameters import Parameters
from .radau_chain import RadauChain

AnyChain: TypeAlias = Chain | RadauChain


def chain_of(system: System, steps: StepsTaken) -> AnyChain:
    """The chain of a run, for first derivatives."""
    if isinstance(steps, RadauSteps):
        return RadauChain(system, steps)
    assert isinstance(steps, Steps)
    return Chain(system, steps)


def curved_chain(system: System, steps: StepsTaken, parameters: Parameters) -> Chain:
    """The chain of a run, for second derivatives too.

    Raises
    ------
    ValueError
        For steps of Radau, and for numbers of tables and functions, which have first derivatives only.
    """
    if parameters.in_curves:
        raise ValueError(
            "second derivatives by numbers of tables and functions are not there; leave them out of wrt"
        )
    if not isinstance(steps, Steps):
        raise ValueError(
            "second derivatives need a run with HHT() or GeneralizedAlpha(); Radau() has first ones only"
        )
    return Chain(system, steps)
