"""Torques on a rotor, whose spin is a state of a block: on the wheel of a tyre."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...algebra import Row
from ...elements import Pair
from ...elements.element import Scalar
from ...elements.forces.tyres.contact import MASS
from ...elements.forces.tyres.rotor import SPIN, Rotor
from ...euler import rotate
from ..forces.formula_element import FormulaLoad

HIDDEN = ("force_i", "torque_i", "force_i_body", "torque_i_body")  # of the block of the states


class RotorTorque(FormulaLoad, abstract=True):
    """Base of the classes of torques on a rotor."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.outputs = {word: one for word, one in cls.outputs.items() if word not in HIDDEN}

    def power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """The torque times the rate of the rotor, relative to what has the reaction."""
        last, act = len(self.structure.parts) - 1, self.structure.act
        assert isinstance(act, OnRotor)
        x_own, v_own = self._local(last, x), self._local(last, v)
        spin = self.loaded().rate(x_own, v_own) if act.reacts else v_own.r_i[SPIN]
        return self.values(x, v, t)[0] * spin


class OnRotor(NamedTuple):
    """A torque on a rotor, with the reaction on its carrier, or on none as of a shaft from elsewhere."""

    reacts: bool
    base: type[FormulaLoad] = RotorTorque

    def __call__(self, of: Rotor, values: Any, x: Pair, v: Pair, t: Scalar) -> Row:
        """J Ẇ = torque."""
        on_spin = np.array([0, 0, MASS * values[0] / of.spin_inertia])
        reaction = of.generalized(-values[0] * rotate(x.p_j, of.axis), x) if self.reacts else None
        return on_spin, None, None, reaction
