"""The docstrings of public functions, parts and responses describe each of their arguments, also inherited ones."""

from __future__ import annotations

import inspect
import re
from typing import Any

import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.responses.responses import Response
from sarrus.model.drivers.driver import Driver
from sarrus.model.forces.force import Force
from sarrus.model.joints.joint import Joint

PARTS = [*Joint.kinds.values(), *Force.kinds.values(), *Driver.kinds.values()]
RESPONSES = [kind for kind in Response.__subclasses__() if kind.__name__ in sr.__all__]
FUNCTIONS = [what for what in (getattr(sr, name) for name in sr.__all__) if inspect.isfunction(what)]


@pytest.mark.parametrize("what", [*PARTS, *RESPONSES, *FUNCTIONS], ids=lambda what: what.__name__)
def test_every_argument(what: Any) -> None:
    text = inspect.getdoc(what) or ""
    arguments = [name for name in inspect.signature(what).parameters if name != "name"]
    assert not [name for name in arguments if not re.search(rf"\b{name}\b", text)]


def test_own_descriptions_come_first_and_hide_inherited_ones() -> None:
    text = inspect.getdoc(sr.AngleStop) or ""
    assert "[s/rad]" in text
    assert "[s/m]" not in text
    assert text.index("rounding\n") < text.index("exponent\n") < text.index("body_i, body_j\n")


def test_other_sections_stay_behind() -> None:
    text = inspect.getdoc(sr.RSDA) or ""
    assert text.index("Parameters\n---") < text.index("frame_i, frame_j\n") < text.index("\n\nNotes\n-----\n")
