"""Every numbered equation from 9 to 116 has its test, and the page that says so is up to date."""

from tests.paper.coverage import FOLLOWS, NUMBERS, PAGE, coded, find_tests, mentioned, page, status


def test_every_equation_has_a_test():
    assert sorted(set(NUMBERS) - set(find_tests())) == []


def test_the_page_is_up_to_date():
    assert PAGE.read_text(encoding="utf-8") == page(), "run python -m tests.paper.coverage"


def test_what_follows_is_not_coded():
    files = coded()
    assert [number for number in FOLLOWS if files.get(number, [])] == []
    assert status(82, files) == "coded in `elements/constraints/dot1.py`"


def test_equation_numbers_in_prose():
    assert list(mentioned("Eq. (5). Then Eqs. (29), (34)-(36) and (40), but not (7).")) == [
        5,
        29,
        34,
        35,
        36,
        40,
    ]
