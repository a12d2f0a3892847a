"""The parameters of a model file, and the formulas that compute other parameters from them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ..checks.findings import Path
from ..errors import ModelError
from ..expression import Expression, Number
from ..show import quote, suggest


@dataclass(frozen=True, eq=False)
class Formulas:
    """Dependences of the parameters in a model file.

    Parameters
    ----------
    parameters
        The value of every parameter, in SI units; of a group as ``group.name``.
    expressions
        The formula of every number of the model that was given by one, by its place in the file, as in
        ``("bodies", "rod", "mass")``.
    definitions
        The formula of every name that formulas use: parameters, and numbers of points and parts. Each needs
        only the names before it.
    points
        The named global points. [m]
    hardpoints
        The points whose coordinates are parameters, and the unit in which these are given.
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    expressions: Mapping[Path, Expression] = field(default_factory=dict)
    definitions: Mapping[str, Expression] = field(default_factory=dict)
    points: Mapping[str, Sequence[float]] = field(default_factory=dict)
    hardpoints: Mapping[str, str] = field(default_factory=dict)

    def free(self) -> tuple[str, ...]:
        """Return the parameters that do not follow from others."""
        return tuple(name for name in self.parameters if not self.definitions[name].names())

    def values(self, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the value of every name; those in ``given`` are replaced, by any kind of number."""
        values: dict[str, Any] = {}
        for name, tree in self.definitions.items():
            values[name] = (given or {}).get(name, None)
            if values[name] is None:
                values[name] = tree.value(values)
        return values

    def following(self, given: Collection[str]) -> set[str]:
        """Return the names that are given, and those that follow from them."""
        found = {*given}
        for name, tree in self.definitions.items():  # each needs only the names before it
            if found.intersection(tree.names()):
                found.add(name)
        return found

    def with_values(self, given: Mapping[str, float]) -> Formulas:
        """Return the same formulas with numbers in the place of some parameters."""
        if not given:
            return self
        values = self.values(given)
        numbers = {name: Number(float(value)) for name, value in given.items()}
        return replace(
            self,
            parameters={name: float(values[name]) for name in self.parameters},
            definitions={**self.definitions, **numbers},
        )

    def derivatives(self, parameter: str) -> dict[Path, float]:
        """Return the exact derivative of every number that depends on a parameter, by its place.

        Raises
        ------
        ModelError
            If there is no such parameter.
        """
        if parameter not in self.parameters:
            raise ModelError(
                f"there is no parameter {quote(parameter)}. {suggest(parameter, self.parameters)}"
            )
        values, rates = self.values(), self._rates(parameter)
        found = {path: _rate(tree, values, rates) for path, tree in self.expressions.items()}
        own = ("parameters", *parameter.split("."))
        return {path: rate for path, rate in found.items() if rate and path != own}

    def _rates(self, parameter: str) -> dict[str, float]:
        """Return the derivative of every name, forward through the definitions."""
        values = self.values()
        rates: dict[str, float] = {}
        for name, tree in self.definitions.items():
            rates[name] = 1.0 if name == parameter else _rate(tree, values, rates)
        return rates


def _rate(tree: Expression, values: Mapping[str, float], rates: Mapping[str, float]) -> float:
    """Return the derivative of a formula whose names change at these rates."""
    moving = [name for name in tree.names() if rates[name]]
    total: Expression = Number(0.0)
    for name in moving:
        total = total + tree.derivative(name) * Number(rates[name])
    return float(total.value(values))
