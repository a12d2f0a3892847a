"""Names of a model for formulas of outputs, checked as far as a model alone can."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING, Any

from ..checks.findings import Findings
from ..checks.names import check_name
from ..errors import ModelError
from ..expression import parse
from ..show import quote, show

if TYPE_CHECKING:
    from ..model import Model

SECTION = "outputs"
TAKEN = ("t", "energy")


def check_outputs(model: Model, parts: Collection[str], findings: Findings) -> None:
    """Keep an error for every name that is taken, and every formula that is none or is circular."""
    with findings.about():
        check_mapping(model.outputs, SECTION, '{"gap": "slider.x - rod.x"}')
    found: dict[str, tuple[str, ...]] = {}
    for name, text in mapped(model.outputs).items():
        with findings.about(SECTION, str(name)):
            check_name(name)
            if name in parts or name in TAKEN or name in model.parameters:
                what = "a parameter" if name in model.parameters else "an output or a part"
                raise ModelError(f"the name {quote(name)} is that of {what}. Rename one of them.")
            if not isinstance(text, str):
                raise ModelError(
                    f'must be a formula of outputs such as "2*slider.x", got {show(text)}. Write one.'
                )
            found[name] = parse(text).names()
    with findings.about(SECTION):
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
