"""The mappings of a model, named outputs and initial rates of joints, checked as far as a model alone can."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING, Any

from ..checks.findings import Findings
from ..checks.names import check_name
from ..coordinate import Known, is_angle
from ..errors import ModelError, restated
from ..expression import Expression, parse
from ..expression.quantity import quantity_of
from ..quantity import number
from ..show import quote, show, suggest

if TYPE_CHECKING:
    from ..checks.findings import Origin
    from ..model import Model
    from .expand import ExpandedModel


OUTPUTS = "outputs"
TAKEN = ("t", "energy")


def check_outputs(model: Model, parts: Collection[str], findings: Findings) -> None:
    """Keep an error for every name that is taken, and every formula that is none or is circular."""
    with findings.about():
        check_mapping(model.outputs, OUTPUTS, '{"gap": "slider.x - rod.x"}')
    found: dict[str, tuple[str, ...]] = {}
    for name, text in mapped(model.outputs).items():
        with findings.about(OUTPUTS, str(name)):
            check_name(name)
            if name in parts or name in TAKEN or name in model.parameters:
                what = "a parameter" if name in model.parameters else "an output or a part"
                raise ModelError(f"the name {quote(name)} is that of {what}. Rename one of them.")
            if not isinstance(text, str):
                raise ModelError(
                    f'must be a formula of outputs such as "2*slider.x", got {show(text)}. Write one.'
                )
            found[name] = parse(text).names()
    with findings.about(OUTPUTS):
        try:
            TopologicalSorter(found).prepare()
        except CycleError as error:
            circle = " → ".join(reversed(error.args[1]))
            raise ModelError(f"outputs has circular formulas: {circle}. Change one of them.") from None


def check_mapping(given: Any, section: str, example: str) -> None:
    """Refuse what is no mapping.

    Raises
    ------
    ModelError
    """
    if not isinstance(given, Mapping):
        message = f"{section} must be a mapping such as {example}, but is {show(given)}. Write one."
        raise ModelError(message, field=section)


def mapped(given: Any) -> Mapping[Any, Any]:
    """A mapping; an empty one in place of what is none."""
    return given if isinstance(given, Mapping) else {}


RATES = "rates"


def check_rates(model: Model, known: Known, findings: Findings) -> None:
    """Keep an error for every rate that is no number, or whose joint has no such coordinate."""
    with findings.about():
        check_mapping(model.rates, RATES, '{"pin": 5.0}')
    labels = {joint: [one.name for one in found] for joint, found in known.items() if found}
    for name, value in mapped(model.rates).items():
        with findings.about(RATES, str(name)):
            label_of(str(name), labels)
            number(value, f"{RATES}: {name}", "Give a rate in rad/s or m/s.")


def check_units(
    expanded: ExpandedModel,
    trees: Mapping[str, Expression],
    origin: Origin | None,
    definitions: Mapping[str, Expression] | None = None,
) -> None:
    """Refuse rates in a unit that does not fit, and names that have no definition.

    Raises
    ------
    ModelError
    """
    angles = {(one.owner, one.primitive.label): is_angle(one.primitive) for one in expanded.coordinates}
    labels: dict[str, list[str]] = {}
    for owner, label in angles:
        labels.setdefault(owner, []).append(label)
    with Findings(origin) as findings:
        for name, tree in trees.items():
            unit = "rad/s" if angles[name.partition(".")[0], label_of(name, labels)] else "m/s"
            with findings.about(RATES, name), restated(f"rates: {name}", field=RATES):
                while set(tree.names()) & (definitions or {}).keys():
                    tree = tree.replaced(definitions or {})
                quantity_of(tree, unit)


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
