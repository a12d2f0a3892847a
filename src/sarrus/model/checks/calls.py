"""Calls that a function or class cannot take: an argument is missing, unknown or without its name."""

from __future__ import annotations

import re
from abc import ABCMeta
from collections.abc import Mapping, Sequence
from contextlib import suppress
from inspect import Parameter, Signature, signature
from typing import Any

from ..show import quote, suggest

UNREAD = ("__annotations__", "__dataclass_fields__", "__dataclass_params__", "__match_args__")
BY_PLACE = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)


class ReadableAnnotation(str):
    """An annotation, which `help` shows without quotes."""

    __repr__ = str.__str__

    @classmethod
    def of(cls, annotation: Any) -> Any:
        """The type that is declared by an annotation, without what is attached to it."""
        if not isinstance(annotation, str):
            return annotation
        return cls(re.sub(r"Annotated\[(.*?), In\([^()]*\)\]", r"\1", annotation))


class CallCheck(ABCMeta):
    """The type of classes whose constructor refuses wrong arguments by one message with the remedy."""

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        try:
            return super().__call__(*args, **kwargs)
        except TypeError:
            if message := wrong_call(cls.constructed().__name__, signature(cls), args, kwargs):
                raise TypeError(message) from None
            raise

    def constructed(cls) -> type:
        """The class of the objects that a call makes."""
        return cls

    def __dir__(cls) -> list[str]:
        """The attributes that `help` and completion show: the fields are in the signature, without units."""
        return sorted(set(super().__dir__()) - set(UNREAD))

    @property
    def __signature__(cls) -> Signature:
        """The signature of the constructor for `help` and editors, without units."""
        made: Any = cls.constructed().__init__  # type: ignore[misc]
        own = signature(made)
        plain = [
            one.replace(annotation=ReadableAnnotation.of(one.annotation)) for one in own.parameters.values()
        ]
        with suppress(AttributeError):  # a class without a constructor of its own
            made.__signature__ = own.replace(parameters=plain)
        return Signature(plain[1:])


def wrong_call(name: str, wanted: Signature, args: Sequence[Any], kwargs: Mapping[str, Any]) -> str:
    """A message about arguments that are unknown, too many or missing; empty if none is."""
    parameters = wanted.parameters
    if any(one.kind is Parameter.VAR_KEYWORD for one in parameters.values()):
        return ""
    for key in kwargs:
        if key not in parameters:
            known = [one for one in parameters if one != "self"]
            return f"{name} has no argument {quote(key)}. {suggest(key, known)}"
    by_place = [key for key, one in parameters.items() if one.kind in BY_PLACE]
    variable = any(one.kind is Parameter.VAR_POSITIONAL for one in parameters.values())
    if len(args) > len(by_place) and not variable:
        allowed = f"only {', '.join(by_place)} may be" if by_place else "none may be"
        return f"{name}: {len(args)} arguments are given without a name, but {allowed}. Name the others."
    for key in by_place[: len(args)]:
        if key in kwargs:
            return f"{name}: {key} is given twice, by its place and by its name. Remove one of them."
    missing = [
        key
        for key, one in parameters.items()
        if one.default is Parameter.empty and key not in kwargs and key not in by_place[: len(args)]
    ]
    needed = [key for key in missing if parameters[key].kind is not Parameter.VAR_POSITIONAL]
    if not needed:
        return ""
    verb, them = ("is", "it") if len(needed) == 1 else ("are", "them")
    return f"{name}: {', '.join(needed)} {verb} missing. Give {them} by name, as in {needed[0]}=value."
