"""A force of one's own: the guide's code runs, and a class with only Q is refused until it asks for derivatives."""

import contextlib
import io
from pathlib import Path

import pytest

from sarrus.elements import Element, ElementError, Force
from sarrus.elements.element import Scalar
from sarrus.model import Force as ModelForce
from sarrus.model import Joint, load

GUIDE = Path(__file__).parents[2] / "docs" / "how-to" / "own-force.md"


@pytest.fixture(autouse=True)
def _no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Element, "registry", dict(Element.registry))
    monkeypatch.setattr(Joint, "kinds", dict(Joint.kinds))
    monkeypatch.setattr(ModelForce, "kinds", dict(ModelForce.kinds))


def blocks(language: str) -> list[str]:
    return [part.split("```")[0] for part in GUIDE.read_text(encoding="utf-8").split(f"```{language}\n")[1:]]


def run(code: str) -> dict[str, object]:
    scope: dict[str, object] = {"__name__": "guide"}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, str(GUIDE), "exec"), scope)
    return scope


def test_the_model_file_of_the_guide_is_read(tmp_path: Path) -> None:
    run("\n".join(blocks("python")[:2]))
    bodies = "name: m\nbodies:\n  bob: {mass: 1.0, inertia: [1, 1, 1]}\n"
    (tmp_path / "m.yaml").write_text(bodies + blocks("yaml")[0])
    (force,) = load(tmp_path / "m.yaml").forces
    assert type(force).__name__ == "Attraction"


def test_only_Q_is_refused_with_the_message_of_the_guide() -> None:
    element = blocks("python")[0].replace(', derivatives="automatic"', "")
    with pytest.raises(ElementError) as caught:
        run(element)
    assert " ".join(blocks("none")[0].split()) == str(caught.value)
    assert "Magnet" not in Element.registry


def test_a_derivative_that_is_written_is_used() -> None:
    class Push(Force, bodies=1, derivatives="automatic"):
        k: Scalar

        def Q(self, x, v, t):  # type: ignore[no-untyped-def]
            return self.k * x.r, None

        def Q_v(self, x, v, t):  # type: ignore[no-untyped-def]
            return "mine"

    assert Push(k=2.0).Q_v(None, None, 0) == "mine"
    assert callable(Push.Q_q)
    assert callable(Push.Q_q_xi_q)
