"""The check of retired words finds them in prose and in identifiers; the cleaned folders have none."""

import pytest
from tests.language import CLEAN, main, retired


@pytest.mark.parametrize(
    "text", ["as it was told", "def keep_steps():", "class KeptSteps:", "self._room = 1", "It Says"]
)
def test_retired_words_are_found(text: str) -> None:
    assert [number for number, _, _ in retired(f"# fine\n{text}\n")] == [2]


def test_words_that_contain_a_retired_word_are_not_found() -> None:
    assert list(retired("intolerant storytelling, essays, mushroom, returns, gcc -march=native")) == []


def test_cleaned_folders_have_no_retired_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(list(CLEAN)) == 0, capsys.readouterr().out
