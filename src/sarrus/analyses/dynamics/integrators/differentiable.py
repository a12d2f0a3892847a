"""Methods whose steps can be stored, for derivatives, and taken sample by sample."""

from __future__ import annotations

from typing import TypeAlias

from ..methods.description import Description
from ..time_loop.prescribed import Prescribed
from .alpha import HHT, GeneralizedAlpha
from .described import Described
from .radau import Radau

Differentiable: TypeAlias = HHT | GeneralizedAlpha | Radau | Description


def differentiable(given: Differentiable | None) -> Prescribed:
    """A method whose steps can be stored, at its default: Radau.

    Raises
    ------
    TypeError
        If it is none.
    """
    if isinstance(given, Description):
        return Described(given)
    if given is not None and not isinstance(given, Prescribed):
        raise TypeError(
            f"method must be HHT(), GeneralizedAlpha(), Radau(), ODE(), IDA() or a Description, got {given!r}. "
            'For a solver of SciPy give ODE("DOP853").'
        )
    return Radau() if given is None else given
