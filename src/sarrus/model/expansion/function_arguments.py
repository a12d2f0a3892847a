"""Arguments of Python functions: one with the name of a state or an input is refused where it would be the time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import ModelError
from ..laws.curve import Formula, Tree
from ..laws.jumps import TIME
from ..laws.recorded import arguments, has_all_outputs
from ..measure import In, measures_of
from ..quantity import is_list
from ..states.input import OWN, Input


def refuse_arguments(part: Any, kinds: Mapping[str, str]) -> None:
    """Refuse a function of one variable, the time or all outputs, whose argument has the name of a state or an input.

    Parameters
    ----------
    part
        A driver or a force.
    kinds
        The names of states and inputs, each with what it is, ``an input``.

    Raises
    ------
    ModelError
        With the field, and what to write.
    """
    for field, measure in measures_of(part).items() if kinds else ():
        over_time = In(measure.unit, over="s") if isinstance(part, Input) else measure
        if not over_time.outputs and over_time.over != "s":
            continue  # such as a stiffness, a function of the length alone
        given: Any = getattr(part, field, None)
        for law in given if is_list(given) else (given,):
            name = _argument(law.function if isinstance(law, Formula) else law)
            if name in kinds and name not in OWN:
                own = isinstance(part, Input) and name == part.name
                remedy = _remedy(name, "itself" if own else kinds[name], over_time)
                raise ModelError(f"{field} is a function of {name}, {kinds[name]}. {remedy}", field=field)


def _argument(law: Any) -> str:
    """The name of the only argument of a function; empty if it has several, or is one of all outputs."""
    if isinstance(law, Tree | type) or not callable(law) or has_all_outputs(law, {TIME}):
        return ""
    wanted = [*arguments(law, {TIME})]
    return wanted[0] if len(wanted) == 1 else ""


def _remedy(name: str, kind: str, measure: In) -> str:
    if measure.outputs or (measure.states and kind == "a state"):
        return f'Write lambda o: o["{name}"], or a formula, "{name}". A function of time is lambda t: ...'
    if kind == "an input":
        return f'Write "{name}" for the input, or lambda t: ... for a function of time.'
    return "Write lambda t: ... for a function of time."
