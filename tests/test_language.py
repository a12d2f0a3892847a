"""The documentation and the sources have no retired phrase."""

import pytest
from tests.language import main, retired


def test_a_retired_phrase_is_found() -> None:
    assert list(retired("fine\nSingular positions of it\n")) == [
        (2, "singular positions", "singular configurations")
    ]


def test_there_is_no_retired_phrase(capsys: pytest.CaptureFixture[str]) -> None:
    assert main() == 0, capsys.readouterr().out
