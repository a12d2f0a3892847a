"""Responses evaluated on a run: their values, and their gradients by its states and by the numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...algebra import Array
from ...results import Steps
from ...system import System
from .chain import Nodes
from .outputs import Outputs
from .parameters import Parameters
from .responses import Response
from .sampling import Sampling


@dataclass(frozen=True)
class Explicit:
    """Gradients of responses that do not go through the states: by b, by the joints' numbers, by named parameters."""

    b: Array
    c: Array
    named: list[dict[str, float]]


class Evaluation:
    """Responses of one run.

    Parameters
    ----------
    system, steps : the run
    responses : evaluated in this order
    parameters : whose numbers responses may use
    """

    def __init__(
        self, system: System, steps: Steps, responses: Sequence[Response], parameters: Parameters
    ) -> None:
        self._system, self._steps, self._responses = system, steps, responses
        self._samplings = [Sampling(steps, response.times(steps.t)) for response in responses]
        nodes = Sampling(steps).states
        self._outputs = [
            Outputs(system, sampling.states, steps.b, parameters.number, nodes)
            for sampling in self._samplings
        ]
        pairs = zip(responses, self._outputs, strict=True)
        self._found = [response.evaluate(outputs) for response, outputs in pairs]
        self.signals = [
            np.broadcast_to(np.asarray(found.value, dtype=float), sampling.t.shape)
            for found, sampling in zip(self._found, self._samplings, strict=True)
        ]
        self.values = np.array(
            [r.value(g, s.t) for r, g, s in zip(responses, self.signals, self._samplings, strict=True)]
        )

    def gradients(self) -> tuple[Nodes, Explicit]:
        """The gradients of all responses, one column each."""
        count = len(self._responses)
        nodes, by_b = Nodes.zeros(self._steps, count), np.zeros((len(self._system.b), count))
        by_c, named = np.zeros((len(self._system.joint_coordinates.b), count)), []
        for column, (response, outputs) in enumerate(zip(self._responses, self._outputs, strict=True)):
            sampling, g = self._samplings[column], self.signals[column]
            found = outputs.tape.gradient({self._found[column].at: response.weights(g, sampling.t)})
            for (kind, n), variable in outputs.inputs.items():
                bar = found[variable.at]
                if kind in ("b", "c"):
                    (by_b if kind == "b" else by_c)[n, column] += bar
                else:
                    sampling.spread(kind, n, np.broadcast_to(bar, sampling.t.shape), nodes, column)
            named.append(
                {name: float(np.sum(found[variable.at])) for name, variable in outputs.named.items()}
            )
        return nodes, Explicit(by_b, by_c, named)

    def signals_along(self, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array]) -> list[Array]:
        """The change of every response's output at its times, (nt, k), with changes of states and numbers (…, k)."""
        return [self._signal_along(n, dots, b, c, named) for n in range(len(self._responses))]

    def _signal_along(self, n: int, dots: Nodes, b: Array, c: Array, named: Mapping[str, Array]) -> Array:
        outputs, sampling, columns = self._outputs[n], self._samplings[n], b.shape[1]
        found = np.zeros((len(sampling.t), columns))
        for k in range(columns):
            changes = {}
            for (kind, place), variable in outputs.inputs.items():
                numbers = {"b": b, "c": c}.get(kind)
                own = sampling.gathered(kind, place, dots, k) if numbers is None else float(numbers[place, k])
                changes[variable.at] = own
            changes |= {v.at: float(named[name][k]) for name, v in outputs.named.items() if name in named}
            found[:, k] = outputs.tape.along(changes)[self._found[n].at]
        return found
