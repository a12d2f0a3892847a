"""The log of a search has a line for each design, and one for designs in a row that cannot be simulated."""

import logging

import numpy as np
import pytest

import sarrus as sr


def hanging(k: float = 2.0, c: float = 0.1) -> sr.System:
    ball = sr.Body("ball", mass=2, inertia=(1, 1, 1))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 5), ball.point(0, 0, 0), k=k, c=c, length=4.0)
    return sr.System(sr.Model("hanging", [ball], [], [spring], gravity=(0, 0, -9.81)))


def lines(caplog: pytest.LogCaptureFixture, start: str) -> list[str]:
    """Those of the search; its progress has lines of its own where a computer is slow."""
    of_search = [record.getMessage() for record in caplog.records if record.name == "sarrus.optimize"]
    return [line for line in of_search if line.startswith(start)]


def test_no_line_is_repeated(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "sarrus.optimize")
    at = np.linspace(0.1, 1.0, 10)
    exact = sr.simulate(hanging(1.0, 0.4), until=1.0, t_eval=[0.0, *at])["ball.z"][1:]
    data = sr.Misfit("ball.z", at=at, data=exact + 1e-3 * np.cos(40 * at), sigma=1e-3)
    assert sr.fit(hanging(), data, ["s.k", "s.c"], bounds={"s.k": (0.5, 20), "s.c": (0, 2)}).success
    found = lines(caplog, "simulation")
    assert len(found) == len({one.partition(":")[0] for one in found}) > 2


@pytest.mark.filterwarnings("ignore:ball. its springs")
def test_one_warning_for_failures_in_a_row(caplog: pytest.LogCaptureFixture) -> None:
    """The bounds allow a negative stiffness, which the model refuses."""
    caplog.set_level(logging.INFO, "sarrus.optimize")
    found = sr.optimize(hanging(), "ball.z", ["s.k"], until=0.5, bounds={"s.k": (-1e3, None)}, iterations=3)
    assert 0 < len(lines(caplog, "a design cannot be simulated")) <= len(found.failures)
