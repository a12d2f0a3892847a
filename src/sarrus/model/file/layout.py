"""The pydantic model of a model file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, reduce
from operator import or_
from typing import Any

from pydantic import AfterValidator, Field, StrictStr, create_model

from ..bodies.body import Body
from ..checks.names import matches
from ..expression.functions import CONSTANTS
from ..model import registered_kinds
from ..show import quote
from .forms import entry_model, tagged_model
from .hardpoints import Form as HardpointsForm
from .include import IncludeForm
from .stated import Entry, invalid, list_in, list_of, mapping_of, marked, number_in, one_of

LEFT = "Parts of the left side, NAME_left. Their mirror images about the plane y = 0 are NAME_right."
RIGHT = "Parts of the right side, NAME_right. Their mirror images about the plane y = 0 are NAME_left."
RIG = "Wheels and sweeps of a suspension, for `sarrus suspension`; the model is without them."


def layout(data: Any = None) -> type[Entry]:
    """Return the model of a file with all kinds of joints, drivers and forces that are registered now.

    With the content of a file, only with those that it names, if all of them are known: each takes 3 ms.
    """
    kinds = registered_kinds()
    sections = {name: data.get(name, {}) for name in kinds} if isinstance(data, Mapping) else {}
    return _layout(*(_kinds(known, sections.get(name)) for name, known in kinds.items()))


def _kinds(known: Mapping[str, type], section: Any) -> tuple[type, ...]:
    """The kinds that a section names, and two at least, as pydantic asks; all if one is unknown."""
    names = {_type(entry) for entry in section.values()} if isinstance(section, Mapping) else {None}
    chosen = {*names, *sorted(known)[:2]} if names <= known.keys() else known
    return tuple(known[name] for name in sorted(known) if name in chosen)


def _type(entry: Any) -> str | None:
    kind = entry.get("type") if isinstance(entry, Mapping) else None
    return kind if isinstance(kind, str) else None


@cache
def _layout(joints: tuple[type, ...], drivers: tuple[type, ...], forces: tuple[type, ...]) -> type[Entry]:
    definitions: dict[str, Any] = {
        "schema_": (StrictStr, Field(default="", alias="$schema", description="For editors.")),
        "name": (
            StrictStr,
            Field(
                default_factory=lambda: None, description="Any text on one line; the file's name if left out."
            ),
        ),
        "description": (StrictStr, Field(default="", description="For people.")),
        "gravity": (
            list_in("m/s^2", 3),
            Field(default=[0.0, 0.0, 0.0], description="In global axes [m/s²]."),
        ),
        "include": (
            list_of(IncludeForm),
            Field(default=[], description="Files whose parts become parts of this one."),
        ),
        "parameters": (
            Parameters,
            Field(default={}, description="Numbers and formulas by name, or groups of them."),
        ),
        "points": (mapping_of(list_in("m", 3)), Field(default={}, description="Global points by name.")),
        "hardpoints": (
            HardpointsForm,
            Field(default={}, description="Design points by name, in global axes."),
        ),
        "bodies": (mapping_of(entry_model(Body, tagged=False)), Field(description="By name.")),
        "joints": (mapping_of(_any_of(joints)), Field(default={}, description="By name.")),
        "drivers": (mapping_of(_any_of(drivers)), Field(default={}, description="By name.")),
        "forces": (mapping_of(_any_of(forces)), Field(default={}, description="By name.")),
        "left": (_side(joints, drivers, forces), Field(default=None, description=LEFT)),
        "right": (_side(joints, drivers, forces), Field(default=None, description=RIGHT)),
        "rates": (
            mapping_of(number_in("")),
            Field(default={}, description="Initial rates of joints by name [rad/s], [m/s]."),
        ),
        "outputs": (mapping_of(StrictStr), Field(default={}, description="Names for formulas of outputs.")),
        "rig": (dict[str, Any], Field(default={}, description=RIG)),
    }
    doc = "A mechanism: SI units, angles in radians, Euler parameters scalar first."
    model: type[Entry] = create_model("ModelFile", __base__=Entry, __doc__=doc, **definitions)
    return model


def _side(*kinds: tuple[type, ...]) -> Any:
    """The form of the parts of one side."""
    names = ("joints", "drivers", "forces")
    sections: dict[str, Any] = {"bodies": (mapping_of(entry_model(Body, tagged=False)), Field(default={}))}
    sections |= {
        name: (mapping_of(_any_of(own)), Field(default={})) for name, own in zip(names, kinds, strict=True)
    }
    doc = "Parts of one side: the left one if y is positive."
    return create_model("Side", __base__=Entry, __doc__=doc, **sections) | None


def _any_of(kinds: tuple[type, ...]) -> Any:
    models: list[Any] = [tagged_model(kind) for kind in kinds]
    return marked(reduce(or_, models), Field(discriminator="type"))


WORD = r"[^\W\d]\w*"
TAKEN = (*CONSTANTS, "t")


def _check_names(given: dict[str, Any]) -> dict[str, Any]:
    for name in given:
        if not matches(WORD, name):
            message = (
                f"has the name {quote(name)}, which must be letters, digits and _, starting with a letter"
            )
            raise invalid(f"{message}. Rename it.", name)
        if name in TAKEN:
            raise invalid(f"has the name {quote(name)}, which has a meaning of its own. Rename it.", name)
    return given


def _form(value: Any) -> str:
    return "group" if isinstance(value, Mapping) else "number"


Names = AfterValidator(_check_names)
Group: Any = marked(mapping_of(number_in("")), Names)
Parameters: Any = marked(mapping_of(one_of(_form, number=number_in(""), group=Group)), Names)
