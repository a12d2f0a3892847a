"""Warnings of analyses: issued once, stored in results, printed with them, raised by `strict`, saved with runs."""

from __future__ import annotations

import inspect
import types
import warnings
from pathlib import Path
from typing import Any

import pytest

import sarrus as sr
from sarrus.model.announcement import announce
from sarrus.results.result import Result

ANALYSES = [
    name
    for name in sr.__all__
    if isinstance(getattr(sr, name), types.FunctionType)
    and getattr(sr, name).__module__.startswith(("sarrus.analyses", "sarrus.studies"))
]
FORMER = ("sensitivity_by_checkpoints", "verify_workspace")  # deprecated names
MESSAGE = "rod: something is odd. Look at it."


def slider() -> sr.System:
    """A rod on a vertical slide, held by a spring."""
    rod = sr.Body("rod", 1.0, (1.0, 1.0, 1.0))
    slide = sr.Translational("slide", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), rod.point(0, 0, 1), k=10.0, length=0.5)
    return sr.System(sr.Model("m", [rod], [slide], [spring]))


def odd(t: float = 0.0) -> None:
    """A progress function that warns, as anything within an analysis may."""
    announce([MESSAGE])


@pytest.mark.parametrize("name", [name for name in ANALYSES if name not in ("open_study", *FORMER)])
def test_every_analysis_accepts_the_deprecated_keyword(name: str) -> None:
    """Before its arguments are looked at, so that wrong ones do here."""
    assert "strict" not in inspect.signature(getattr(sr, name)).parameters
    told = r"strict= is deprecated\. Use a block `with sr.strict\(\):`"
    with pytest.warns(DeprecationWarning, match=told), pytest.raises((TypeError, ValueError)):
        getattr(sr, name)(strict=True)


def test_the_deprecated_keyword_is_that_block() -> None:
    with (
        pytest.warns(DeprecationWarning, match="strict= is deprecated") as seen,
        pytest.raises(sr.StrictError, match="rod: something is odd"),
    ):
        sr.simulate(slider(), until=0.1, progress=odd, strict=True)  # type: ignore[call-arg]
    assert seen[0].filename == __file__


def test_strict_is_of_a_block_and_of_its_thread() -> None:
    with pytest.raises(sr.StrictError), sr.strict():
        announce([MESSAGE])
    with pytest.warns(sr.SarrusWarning, match="odd"):
        announce([MESSAGE])
    with pytest.warns(sr.SarrusWarning, match="odd"), sr.strict(), sr.strict(False):
        announce([MESSAGE])
    with pytest.raises(TypeError, match="strict must be True or False"), sr.strict(1):  # type: ignore[arg-type]
        pass


def test_every_result_has_warnings() -> None:
    results = [
        getattr(sr, name)
        for name in [name for name, home in sr._HOME_OF.items() if home == ".results"]
        + ["StudyTable", "Uncertainty"]
    ]
    without = {one.__name__ for one in results if isinstance(one, type) and not issubclass(one, Result)}
    assert without <= {"EventRecord", "Reaction", "Singularity", "Solution", "State"}


def test_a_warning_is_issued_once_and_printed_with_the_result() -> None:
    with pytest.warns(sr.SarrusWarning, match="odd") as seen:
        run = sr.simulate(slider(), until=0.1, progress=odd)
    assert [str(one.message) for one in seen] == [MESSAGE]
    assert seen[0].filename == __file__
    assert run.warnings == (MESSAGE,)
    assert str(run).splitlines()[-1] == f"warning: {MESSAGE}"
    assert MESSAGE not in run.summary()


def test_a_strict_analysis_raises() -> None:
    with pytest.raises(sr.StrictError, match="rod: something is odd"), sr.strict():
        sr.simulate(slider(), until=0.1, progress=odd)


def test_nothing_is_left_behind_by_an_analysis_that_raised() -> None:
    with pytest.raises(sr.StrictError), sr.strict():
        sr.simulate(slider(), until=0.1, progress=odd)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sr.simulate(slider(), until=0.1).warnings == ()


def test_a_saved_run_has_its_warnings(tmp_path: Path) -> None:
    folder, system = tmp_path / "run.sarrus", slider()
    with pytest.warns(sr.SarrusWarning):
        run = sr.simulate(system, until=0.1, progress=odd, save=folder)
    assert run.warnings == (MESSAGE,)
    assert sr.load_run(folder).warnings == (MESSAGE,)
    assert sr.resume(folder).warnings == (MESSAGE,)


def measured(system: sr.System) -> dict[str, float]:
    """An analysis of a study that warns for heavy rods."""
    if system.model.bodies[0].mass > 1.5:
        announce([MESSAGE])
    return {"x": 1.0}


def test_a_study_collects_the_warnings_of_its_cases(tmp_path: Path) -> None:
    masses = {"rod.mass": [1.0, 2.0, 3.0]}
    with pytest.warns(sr.SarrusWarning, match="odd") as seen:
        table = sr.study(slider().model, masses, ["x"], analysis=measured, workers=1, folder=tmp_path / "s")
    assert len(seen) == 1
    assert table.case_warnings == {1: (MESSAGE,), 2: (MESSAGE,)}
    assert table.warnings == (f"{MESSAGE} (2 of 3 cases)",)
    assert sr.open_study(tmp_path / "s").case_warnings == table.case_warnings


def test_an_optimum_has_the_warnings_of_its_best_design_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first design warns, the best one does not."""
    from sarrus.analyses.dynamics import recipe

    own = recipe.stops_of

    def stiff(system: sr.System, *given: Any, **more: Any) -> Any:
        if system.model.forces[0].k < 11:
            announce([MESSAGE])
        return own(system, *given, **more)

    monkeypatch.setattr(recipe, "stops_of", stiff)
    best = sr.optimize(slider(), sr.Final("rod.z"), ["spring.k"], bounds={"spring.k": (9.0, 12.0)}, until=0.2)
    assert best["spring.k"] > 11
    assert best.warnings == ()
