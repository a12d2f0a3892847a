"""Initial rates of joints in a model, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..checks.findings import Findings
from ..coordinate import Known, is_angle
from ..errors import ModelError
from ..expression import Expression
from ..expression.quantity import quantity_of
from ..quantity import number
from ..show import quote, suggest
from .named_outputs import check_mapping, mapped

if TYPE_CHECKING:
    from ..checks.origin import Origin
    from ..model import Model
    from .expand import Expanded

SECTION = "rates"


def check_rates(model: Model, known: Known, findings: Findings) -> None:
    """Keep an error for every rate that is no number, or whose joint has no such coordinate."""
    with findings.about():
        check_mapping(model.rates, SECTION, '{"pin": 5.0}')
    labels = {joint: [one.name for one in found] for joint, found in known.items() if found}
    for name, value in mapped(model.rates).items():
        with findings.about(SECTION, str(name)):
            label_of(str(name), labels)
            number(value, f"{SECTION}: {name}", "Give a rate in rad/s or m/s.")


def check_units(
    expanded: Expanded,
    trees: Mapping[str, Expression],
    origin: Origin | None,
    definitions: Mapping[str, Expression] | None = None,
) -> None:
    """Refuse rates in a unit that does not fit, and names that have no definition.

    Raises
    ------
    ModelError
    """
    findings = Findings(origin)
    angles = {(one.owner, one.primitive.label): is_angle(one.primitive) for one in expanded.coordinates}
    labels: dict[str, list[str]] = {}
    for owner, label in angles:
        labels.setdefault(owner, []).append(label)
    for name, tree in trees.items():
        unit = "rad/s" if angles[name.partition(".")[0], label_of(name, labels)] else "m/s"
        with findings.about(SECTION, name):
            try:
                while set(tree.names()) & (definitions or {}).keys():
                    tree = tree.replaced(definitions or {})
                quantity_of(tree, unit)
            except ModelError as wrong:
                raise ModelError(f"rates: {name} {wrong.message}", field=SECTION) from None
    findings.raise_first()


def label_of(name: str, labels: Mapping[str, Sequence[str]]) -> str:
    """The joint's coordinate that a rate is of: ``pin`` where there is only one, or ``sleeve.displacement``.

    Raises
    ------
    ModelError
        If there is no such joint, or no such coordinate.
    """
    joint, _, label = name.partition(".")
    if joint not in labels:
        known = suggest(joint, labels) if labels else "No joint has one."
        raise ModelError(f"rates: there is no joint {quote(joint)} with an angle or a displacement. {known}")
    if label in labels[joint] or (not label and len(labels[joint]) == 1):
        return label or labels[joint][0]
    offered = " or ".join(f"{joint}.{own}" for own in labels[joint])
    raise ModelError(f"rates: the joint {quote(joint)} has no single rate {quote(name)}. Give {offered}.")
