"""What numbers of curves do to the steps of a run of Radau; see `curves`, which does so for the α methods."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import RadauSteps
from ...system.curve_derivatives import Entries
from .curves import CurvesOf
from .radau_sweep_loop import Beside


class RadauCurves(CurvesOf[RadauSteps]):
    """The derivatives of all stages and nodes of a run of Radau by the numbers of curves."""

    def sources(self, db: Array) -> Beside:
        """The changes of the equations of all steps and nodes."""
        nq, m = self._system.nq, self._system.m
        stages = []
        for mu, lam, load, row, rate, drift in self._stages:
            second = lam.along(db, nq) - load.along(db, nq)
            stages += [mu.along(db, nq), second, row.along(db, m), rate.along(db, m) + drift.along(db, m)]
        lam, load, rate, bend = self._nodes
        node = [lam.along(db, nq) - load.along(db, nq), rate.along(db, m) - bend.along(db, m)]
        return Beside(np.concatenate(stages, axis=1), np.concatenate(node, axis=1))

    def gradient(self, kept: Beside) -> Array:
        """What the adjoint variables of all steps and nodes give for the gradients by the numbers (len(b), k)."""
        nq, m, size = self._system.nq, self._system.m, self.width
        total = np.zeros((size, kept.step.shape[2]))
        for i, (mu, lam, load, row, rate, drift) in enumerate(self._stages):
            cuts = 2 * i * (nq + m) + np.cumsum([0, nq, nq, m, m])
            first, second, third, fourth = (kept.step[:, a:z] for a, z in pairwise(cuts))
            total -= mu.gradient(first, size) + lam.gradient(second, size) - load.gradient(second, size)
            total -= row.gradient(third, size) + rate.gradient(fourth, size) + drift.gradient(fourth, size)
        lam, load, rate, bend = self._nodes
        y, z = kept.node[:, :nq], kept.node[:, nq:]
        total -= (
            lam.gradient(y, size) - load.gradient(y, size) + rate.gradient(z, size) - bend.gradient(z, size)
        )
        return total

    @cached_property
    def _stages(self) -> list[tuple[Entries, ...]]:
        """Of Φ_qᵀμ, Φ_qᵀλ, Q, Φ, Φ_q v and Φ_t at the three stages of all steps."""
        steps, found = self._steps, []
        memory = dict(zip(steps.places.tolist(), steps.memory.T, strict=True))
        for i in range(3):
            q, v = steps.stage_q[:, i], steps.stage_v[:, i]
            at = {"q": q, "t": steps.t[:-1] + steps.scheme.c[i] * steps.h}
            given: tuple[tuple[str, dict[str, Any]], ...] = (
                ("Phi_qT_lam", {"lam": steps.stage_mu[:, i]}), ("Phi_qT_lam", {"lam": steps.stage_lam[:, i]}),
                ("Q", {"v": v}), ("Phi", {}), ("Phi_q_xi", {"xi": v}), ("Phi_t", {}),
            )  # fmt: skip
            found.append(tuple(self.of(name, steps.b, memory, **at, **own) for name, own in given))
        return found

    @cached_property
    def _nodes(self) -> tuple[Entries, ...]:
        """Of Φ_qᵀλ, Q, Φ_q a and γ at all nodes."""
        steps = self._steps
        numbers = np.concatenate([steps.memory[:1], steps.memory])
        memory = dict(zip(steps.places.tolist(), numbers.T, strict=True))
        at = {"q": steps.q, "t": steps.t}
        given = (("Phi_qT_lam", {"lam": steps.lam}), ("Q", {"v": steps.v}), ("Phi_q_xi", {"xi": steps.a}),
                 ("gamma", {"v": steps.v}))  # fmt: skip
        return tuple(self.of(name, steps.b, memory, **at, **own) for name, own in given)
