"""The example that imports a robot runs as it stands."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def test_the_arm_falls(capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLES / "falling_arm.py"))
    motion = example["main"](example["PANDA"], "panda_finger_joint1")
    assert motion.success
    assert motion["panda_link4"].position[-1, 2] < motion["panda_link4"].position[0, 2] - 0.05
    assert "7 joints" in capsys.readouterr().out
