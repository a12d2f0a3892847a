"""What ``import sarrus`` costs and offers."""

import subprocess
import sys
from importlib import import_module

import sarrus
from sarrus.cli import VERBS

HEAVY = ("numba", "scipy", "matplotlib", "numpy", "yaml", "pydantic")


def heavy_after(program: str) -> str:
    """What a program has imported of what is heavy."""
    asked = f"import sys\n{program}\nprint([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_import_is_light() -> None:
    assert heavy_after("import sarrus") == "[]"


def test_help_of_every_verb_is_light() -> None:
    program = f"""
from sarrus.cli import main
for words in ([], *([verb] for verb in {tuple(VERBS)})):
    try:
        main([*words, "--help"])
    except SystemExit:
        pass"""
    assert heavy_after(program) == "[]"


def test_what_is_heavy_is_seen() -> None:
    assert heavy_after("import numpy") == "['numpy']"


def test_every_public_name_is_there() -> None:
    for name in sarrus.__all__:
        assert getattr(sarrus, name) is not None


def public_classes() -> list[tuple[str, type]]:
    """The kinds of joints, drivers, forces and responses of the package, each with the package that lists its name."""
    from sarrus.analyses.sensitivity import Response
    from sarrus.model import Driver, Force, Joint

    parts = [kind for base in (Joint, Driver, Force) for kind in (base, *base.kinds.values())]
    responses = [
        kind for kind in Response.__subclasses__() if kind.__module__.endswith("responses.responses")
    ]
    responses = [kind for kind in responses if not kind.__subclasses__()]
    found = [*(("model", kind) for kind in parts), *(("analyses", kind) for kind in responses)]
    return [(home, kind) for home, kind in found if kind.__module__.startswith("sarrus.")]


def test_every_part_has_a_public_name() -> None:
    from sarrus.model import Force

    for home, kind in public_classes():
        place = kind.__module__.removeprefix(f"sarrus.{home}")
        line = f"from {place} import {kind.__name__} as {kind.__name__}"
        message = f"users cannot write sr.{kind.__name__}. Add to src/sarrus/{home}/__init__.py: {line}"
        public = getattr(sarrus, kind.__name__, None)
        itself = kind is Force.kinds["force"] and public is Force  # which makes objects of this kind
        assert public is kind or itself, message


def test_names_are_those_that_type_checkers_see() -> None:
    """The lines that `sarrus` reads are import statements, with which type checkers follow a name to its definition."""
    homes = {**sarrus._HOME_OF}
    assert {homes.pop(name) for name in ("Revolute", "Body", "TSDA")} == {".model"}
    assert homes["simulate"] == ".analyses"
    assert homes["System"] == ".system"
    for name, home in homes.items():
        assert name in vars(import_module(home, "sarrus")), (name, home)


def test_a_first_simulation_imports_no_more_than_it_needs() -> None:
    """Neither what compiles, nor what draws, nor the kinds of parts that the model does not have."""
    program = """
import sys
import sarrus as sr
from sarrus.model.file.forms import tagged_model
system = sr.System(sr.load("slider_crank"))
run = sr.simulate(system, sr.assemble(system), until=0.2, store="steps")
sr.sensitivity(run, sr.Final("slider.x")).table(most=3)
idle = ("numba.typed.dictimpl", "scipy.interpolate", "scipy.optimize", "sarrus.views.shows", "pint")
print([name for name in idle if name in sys.modules], tagged_model.cache_info().currsize)
"""
    for _ in range(2):  # the first process compiles what is not in the cache yet
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    modules, _, kinds = done.stdout.splitlines()[-1].rpartition(" ")
    assert modules == "[]"
    assert int(kinds) <= 15
