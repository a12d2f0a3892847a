"""What code registers with Sarrus, kinds, outputs, importers, methods and verbs, and how a test leaves it as it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from sarrus.analyses import integration_methods
from sarrus.cli import parser
from sarrus.elements import Element
from sarrus.io import by_ending
from sarrus.model import Driver, Force, Joint
from sarrus.outputs import output

REGISTRIES = (
    (Element, "registry"),
    (Joint, "kinds"),
    (Driver, "kinds"),
    (Force, "kinds"),
    (output, "PROVIDERS"),
    (by_ending, "IMPORTERS"),
    (integration_methods, "METHODS"),
    (integration_methods, "STORING_STEPS"),
    (parser, "VERBS"),
)


def of_others() -> set[str]:
    """What is registered by code outside of Sarrus."""
    found = (one for holder, name in REGISTRIES for one in _values(getattr(holder, name)))
    modules = {str(one): getattr(one, "__module__", getattr(one, "__name__", "sarrus")) for one in found}
    return {one for one, module in modules.items() if module.partition(".")[0] != "sarrus"}


def _values(registry: Any) -> Any:
    return registry.values() if isinstance(registry, dict) else registry


@contextmanager
def registries_restored() -> Iterator[None]:
    """Other tests see nothing of what is registered within it."""
    known = [
        (holder, name, getattr(holder, name), getattr(holder, name).copy()) for holder, name in REGISTRIES
    ]
    try:
        yield
    finally:
        for holder, name, registry, before in known:
            registry.clear()
            (registry.update if isinstance(registry, dict) else registry.extend)(before)
            setattr(holder, name, registry)


def kinds_of_forces_here(*names: str) -> Any:
    """A fixture of a module: files have these types of its forces there, other tests see those of the package alone."""
    own = {name: Force.kinds.pop(name) for name in names}

    @pytest.fixture(autouse=True, scope="module")
    def registered() -> Iterator[None]:
        Force.kinds.update(own)
        yield
        for name in own:
            del Force.kinds[name]

    return registered
