"""Arguments that no caller should give: a TypeError or ValueError of ours that names the argument."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.analyses.progress import monitor, refuse_time_limit
from sarrus.model.checks.arguments import CHECKS, Number, WholeNumber, checked

NAN = float("nan")
HOSTILE: list[Any] = [
    NAN, float("inf"), "", "text", -1, 10**400, b"x", 1j, [NAN], [None], ["a"], [1, [2]], {1: 2},
    np.array(["a"]),
    np.zeros((2, 2)), Path("nowhere"), len, object, sr, sr.HHT,
]  # fmt: skip


@pytest.fixture(scope="module")
def crank() -> tuple[sr.System, sr.Assembly]:
    system = sr.System(sr.load(mechanisms.path("slider_crank")))
    return system, sr.assemble(system)


CALLS: dict[str, tuple[Callable[..., Any], str]] = {
    "simulate": (sr.simulate, "until t_eval events method store save limits"),
    "assemble": (sr.assemble, "q v t tolerance iterations restarts seed fixed rates metric"),
    "equilibrium": (sr.equilibrium, "q t iterations stable"),
    "mobility": (sr.mobility, "q t tolerance"),
    "kinematics": (sr.kinematics, "times q time_limit progress"),
    "linearize": (sr.linearize, "q v t turning"),
    "inverse_dynamics": (sr.inverse_dynamics, "run"),
}  # fmt: skip


def error_of(function: Callable[..., Any], *args: Any, **kwargs: Any) -> Exception | None:
    try:
        function(*args, **kwargs)
    except Exception as error:
        return error
    return None


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.filterwarnings("ignore::sarrus.SarrusWarning")
def test_hostile_arguments_are_refused_by_name(
    name: str, crank: tuple[sr.System, sr.Assembly], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # runs are saved in folders of these names
    system, start = crank
    function, names = CALLS[name]
    good: dict[str, Any] = (
        {"until": 0.001} if name == "simulate" else {"times": [0.0]} if name == "kinematics" else {}
    )
    good |= {"q": start.q} if name == "linearize" else {}
    for argument in names.split():
        for value in HOSTILE:
            raised = error_of(function, system, **{**good, argument: value})
            if raised is not None:
                last = traceback.extract_tb(raised.__traceback__)[-1]
                ours = "/sarrus/" in last.filename and (last.line or "").startswith("raise")
                assert ours, (argument, value, raised, last)


OPTIONS = {
    sr.Radau: "rtol atol max_step first_step",
    sr.HHT: "alpha step stabilized rtol",
    sr.Limits: "time steps errors",
}  # fmt: skip


@pytest.mark.parametrize("kind", OPTIONS)
def test_hostile_options_are_refused_by_name(kind: type, crank: tuple[sr.System, sr.Assembly]) -> None:
    option = "limits" if kind is sr.Limits else "method"

    def simulated(**given: Any) -> None:
        sr.simulate(*crank, until=0.001, **{option: kind(**given)})

    for argument in OPTIONS[kind].split():
        for value in HOSTILE:
            raised = error_of(simulated, **{argument: value})
            if raised is not None:
                last = traceback.extract_tb(raised.__traceback__)[-1]
                ours = "/sarrus/" in last.filename and (last.line or "").startswith("raise")
                assert ours, (argument, value, raised, last)


READERS = [sr.load, sr.load_any, sr.load_urdf, sr.load_run, sr.open_study, sr.parse_expression]


@pytest.mark.parametrize("function", READERS)
def test_what_is_no_path_or_text_is_refused(function: Callable[..., Any]) -> None:
    for value in (None, 1, 2.5, b"x", [], {}, len, np.zeros(3)):
        with pytest.raises(TypeError, match=r"(path|folder|text) must be"):
            function(value)


def test_numbers_and_whole_numbers() -> None:
    Number()("t", np.float64(2.0))
    Number(positive=True, infinite=True)("max_step", np.inf)
    for wrong in (0.0, -1.0, NAN, np.inf):
        with pytest.raises(ValueError, match=r"^step must be a positive number"):
            Number(positive=True)("step", wrong)
    with pytest.raises(TypeError, match=r"^seed must be a whole number, got float 1\.5\. Give one\.$"):
        WholeNumber()("seed", 1.5)
    with pytest.raises(TypeError, match="got bool True"):
        WholeNumber()("seed", True)


def test_arguments_that_are_left_out_or_unknown_pass() -> None:
    @checked
    def function(path: str, seed: int | None = None, other: Any = None) -> Any:
        return path, seed, other

    assert function("a", None, other=len) == ("a", None, len)
    assert function("a", seed=3) == ("a", 3, None)
    with pytest.raises(TypeError, match=r'no argument "sead". Did you mean "seed"'):
        function("a", sead=3)  # type: ignore[call-arg]
    assert {"until", "path", "seed"} <= CHECKS.keys()


@pytest.mark.parametrize("until", [1e308, 1e-300, NAN, -1.0, 0.0])
def test_an_end_that_no_run_reaches_is_refused(until: float, crank: tuple[sr.System, sr.Assembly]) -> None:
    with pytest.raises(ValueError, match=r"^until must be"):
        sr.simulate(*crank, until=until)


FORMER = ("verify_workspace", "sensitivity_by_checkpoints")  # names
WITH_LIMITS = {
    name: limit
    for name in sr.__all__
    if callable(function := getattr(sr, name)) and not isinstance(function, type)
    for limit in inspect.signature(function).parameters
    if limit in ("time_limit", "total_time_limit") and name not in FORMER
}


@pytest.mark.parametrize("value", ["a", NAN, 0, -1.0, True, None, [1.0]])
def test_a_time_limit_means_the_same_everywhere(value: Any) -> None:
    """In every public function, and in the monitor that all of them share."""
    good = {"until": 1.0, "times": [0.0], "path": "run", "parameters": {}, "inputs": ["crank"]}
    assert {"kinematics", "workspace", "study", "optimize", "hessian"} <= WITH_LIMITS.keys()
    for name, limit in WITH_LIMITS.items():
        function = getattr(sr, name)
        needed = [
            p for p in inspect.signature(function).parameters.values() if p.default is p.empty and p.kind < 4
        ]
        given = {p.name: good.get(p.name) for p in needed if p.name != limit}
        if value is not None:
            with pytest.raises((TypeError, ValueError), match=rf"^{limit} must be a "):
                function(**given, **{limit: value})
    if value is None:
        refuse_time_limit(value)
    else:
        with (
            pytest.raises((TypeError, ValueError), match=r"^time_limit must be a "),
            monitor(None, time_limit=value),
        ):
            pass
        with pytest.raises((TypeError, ValueError), match=r"^time_limit must be a "):
            sr.Problem(
                sr.System(sr.load(mechanisms.path("slider_crank"))), "slider.x", until=1.0, time_limit=value
            )
