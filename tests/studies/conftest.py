"""The slider-crank."""

import pytest

from sarrus import mechanisms
from sarrus.model import Model, load


@pytest.fixture(scope="module")
def model() -> Model:
    return load(mechanisms.path("slider_crank"))
