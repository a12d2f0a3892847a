"""Linear systems of several variables by their matrices, against SciPy and the reduced equations."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp
from tests.states.gradients import differences, direct_and_adjoint
from tests.states.motors import INERTIA, TIGHT, WEIGHT, arm, value

import sarrus as sr
from sarrus.model import ModelError
from sarrus.model.written import with_numbers, written_numbers

A = [[0.0, 1.0, 0.0, 0.2], [-4.0, -0.4, 0.0, 0.0], [1.0, 0.0, -2.0, 0.0], [0.0, 0.3, 0.0, -1.0]]
B = [[0.0, 1.0], [1.0, 0.5], [0.0, 0.0], [2.0, 0.0]]
C = [[1.0, 0.0, 0.0, 1.0], [0.0, 2.0, 1.0, 0.0]]
D = [[0.0, 0.0], [0.5, -1.0]]
START = [0.1, -0.2, 0.3, 0.0]
PARTS = [[-3.0, 1.0], [0.0, -5.0]], [[2.0, 0.5], [1.0, 0.0]], [[4.0, -6.0]], [[9.0, 0.0]]


def given(*matrices: Any) -> dict[str, Any]:
    """Matrices by name."""
    return dict(zip("ABCD", matrices, strict=False))


def controlled() -> sr.Model:
    """The arm with a controller of two inputs, whose output is the torque."""
    block = sr.StateSpaceBlock("ss", **given(*PARTS), inputs=["0.3 - pin.angle", "pin.rate"])
    return arm(block, sr.Torque("drive", "pin", value="ss.y1"))


def test_several_inputs_and_outputs_are_those_of_scipy() -> None:
    """A constant and a ramp, between which `lsim` makes no error."""
    system, times = signal.StateSpace(A, B, C, D), np.linspace(0, 2, 1001)
    u = np.column_stack([np.full(1001, 1.5), 2 * times])
    _, y, x = signal.lsim(system, u, times, X0=START)
    block = sr.StateSpaceBlock.of(
        "ss", system, inputs=[1.5, "k*t"], initial=START, unit="V", parameters={"k": 2}
    )
    run = sr.simulate(sr.System(arm(block)), until=2.0, **TIGHT)
    assert np.array([value(run, f"ss.y{n}") for n in (1, 2)]).T == pytest.approx(y, abs=1e-8)
    assert np.array([value(run, f"ss.x{n}") for n in (1, 2, 3, 4)]).T == pytest.approx(x, abs=1e-8)
    assert run.output("ss.y2").unit == "V"


def test_a_controller_by_its_matrices_follows_the_reduced_equations() -> None:
    own = [np.array(matrix) for matrix in PARTS]

    def rates(t: float, y: Any) -> list[float]:
        u = np.array([0.3 - y[0], y[1]])
        (torque,) = own[2] @ y[2:] + own[3] @ u
        return [y[1], (torque - WEIGHT * np.cos(y[0])) / INERTIA, *(own[0] @ y[2:] + own[1] @ u)]

    run = sr.simulate(sr.System(controlled()), until=1.0, **TIGHT)
    y = solve_ivp(rates, (0, 1), np.zeros(4), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    names = "pin.angle", "pin.rate", "ss.x1", "ss.x2"
    assert [value(run, name)[-1] for name in names] == pytest.approx(y, abs=1e-8)


@pytest.mark.parametrize("name", ["servo.yaml", "servo.json"])
def test_a_block_is_saved_and_read(name: str, tmp_path: Path) -> None:
    model = controlled()
    model.save(tmp_path / name)
    runs = [sr.simulate(sr.System(one), until=0.1) for one in (model, sr.load(tmp_path / name))]
    assert np.array_equal(runs[0].v, runs[1].v)


def test_entries_of_a_file_follow_its_parameters(tmp_path: Path) -> None:
    controlled().save(tmp_path / "servo.yaml")
    text = (tmp_path / "servo.yaml").read_text()
    text = text.replace("[[-3, 1]", "[[-pole, 1]").replace("gravity:", "parameters: {pole: 3}\ngravity:")
    (tmp_path / "servo.yaml").write_text(text)
    runs = [
        sr.simulate(sr.System(one), until=0.2, store="steps")
        for one in (controlled(), sr.load(tmp_path / "servo.yaml"))
    ]
    one = sr.sensitivity(runs[0], sr.Final("pin.angle"), wrt=["ss.A.1.1"])["ss.A.1.1"]
    other = sr.sensitivity(runs[1], sr.Final("pin.angle"), wrt=["pole"])["pole"]
    assert other == pytest.approx(-one, rel=1e-12)


def test_gradients_by_entries_are_differences_of_runs_and_direct_is_adjoint() -> None:
    """Also by an entry that is 0."""
    model = controlled()
    names = [name for name in written_numbers(model) if name.startswith(("ss.A", "ss.B", "ss.C", "ss.D"))]
    direct, adjoint = direct_and_adjoint(model, "pin.angle", names, 0.3, rtol=1e-10)
    assert direct == pytest.approx(adjoint, rel=1e-9, abs=1e-15)
    some = [name for name in names if written_numbers(model)[name]]
    wanted = dict(zip(some, differences(model, "pin.angle", some, 0.3, 1e-3), strict=True))
    for name in ("ss.A.2.1", "ss.B.2.2"):
        ends = [with_numbers(model, {name: h}) for h in (-1e-2, 1e-2)]
        low, high = (value(sr.simulate(sr.System(one), until=0.3, **TIGHT), "pin.angle")[-1] for one in ends)
        wanted[name] = (high - low) / 2e-2
    for name, one in zip(names, direct, strict=True):
        assert one == pytest.approx(wanted[name], rel=1e-4, abs=1e-9), name


@pytest.mark.slow
def test_second_derivatives_are_differences_of_gradients() -> None:
    names, h, found = ["ss.A.1.1", "ss.C.1.2", "ss.D.1.1", "pin.point.x"], 1e-4, []

    def run(**changes: float) -> sr.Trajectory:
        model = with_numbers(controlled(), {name: controls[name] + h for name, h in changes.items()})
        return sr.simulate(sr.System(model), until=0.3, store="steps", method=sr.Radau(rtol=1e-11))

    controls = written_numbers(controlled())
    H = sr.hessian(run(), sr.Final("pin.angle"), wrt=names)
    for name in names[:3]:
        low, high = (sr.sensitivity(run(**{name: s * h}), sr.Final("pin.angle"), wrt=names) for s in (-1, 1))
        found = [(high[one] - low[one]) / (2 * h) for one in names]
        assert [H[name, one] for one in names] == pytest.approx(found, rel=1e-5, abs=1e-9), name


def test_zeros_of_a_direct_passage_are_no_parameters() -> None:
    """They would have a derivative, but not without the loops that they close."""
    filtered = sr.TransferFunction("f", numerator=[0, 1], denominator=[1, 2], input="ss.y1")
    model = controlled()
    model = sr.Model("servo", model.bodies, model.joints, [*model.forces, filtered])
    run = sr.simulate(sr.System(model), until=0.01, store="steps")
    for name in ("ss.D.1.2", "f.numerator.1"):
        with pytest.raises(sr.SarrusError, match=name):
            sr.sensitivity(run, sr.Final("pin.angle"), wrt=[name])


def loop(D: Any) -> sr.Model:
    """A block whose second output is fed back to its first input."""
    return arm(sr.StateSpaceBlock("ss", **given(A, B, C, D), inputs=["-ss.y2", "ss.y1"]))


def test_an_algebraic_loop_is_one_only_where_d_is_not_zero() -> None:
    assert sr.System(loop([[0, 0], [0, 1]])).states
    assert sr.System(loop(None)).states
    with pytest.raises(ModelError, match=r"algebraic loop: ss.y2 → ss.y2. Put a state between"):
        sr.System(loop([[0, 0], [1, 0]]))
    with pytest.raises(ModelError, match=r"algebraic loop: ss.y2 → ss.y1 → ss.y2. Put a state between"):
        sr.System(loop([[1, 0], [0, 1]]))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"A": []}, "A has no states. Give a gain"),
        ({"A": [[1, 2]]}, "A, row 1, must have 1 numbers, but has 2"),
        ({"A": 3.0}, "A must be a matrix, but is 3"),
        ({"B": [[1, 0]]}, "B must have 2 rows, but has 1. Give 2 x 2 numbers"),
        ({"C": [[1]]}, "C, row 1, must have 2 numbers, but has 1"),
        ({"C": [1, 2]}, "C must be a matrix"),
        ({"C": 5}, "C must be a matrix, but is 5"),
        ({"C": []}, "C must be a matrix"),
        ({"C": None}, "C must be a matrix"),
        ({"D": 5}, "D must be a matrix, but is 5"),
        ({"D": [0, 0]}, "D must be a matrix"),
        ({"D": [[1, 0], [0, 1]]}, "D must have 1 rows, but has 2"),
        ({"D": [["a", 0]]}, "D, row 1, must be a number"),
        ({"inputs": []}, "inputs must be a list of formulas"),
        ({"inputs": "t"}, "inputs must be a list of formulas"),
        ({"inputs": ["t"]}, "B, row 1, must have 1 numbers"),
        ({"inputs": ["t", "nothing.x"]}, 'inputs has the unknown name "nothing.x"'),
        ({"initial": [1.0]}, "initial must have 2 numbers, but has 1"),
    ],
)
def test_wrong_blocks_are_refused(changes: Any, message: str) -> None:
    numbers = given(*PARTS) | {"inputs": ["t", "pin.rate"]} | changes
    with pytest.raises(ModelError, match=message):
        sr.System(arm(sr.StateSpaceBlock("ss", **numbers)))


def test_matrices_are_checked_once_for_all_outputs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not for each of the nine."""
    calls: list[str] = []
    check = sr.StateSpaceBlock._matrix

    def noted(block: sr.StateSpaceBlock, field: str, *size: Any) -> Any:
        calls.append(field)
        return check(block, field, *size)

    monkeypatch.setattr(sr.StateSpaceBlock, "_matrix", noted)
    block = sr.StateSpaceBlock("ss", A=A, B=B, C=[[1.0, 0, 0, 0]] * 9, inputs=["t", "2*t"])
    sr.System(arm(block))
    assert calls.count("C") == 2  # with its equations, and where the first output is recorded


