"""Former options of simulations: accepted for one release, with a warning that shows the present spelling."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from functools import wraps
from inspect import signature
from typing import Any, ParamSpec, TypeVar

from ...model.announcement import warn_now
from .integrators.described import DescribedMethod
from .integrators.differentiable import method_with_options
from .run_options import limits_of, listed_events, save_of
from .stepping.step_control import CONTROL, with_control

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)
FORMER: dict[str, tuple[str, ...]] = {  # by the option that replaces them
    "method": (*CONTROL, "corners"),  # at which steps end in every run
    "events": ("breakpoints",),
    "store": ("dense_output", "store_steps"),
    "save": ("overwrite",),
    "limits": ("time_limit", "max_steps", "error"),
}


def _method(present: Any, former: dict[str, Any]) -> tuple[Any, str]:
    control = {name: value for name, value in former.items() if name in CONTROL}
    method = with_control(method_with_options(present), **control)
    own = "description, " if isinstance(method, DescribedMethod) else ""
    options = {one.name: getattr(method, one.name) for one in fields(method) if one.init}
    default = {one.name: one.default for one in fields(method)}
    named = {
        name: value
        for name, value in options.items()
        if name != "description" and (former.get(name) is not None or value != default[name])
    }
    return method, f"method=sr.{type(method).__name__}({own}{_listed(named)})"


def _events(present: Any, former: dict[str, Any]) -> tuple[Any, str]:
    times = listed_events(former["breakpoints"])
    return [*times, *listed_events(() if present is None else present)], f"events={times}"


def _store(present: Any, former: dict[str, Any]) -> tuple[Any, str]:
    stores_steps, stores_motion = former.get("store_steps"), former.get("dense_output")
    store = (
        "steps" if stores_steps or present == "steps" else "dense" if stores_motion else present or "samples"
    )
    return store, f'store="{store}"'


def _save(present: Any, former: dict[str, Any]) -> tuple[Any, str]:
    save = save_of(present)
    if save is None:  # nothing is saved
        return None, f"save=sr.Save(folder, {_listed(former)})"
    return replace(save, **former), f"save=sr.Save({save.folder!r}, {_listed(former)})"


def _limits(present: Any, former: dict[str, Any]) -> tuple[Any, str]:
    names = {"time_limit": "time", "max_steps": "steps", "error": "errors"}
    given = {names[name]: value for name, value in former.items()}
    return replace(limits_of(present), **given), f"limits=sr.Limits({_listed(given)})"


PRESENT: dict[str, Callable[[Any, dict[str, Any]], tuple[Any, str]]] = {
    "method": _method, "events": _events, "store": _store, "save": _save, "limits": _limits
}  # fmt: skip


def _listed(options: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in options.items())


def present_options(
    given: Mapping[str, Any], former: Mapping[str, tuple[str, ...]], defaults: Mapping[str, Any]
) -> tuple[dict[str, Any], list[str]]:
    """The options of a call with former ones, by what replaces them, in their present spelling; messages about them."""
    found = {name: value for name, value in given.items() if not any(name in old for old in former.values())}
    messages = []
    for option, names in former.items():
        old = {name: given[name] for name in names if name in given}
        if old:
            given_now = found.get(option)
            present = defaults[option] if given_now is None else given_now
            found[option], spelling = PRESENT[option](present, old)
            verb = "is" if len(old) == 1 else "are"
            messages.append(f"{', '.join(f'{name}=' for name in old)} {verb} deprecated. Use {spelling}.")
    return found, messages


def with_former_options(kind: C) -> C:
    """Decorate a dataclass with options of `simulate`: the former ones are accepted."""
    setattr(kind, "__init__", accepts_former_options(vars(kind)["__init__"]))  # noqa: B010 - mypy refuses the other
    return kind


def accepts_former_options(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a public function with options of `simulate`: the former ones that it does not have are accepted."""
    known = signature(function).parameters
    former = {
        option: tuple(name for name in names if name not in known)
        for option, names in FORMER.items()
        if option in known
    }
    defaults = {option: known[option].default for option in former}
    every = {name for names in former.values() for name in names}

    @wraps(function)
    def accepting(*args: P.args, **kwargs: P.kwargs) -> R:
        if not every.isdisjoint(kwargs):
            present, messages = present_options(kwargs, former, defaults)
            warn_now(messages, DeprecationWarning)
            return function(*args, **present)
        return function(*args, **kwargs)

    return accepting
