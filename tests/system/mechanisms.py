"""The two shipped mechanisms as systems, made once for all tests."""

from functools import cache

import sarrus as sr
from sarrus import mechanisms


@cache
def slider_crank() -> sr.System:
    return sr.System(sr.load(mechanisms.path("slider_crank")))


@cache
def hmmwv() -> sr.System:
    return sr.System(sr.load(mechanisms.path("hmmwv")))