@pytest.mark.parametrize("system", [(A, B, C, D), {"A": A}, 5, None], ids=str)
def test_objects_that_are_no_linear_system_are_refused(system: Any) -> None:
    message = (
        'part "x": system must be a linear system of scipy.signal or python-control, but is .* Give one, or '
    )
    with pytest.raises(ModelError, match=message.replace("part", "state space block") + "A, B, C, D by name"):
        sr.StateSpaceBlock.of("x", system)
    with pytest.raises(ModelError, match=message.replace("part", "transfer function") + "num, den by name"):
        sr.TransferFunction.of("x", system)


@pytest.mark.needs("control")
def test_systems_of_python_control_are_accepted() -> None:
    control = pytest.importorskip("control")
    space, fraction = control.ss(A, B, C, D), control.tf([2.0, 3.0], [1.0, 4.0, 5.0])
    block = sr.StateSpaceBlock.of("ss", space)
    assert [block.A, block.B, block.C, block.D] == [A, B, C, D]
    assert len(sr.StateSpaceBlock.of("ss", fraction).A) == 2
    assert sr.TransferFunction.of("tf", fraction).numerator == [2, 3]
    assert sr.TransferFunction.of("tf", control.tf2ss(fraction)).denominator == pytest.approx([1, 4, 5])
    with pytest.raises(ModelError, match="system has a sampling time"):
        sr.TransferFunction.of("tf", control.tf([1.0], [1.0, 2.0], True))


def test_discrete_time_is_refused() -> None:
    with pytest.raises(ModelError, match="system has a sampling time"):
        sr.StateSpaceBlock.of("ss", signal.StateSpace(1, 1, 1, 0, dt=0.1), inputs=["t"])
