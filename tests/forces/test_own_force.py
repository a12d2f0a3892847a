"""A force of one's own: the guide's code runs, and a class with only Q is refused until it asks for derivatives."""

import contextlib
import io
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
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


def pendulum(element: str) -> sr.System:
    """The pendulum of the guide, with one of its elements."""
    parts = blocks("python")
    classes = [parts[0], next(part for part in parts if "class PotentialMagnet" in part)]
    system = run("\n".join([*classes, parts[1].replace("Primitive(Magnet,", f"Primitive({element},")]))[
        "system"
    ]
    assert isinstance(system, sr.System)
    return system


def test_a_force_from_its_potential_is_that_of_Q() -> None:
    """Operators, a run, its gradient and Hessian agree, and the sum of energies is constant."""
    one, other = pendulum("Magnet"), pendulum("PotentialMagnet")
    state = one.q0, np.linspace(-1, 1, one.nq)
    for name in ("Q", "Q_q", "Q_b"):
        wanted, found = (getattr(system, name)(*state, 0.0) for system in (one, other))
        assert abs(wanted - found).max() < 1e-13
    assert other.check_derivatives()
    runs = [
        sr.simulate(system, until=0.5, method=sr.Radau(rtol=1e-9), store="steps") for system in (one, other)
    ]
    energy = runs[1]["energy.total"]
    assert np.ptp(energy) < 1e-6 < np.ptp(runs[0]["energy.total"])
    gradients = [sr.sensitivity(run, "bob.x", ["magnet.strength", "bob.mass"]) for run in runs]
    assert gradients[0].matrix == pytest.approx(gradients[1].matrix, rel=1e-9)
    assert runs[0].q == pytest.approx(runs[1].q, abs=1e-10)
    by_strength = sr.sensitivity(runs[1], "energy.potential", ["magnet.strength"]).matrix
    assert abs(by_strength) > 0.1


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
