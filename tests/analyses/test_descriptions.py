"""Descriptions of methods: the steps that the time integration loops take are those that are described."""

import pickle
import runpy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.examples.problems import FOLDER
from tests.sensitivity.frozen import solved
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.methods.collocation import radau
from sarrus.analyses.dynamics.methods.description import Affine, Operation
from sarrus.analyses.equations.length import kinematic_weights
from sarrus.analyses.sensitivity.steps.record import STEP, Record

OWN = {  # methods of users, in scripts of the gallery
    name: sr.DescribedMethod(runpy.run_path(str(FOLDER / f"{name}.py"))["METHOD"])
    for name in ("implicit_midpoint", "bdf2")
}
METHODS = {
    "HHT": sr.HHT(),
    "generalized-alpha": sr.GeneralizedAlpha(0.7),
    "stabilized HHT": sr.HHT(stabilized=True),
    "stabilized generalized-alpha": sr.GeneralizedAlpha(0.7, stabilized=True),
    "Radau": sr.Radau(),
    **OWN,
}


def run(method: Any) -> sr.Trajectory:
    return solved(
        sr.simulate(
            slider_crank(),
            until=0.5,
            t_eval=[0.5],
            method=replace(method, rtol=1e-5, atol=1e-7),
            store="steps",
        ),
        method,
    )


def residuals(
    system: sr.System, steps: Any, operation: Operation, stages: list[dict[str, Any]], n: int
) -> list[Any]:
    """Of all equations of step n, with the operators of the system; scaled as described."""
    b = steps.b.copy()
    b[steps.places] = steps.memory[n]
    found, W = [], kinematic_weights(system)
    for kind, s, scale, _ in operation.step.equations:
        x = stages[s]
        q, t = x["q"], x["t"]
        value = {
            "motion": lambda x=x, q=q, t=t: system.M_a(q, x["a"], b=b) + system.Phi_qT_lam(q, x["lam"], t, b=b)
            - system.Q(q, x["v"], t, b=b) - system.S(q, x["v"], b=b),
            "position": lambda q=q, t=t: system.Phi(q, t, b=b),
            "velocity": lambda x=x, q=q, t=t: system.Phi_q_xi(q, x["v"], t, b=b) + system.Phi_t(q, t, b=b),
            "kinematic": lambda x=x, q=q, t=t: W * x["rate"] + system.Phi_qT_lam(q, x["mu"], t, b=b),
        }[kind]()  # fmt: skip
        found.append(np.broadcast_to(scale, len(steps))[n] * value)
    return found


def combined(affine: Affine, blocks: dict[str, Any], n: int, count: int) -> Any:
    """What an affine map gives in step n."""
    return sum(np.broadcast_to(factor, count)[n] * blocks[name] for name, factor in affine.items())


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_steps_are_those_that_are_described(method: Any) -> None:
    """With the recorded stages as unknowns all equations hold, and the state after the step is the next one."""
    trajectory = run(method)
    system, steps = trajectory.system, trajectory.steps
    record = Record(system, steps)
    one, count = record.operations[STEP], len(steps)
    step = one.operation.step
    removed = getattr(steps, "removed", np.zeros(count))
    first = {name: getattr(steps, name)[0] for name in ("q", "v", "a", "lam")}
    extra = {name: combined(by, first, 0, 1) for name, by in record.extra.items()}
    for n in range(count):
        known = {"q": steps.q[n], "v": steps.v[n].copy(), "a": steps.a[n], "lam": steps.lam[n], **extra}
        if removed[n]:
            known["v"] -= removed[n] * steps.correction[n]
        stages = one.stages_at(n)
        for s, stage in enumerate(
            step.stages
        ):  # the unknowns, from quantities of stages that are one of them alone
            for name in ("q", "v", "a", "lam", "mu"):
                affine = getattr(stage, name)
                if len(affine) == 1 and (own := next(iter(affine))) in one.operation.unknowns:
                    known[own] = stages[s][name] / np.broadcast_to(affine[own], count)[n]
        assert set(known) >= set(one.operation.unknowns)
        for s, stage in enumerate(step.stages):
            stages[s]["rate"] = combined(stage.rate, known, n, count)
            for name in ("q", "v", "a"):
                wanted, found = stages[s].get(name), combined(getattr(stage, name), known, n, count)
                if wanted is not None:
                    assert abs(found - wanted).max() < 1e-10 * max(1.0, abs(wanted).max()), (n, s, name)
        gap = max(abs(value).max() for value in residuals(system, steps, one.operation, stages, n))
        assert gap < 2e-8 * abs(steps.a).max(), (n, gap)
        extra = {name: combined(step.update[name], known, n, count) for name in extra}
        for name, affine in step.update.items():
            after = getattr(steps, name)[n + 1] if hasattr(steps, name) else extra[name]
            assert abs(combined(affine, known, n, count) - after).max() < 1e-10 * max(
                1.0, abs(after).max()
            ), (n, name)


@pytest.mark.parametrize("stages", [1, 2, 3, 4])
def test_radau_methods_of_all_orders_solve_a_linear_equation_to_their_order(stages: int) -> None:
    """Of y' = k y, which is the kinematic equation of a free body with v = k q."""
    step, k = radau(stages).step(0.1, 1.0), 1.0
    names = [f"Q{i}" for i in range(stages)]
    A = np.array([[stage.rate.get(name, 0.0) for name in names] for stage in step.stages])
    right = np.array([-stage.rate["q"] for stage in step.stages])
    end = np.linalg.solve(A - k * np.eye(stages), right)[-1]
    assert abs(end - np.exp(0.1 * k)) < 0.1 ** (2 * stages)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", ["HHT", "generalized-alpha", "stabilized HHT", "Radau"])
def test_runs_whose_steps_are_stored_can_be_pickled(method: str) -> None:
    stored = run(METHODS[method])
    copied = pickle.loads(pickle.dumps(stored))
    wanted, found = (sr.sensitivity(one, "slider.x", ["crank.mass"]).matrix for one in (stored, copied))
    np.testing.assert_array_equal(found, wanted)
