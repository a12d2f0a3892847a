"""The example that imports a robot runs as it stands."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def test_the_arm_falls(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLES / "falling_arm.py"))
    motion = example["main"](tmp_path)
    assert motion.success
    assert motion["panda_link4"].position[-1, 2] < motion["panda_link4"].position[0, 2] - 0.05
    assert {path.name for path in tmp_path.iterdir()} == {"falling_arm.png", "falling_arm-motion.png"}
    assert "7 joints" in capsys.readouterr().out
