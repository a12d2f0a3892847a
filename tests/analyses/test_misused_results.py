"""Every public method of results, with wrong arguments and folders that do not exist, ends in a message of ours."""

import inspect
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank
from tests.workspace.mechanisms import arm_2r

import sarrus as sr
from sarrus.model.deprecated import ATTRIBUTES
from sarrus.outputs import outputs_of

WRONG: tuple[Any, ...] = (
    None,
    3,
    -1,
    10**9,
    2.5,
    float("nan"),
    "nowhere",
    [],
    [1.0, "a"],
    {},
    object(),
    b"x",
)
OURS = (sr.SarrusError, TypeError, ValueError, KeyError)
RAW = (
    "object is not", "object has no attribute", "has no len()", "not supported between", "unhashable", "unsupported",
    "could not convert", "cannot be interpreted", "expected str", "index", "positional argument: ", "not subscriptable",
    "must be real", "ufunc", "required argument", "argument of type", "indices", "invalid literal", "setting an array",
    "broadcast", "not iterable", "not callable", "cannot unpack",
)  # fmt: skip
FORM = (
    "missing",
    "unexpected keyword",
    "positional argument",
    "no argument",
    "without a name",
)  # messages of a call's form


@cache
def results() -> dict[str, Any]:
    system, output, limits = arm_2r()
    crank = slider_crank()
    run = sr.simulate(crank, until=0.01, store="steps")
    area = sr.workspace(system, output, limits=limits, verify=False)
    goal = sr.Final(lambda o: (o.parameter("spring.k") - 9) ** 2 + 0 * o("slider.x"), name="goal")
    rest = sr.equilibrium(crank)
    return {
        "trajectory": run,
        "modes": sr.modes(crank, rest),
        "equilibrium": rest,
        "assembly": sr.assemble(crank),
        "gradient": sr.sensitivity(run, sr.Final("slider.x"), ["spring.k"]),
        "workspace": area,
        "field": sr.workspace_field(area, cells=4),
        "optimum": sr.optimize(crank, goal, ["spring.k"], until=0.01),
        "table": sr.study(
            crank.model, {"spring.k": [9.0, 10.0]}, {"x": "final(slider.x)"}, analysis=sr.Simulation(until=0.01)
        ),
    }  # fmt: skip


def methods(found: Any) -> Iterator[tuple[str, Callable[..., Any], int]]:
    """Public methods that take arguments, and how many of these are needed."""
    old = ATTRIBUTES.get(type(found).__name__, {})
    for name in sorted({*dir(found)} - {*old}):
        method = getattr(found, name, None)
        if not callable(method) or (name.startswith("_") and name != "__getitem__"):
            continue
        if getattr(type(found), name, None) is None or name in ("count", "index"):
            continue
        wanted = [one for one in inspect.signature(method).parameters.values() if one.kind < 2]
        needed = sum(one.default is one.empty for one in wanted)
        if wanted:
            yield name, method, max(needed, 1)


def refused(call: Callable[[], Any]) -> str:
    """What is wrong with how a call ends: nothing where it goes well, or is refused by a message of ours."""
    try:
        call()
    except OURS as error:
        told = str(error)
        if isinstance(error, sr.SarrusError):
            return ""
        plain = any(mark in told for mark in RAW) and not any(form in told for form in FORM)
        return f"{type(error).__name__}: {told}" if plain or not told else ""
    except ImportError:
        return ""
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


KINDS = [
    "trajectory", "modes", "equilibrium", "assembly", "gradient", "workspace", "field", "optimum", "table"
]  # fmt: skip
DRAWN = (
    "plot",
    "view",
    "animate",
    "show",
    "refuse_unknown",
)  # Matplotlib's axes and options are its own matter


