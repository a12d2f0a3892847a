"""A simulation as an explicit component of OpenMDAO, with exact partial derivatives."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import count
from typing import Any

import numpy as np

from ..analyses import Problem
from ..analyses.optimization import DesignError

try:
    import openmdao.api as om
except ImportError:
    raise ImportError("this bridge needs OpenMDAO. Install it with: pip install openmdao") from None


class MechanismComponent(om.ExplicitComponent):
    """Inputs are the design variables, outputs the responses, under their names with ``_`` for every other character.

    The second of two equal names ends with ``_2``; responses can be given names of their own, ``Final(..., name=)``.

    Options
    -------
    problem : the simulation
    """

    def initialize(self) -> None:
        """Declare the options."""
        self.options.declare("problem", types=Problem, recordable=False)

    def setup(self) -> None:
        """Declare inputs and outputs."""
        problem: Problem = self.options["problem"]
        self.inputs_of = words(problem.names)
        self.outputs_of = words(problem.titles)
        for name, value in zip(self.inputs_of, problem.x0, strict=True):
            self.add_input(name, val=value)
        for name in self.outputs_of:
            self.add_output(name)

    def setup_partials(self) -> None:
        self.declare_partials("*", "*")

    def compute(self, inputs: Any, outputs: Any) -> None:
        """Simulate; an AnalysisError makes drivers step back."""
        try:
            values = self.options["problem"].values(self._design(inputs))
        except DesignError as error:
            raise om.AnalysisError(str(error)) from None
        for name, value in zip(self.outputs_of, values, strict=True):
            outputs[name] = value

    def compute_partials(self, inputs: Any, partials: Any) -> None:
        """Compute the partial derivatives by one adjoint sweep."""
        matrix = self.options["problem"].gradient(self._design(inputs)).matrix
        for row, of in enumerate(self.outputs_of):
            for column, wrt in enumerate(self.inputs_of):
                partials[of, wrt] = matrix[row, column]

    def _design(self, inputs: Any) -> Any:
        return np.array([float(np.ravel(inputs[name])[0]) for name in self.inputs_of])


def word(name: str) -> str:
    """A name as OpenMDAO takes it: ``spring.k`` is ``spring_k``."""
    return "".join(c if c.isalnum() else "_" for c in name).strip("_")


def words(names: Iterable[str]) -> list[str]:
    """Names as OpenMDAO takes them, each of them once."""
    unique: list[str] = []
    for name in names:
        choices = (word(name) + (f"_{n}" if n > 1 else "") for n in count(1))
        unique.append(next(choice for choice in choices if choice not in unique))
    return unique
