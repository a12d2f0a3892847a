"""Units of derivatives: as Pint has them, in gradients, Hessians, tables, pictures and the shell."""

import json
import subprocess
import sys
from collections.abc import Callable

import pytest
from pint import UnitRegistry
from tests.sensitivity import test_curves
from tests.sensitivity.test_gradients import swung
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import numbers_of
from sarrus.outputs.output import outputs_of
from sarrus.outputs.units import product, quotient, units_of
from sarrus.studies.responses import differentiable, responses_of

PINT = UnitRegistry(cache_folder=None)
RAISED = {raised: f"**{n}" for n, raised in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")}


def of_pint(unit: str) -> object:
    """A unit in base units."""
    above, _, below = "".join(RAISED.get(one, one) for one in unit.replace("^", "**")).partition("/")
    above, below = (part.strip("()").replace(" ", "*") or "1" for part in (above, below))
    return PINT.Quantity(f"({above})/({below})").to_base_units()


@pytest.mark.parametrize(
    "build", [slider_crank, lambda: sr.System(test_curves.arm())], ids=["slider-crank", "arm"]
)
def test_units_of_derivatives_are_those_of_pint(build: Callable[[], sr.System]) -> None:
    system = build()
    names = tuple(numbers_of(system))
    outputs = {one.unit for one in outputs_of(system) if one.unit}
    parameters = {unit for unit in units_of(system, names) if unit}
    assert len(outputs) > 6
    for over in outputs:
        for below in parameters:
            assert of_pint(quotient(over, below)) == of_pint(over) / of_pint(below)
            assert of_pint(quotient(over, below, "kg m²")) == of_pint(over) / of_pint(below) / of_pint(
                "kg m²"
            )


@pytest.mark.parametrize(
    ("unit", "wanted"),
    [
        (quotient("m", "N/m"), "m²/N"),
        (quotient("m", "N/m", "N/m"), "m³/N²"),
        (quotient("J", "N/m"), "m²"),
        (quotient("J", "kg"), "J/kg"),
        (quotient("N", "m/s²"), "kg"),
        (quotient("N m", "kg"), "N m/kg"),
        (quotient("rad", "N m s/rad"), "rad²/(N m s)"),
        (quotient("1", "kg"), "1/kg"),
        (quotient("m", "m"), "1"),
        (quotient("s", "m/s²"), "s³/m"),
        (quotient("m/s", "s/m"), "m²/s²"),
        (quotient("N", "kg"), "N/kg"),
        (quotient("m", ""), ""),
        (product(("m/s", 1), ("s", 1)), "m"),
    ],
)
def test_units_are_short(unit: str, wanted: str) -> None:
    assert unit == wanted


@pytest.mark.parametrize(
    ("response", "unit"),
    [
        (sr.Final("slider.x"), "m"),
        (sr.Maximum("pin.force.z"), "N"),
        (sr.Integral("energy.kinetic"), "J s"),
        (sr.Misfit("slider.x", at=[0.1], data=[1.0]), "1"),
        (sr.Final(lambda o: o("slider.x") ** 2), ""),
        (sr.Combined(lambda x, y: x * y, ["slider.x", "pin.force.z"]), "N m"),
        (sr.Combined(lambda x, y: x + y, ["slider.x", "pin.force.z"]), ""),
        ("max(slider.x) - min(slider.x)", "m"),
        ("integral(slider.velocity.x**2)", "m²/s"),
        ("rms(pin.force.z) / spring.k", "m"),
        ("sqrt(integral(slider.x))", "m^0.5 s^0.5"),
        (sr.Final("atan(slider.velocity.x/slider.velocity.z)"), "rad"),
        (sr.Final("atan2(slider.x, 2) - abs(atan(slider.x/slider.z))"), "rad"),
        (sr.Final("2*atan(slider.x/slider.z)"), "1"),
        (sr.Combined(lambda x, y: x / y, [sr.Final("atan2(slider.x, 2)"), "slider.x"]), "rad/m"),
    ],
)
def test_units_of_responses(response: object, unit: str) -> None:
    one = differentiable(responses_of(response)[0]) if isinstance(response, str) else response
    assert one.unit(slider_crank()) == unit


def test_results_have_units() -> None:
    run, names = swung("HHT"), ["spring.k", "rod.mass", "pin.axis.y"]
    gradient = sr.sensitivity(run, ["slider.x", sr.Integral("energy.total")], names)
    assert gradient.units == ("N/m", "kg", "1")
    assert gradient.response_units == ("m", "J s")
    assert [gradient.unit(name) for name in names] == ["m²/N", "m/kg", "m"]
    assert gradient.unit("spring.k", 1) == "m² s"
    lines = gradient.table().splitlines()
    assert lines[0].endswith(" m")
    row = next(line for line in lines if "spring.k" in line)
    assert row.split()[2:] == ["N/m", f"{gradient.matrix[0, 0]:+.7g}", "m²/N", row.split()[5], "m"]
    assert gradient.plot(response=0).get_xlabel() == "change of final of slider.x [m] for 1 % more"
    hessian = sr.hessian(run, "slider.x", names[:2])
    assert hessian.unit("spring.k", "rod.mass") == "m²/(N kg)"
    assert "second derivatives of final of slider.x [m]" in hessian.summary()
    assert "spring.k [N/m]" in hessian.summary()
    assert sr.state_derivatives(run, names[:1]).units == ("N/m",)


def test_units_of_a_model_file_are_those_of_its_texts() -> None:
    system = sr.System(sr.load("examples/spatial_slider_crank.yaml"))
    assert units_of(system, ("speed", "crank", "rod_turns.x", "start.q.crank.r.x")) == ("rad/s", "m", "", "m")


@pytest.mark.slow
def test_the_shell_has_units() -> None:
    command = ["sensitivity", "examples/spatial_slider_crank.yaml", "--until", "0.01", "--json", "--response"]
    found = subprocess.run(
        [sys.executable, "-m", "sarrus", *command, "slider.x", "--wrt", "speed", "crank"],
        capture_output=True, text=True, check=True, encoding="utf-8",
    )  # fmt: skip
    answer = json.loads(found.stdout)
    assert answer["units"] == ["rad/s", "m"]
    assert answer["responses"]["slider.x"]["units"] == ["m s/rad", "1"]
