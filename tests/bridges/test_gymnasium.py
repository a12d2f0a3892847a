"""A mechanism as an environment of Gymnasium: the worked example of the guide, and Gymnasium's own check."""

import re
import warnings
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.examples.problems import FOLDER
from tests.states.motors import arm

import sarrus as sr

pytest.importorskip("gymnasium")
pytestmark = pytest.mark.needs("gymnasium")
GUIDE = FOLDER.parent / "docs" / "how-to" / "inputs.md"


@cache
def example() -> dict[str, Any]:
    """The names of the guide's example, which has run."""
    block = re.findall(r"```py\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)[-1]
    found: dict[str, Any] = {}
    exec(block, found)
    return found


def test_the_example_swings_the_pendulum_up() -> None:
    found = example()
    assert found["ended"]
    assert np.cos(found["seen"][0]) < -0.99
    assert found["env"].stepper.t < 5.0


def test_gymnasium_accepts_the_environment() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=UserWarning, module="gymnasium")
        check_env(example()["env"], skip_render_check=True)


def test_episodes_begin_at_random_and_end_with_a_message() -> None:
    from sarrus.bridges.gymnasium import MechanismEnv

    motor = sr.Torque("motor", "pin", value="u/(0.05 - t)^2")
    env = MechanismEnv(
        sr.System(arm(sr.Input("u"), motor)),
        step=0.01,
        inputs={"u": (-1.0, 1.0)},
        outputs=["pin.rate", "u"],
        reward=lambda seen, u: float(u[0]),
        start=lambda random: {"rates": {"pin": random.uniform(0.1, 1.0)}},
        samples=3,
    )
    first, _ = env.reset(seed=1)
    assert 0.1 < first[0] < 1.0
    assert env.reset(seed=1)[0] == pytest.approx(first, abs=0.0)
    seen, reward, ended, _, _ = env.step(np.array([7.0]))
    assert (seen[1], reward, ended) == (1.0, 1.0, False)
    assert [env.step(np.array([0.1]))[3] for _ in range(3)] == [False, True, True]
    *_, info = env.step(np.array([0.1]))
    assert "small" in info["message"]
