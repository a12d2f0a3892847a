"""Outputs that elements declare: ``tension`` of a spring is ``spring.tension`` in every analysis, plot and table."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

Method = TypeVar("Method", bound=Callable[..., Any])
AXES = ("x", "y", "z")


class Declared(NamedTuple):
    """A method of an element that is an output.

    Attributes
    ----------
    word, unit : ``tension`` and N
    axes : x, y and z of a vector, else none
    method, arguments : its name, and how many of x, v and t it takes
    bodies : only elements with at least so many bodies have it
    of : the place of the owner of coordinates that must be a body, for outputs of bodies
    """

    word: str
    unit: str
    axes: tuple[str, ...]
    method: str
    arguments: int
    bodies: int = 1
    of: int | None = None


def output(
    unit: str, word: str = "", *, vector: bool = False, bodies: int = 1, of: int | None = None
) -> Callable[[Method], Method]:
    """Declare a method ``f(self, x)``, ``f(self, x, v)`` or ``f(self, x, v, t)`` of an element as an output.

    Parameters
    ----------
    unit : of SI, as in "N m"
    word : behind the name of the part, as in ``spring.tension``; by default the method's name
    vector : whether the method returns three numbers, which are ``.x``, ``.y`` and ``.z``
    bodies : the least number of bodies of an element that has the output
    of : the place of an owner among these that must be a rigid body, such as -1
    """

    def declare(method: Method) -> Method:
        own, arguments = method.__name__, method.__code__.co_argcount - 1
        found = Declared(word or own, unit, AXES if vector else (), own, arguments, bodies, of)
        method.output = found  # type: ignore[attr-defined]
        return method

    return declare


def declared(kind: Any) -> dict[str, Declared]:
    """The outputs of an element class by word, those of its bases included."""
    methods = [getattr(m, "output", None) for one in reversed(kind.__mro__) for m in vars(one).values()]
    declared = [one for one in methods if isinstance(one, Declared) and one.bodies <= kind.bodies]
    return {one.word: one for one in declared if one.of is None or kind.is_body(one.of)}
