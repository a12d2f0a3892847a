"""The two shipped mechanisms as systems, made once for all tests."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import sarrus as sr
from sarrus import mechanisms


@cache
def slider_crank() -> sr.System:
    """Its bodies are given to be at rest, so that their velocities are parameters."""
    rest = "    velocity: [0, 0, 0]\n    angular_velocity: [0, 0, 0]\n"
    text = (
        Path(mechanisms.path("slider_crank")).read_text().replace("    mass: 1.0\n", f"    mass: 1.0\n{rest}")
    )
    with TemporaryDirectory() as folder:
        file = Path(folder) / "slider_crank.yaml"
        file.write_text(text)
        return sr.System(sr.load(file))


@cache
def hmmwv() -> sr.System:
    return sr.System(sr.load(mechanisms.path("hmmwv")))