@pytest.mark.parametrize("kind", KINDS)
def test_wrong_arguments_are_refused(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found, bad = results()[kind], list[str]()
    for name, method, count in methods(found):
        if name.startswith(DRAWN):
            continue
        for wrong in WRONG:
            told = refused(lambda method=method, wrong=wrong, count=count: method(*[wrong] * count))
            bad += [f"{kind}.{name}({wrong!r}): {told}"] if told else []
    assert not bad, "\n".join(bad)


@pytest.mark.parametrize("kind", KINDS)
def test_exports_to_a_folder_that_does_not_exist(kind: str, tmp_path: Path) -> None:
    found, system = results()[kind], slider_crank()
    nowhere = tmp_path / "nowhere"
    for name, method, _ in methods(found):
        calls = []
        if name.startswith("to_") and "path" in inspect.signature(method).parameters:
            calls = [lambda method=method: method(path=nowhere / "x.csv")]
        elif name in ("animate", "view") and kind in ("trajectory", "workspace"):
            calls = [
                lambda method=method, end=end: method(nowhere / f"x{end}")
                for end in (".html", ".glb", ".gif")
            ]
        elif name == "animate":
            calls = [lambda method=method: method(system, 0, nowhere / "x.html")]
        for call in calls:
            with pytest.raises((sr.SarrusError, ValueError, TypeError)) as raised:
                call()
            told = str(raised.value)
            assert "Make its folder" in told or not isinstance(raised.value, OSError), told
    assert not nowhere.exists()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda r: r["modes"].shape(9, "slider"), "There is no mode with the index 9"),
        (lambda r: r["modes"].shape(-1, "slider"), "mode must be 0 at least"),
        (lambda r: r["modes"].shape("a", "slider"), "mode must be a whole number"),
        (lambda r: sr.Simulation(until="one"), 'until must be a time in s, got "one"'),
        (lambda r: sr.Simulation(until=1.0, steps="many"), "steps must be a whole number"),
        (lambda r: sr.Curve([1, 2], [1]), r"Curve\.table\("),
        (lambda r: sr.Curve((0.0, 1.0), (3.0,)), r"Curve\.table\("),
        (lambda r: sr.Formula(3), r"Formula\(lambda x: 3 \* x\)"),
        (lambda r: r["trajectory"].animate("/nope/x.html"), "Make its folder"),
        (lambda r: sr.Event(object), "an event needs a formula or a function"),
        (lambda r: sr.System(sr.Model("m", [sr.Body("a", mass=1.0, inertia={1: 2})])), "inertia"),
        (lambda r: sr.equilibrium(slider_crank(), 0 * slider_crank().q0), "Euler parameters of .* are all 0"),
    ],
)
def test_calls_that_ended_in_raw_errors(call: Callable[[Any], Any], message: str) -> None:
    with pytest.raises((sr.SarrusError, TypeError, ValueError), match=message):
        call(results())


def pendulum() -> sr.System:
    body = sr.Body("arm", mass=2, inertia=(1, 1, 1), position=(1, 0, 0))
    at: dict[str, Any] = {"point": (0, 0, 0), "axis": (0, 0, 1)}
    pin, spring = (
        sr.Revolute("pin", sr.ground, body, **at),
        sr.RSDA("spring", sr.ground, body, **at, k=3, c=1),
    )
    return sr.System(sr.Model("arm", [body], [pin], [spring], gravity=(0, -9.81, 0)))


def test_a_result_without_states_has_empty_outputs() -> None:
    """Of kinematics that fails at its first time; every output, table and balance is empty."""
    failed = sr.kinematics(pendulum(), [0, 1])
    assert not failed.success
    assert len(failed.t) == 0
    for one in outputs_of(failed.system):
        assert failed.output(one.name).values.shape == (0,)
    assert len(failed.to_frame()) == 0
    balance = failed.energy_balance()
    assert str(balance) == "arm: no states, so no energies"
    assert balance.drift == 0
    assert balance.total.shape == (0,)


def test_a_joint_with_one_coordinate_gives_it_its_name() -> None:
    """``pin``, ``pin.rate`` and ``pin.acceleration``, as formulas of forces have them."""
    run = sr.simulate(pendulum(), until=0.1)
    for end in ("", ".rate", ".acceleration"):
        assert np.array_equal(run.output(f"pin{end}").values, run.output(f"pin.angle{end}").values)
