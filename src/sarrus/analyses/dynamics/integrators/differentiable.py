"""Methods of simulations: those whose steps can be stored for derivatives and taken sample by sample, and others."""

from __future__ import annotations

from typing import TypeAlias

from ...integration_methods import method_of
from ..methods.description import Description
from .alpha import HHT, GeneralizedAlpha
from .described import DescribedMethod, Radau, StepMethod
from .ode import ODE

Differentiable: TypeAlias = str | HHT | GeneralizedAlpha | Radau | Description | DescribedMethod
Method: TypeAlias = Differentiable | ODE


def differentiable(given: Differentiable | None, others: str = "", remedy: str = "") -> StepMethod:
    """A method whose steps can be stored, at its default: Radau; `others` that are allowed are named in the message.

    Raises
    ------
    TypeError
        If it is none.
    """
    given = method_of(given)
    if isinstance(given, Description):
        return DescribedMethod(given)
    if given is not None and not isinstance(given, StepMethod):
        raise TypeError(
            f"method must be HHT(), GeneralizedAlpha(), Radau(){others} or a Description, got {given!r}. "
            f"{remedy or 'Leave it out for Radau().'}"
        )
    return Radau() if given is None else given


def method_with_options(given: Method | None) -> StepMethod | ODE:
    """The method of an option of `simulate`, by default Radau."""
    given = method_of(given)
    if isinstance(given, ODE):
        return given
    return differentiable(given, ", ODE()", 'For a solver of SciPy give ODE("DOP853").')
