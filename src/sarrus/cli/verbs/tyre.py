"""``sarrus tyre FILE``: the coefficients of a .tir file, its diagrams, and copies in SI units."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..answer import Answer
from ..values import figure_file, positive_in, refuse_unwritable, tyre_file

if TYPE_CHECKING:
    from ...io import TyreFile

PURPOSE = "describe a tyre of a .tir file, draw its diagrams, and convert its units"
EXAMPLES = (
    "sarrus tyre car.tir",
    "sarrus tyre car.tir --plot car.png",
    "sarrus tyre passenger_car --mirrored --output right.tir",
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file, the load, and what to write."""
    parser.add_argument(
        "file", metavar="FILE", help="a .tir file, or passenger_car, which comes with the package"
    )
    parser.add_argument(
        "--load",
        type=positive_in("N"),
        metavar="N",
        help="vertical load in N, or with a unit (the nominal load)",
    )
    parser.add_argument(
        "--mirrored", action="store_true", help="take the tyre of the other side of the vehicle"
    )
    parser.add_argument(
        "--plot", type=figure_file, metavar="FILE", help="draw the diagrams, .png, .svg or .pdf"
    )
    parser.add_argument(
        "--output", type=tyre_file, metavar="FILE", help="write the coefficients to a .tir file in SI units"
    )


def run(chosen: argparse.Namespace, answer: Answer) -> int:
    """Print what is in the file, and the usual numbers of the tyre."""
    from ...io import load_tyre
    from ...model.errors import SarrusError

    refuse_unwritable([chosen.plot, chosen.output])
    if chosen.output and chosen.output.exists() and Path(chosen.file).resolve() == chosen.output.resolve():
        raise SarrusError(f"{chosen.output}: is the file of the tyre itself. Name another one.")
    tyre = load_tyre(chosen.file)
    tyre = tyre.mirrored() if chosen.mirrored else tyre
    _warn_outside(tyre, chosen.load)
    found = _numbers(tyre, chosen.load)
    numbers = len(tyre.coefficients)
    title = f"{tyre.name}: Magic Formula, FITTYP {tyre.coefficients['FITTYP']:g}, {numbers} numbers"
    answer.show(title)
    for label, value, unit in found:
        answer.show(f"  {label:32}{value:12.6g} {unit}".rstrip())
    answer.put(name=tyre.name, message=title, coefficients=dict(tyre.coefficients))
    answer.put(numbers={label: value for label, value, _ in found})
    if chosen.plot:
        from ...views import tyre_figure

        answer.draw(tyre_figure(tyre.law(), tyre.name, chosen.load), chosen.plot)
    if chosen.output:
        tyre.save(chosen.output)
        answer.wrote(chosen.output)
    return 0


def _warn_outside(tyre: TyreFile, load: float | None) -> None:
    """Warn of a load beyond that for which the file is valid."""
    from ...model.announcement import announce

    law: Any = tyre.law()
    high = law.ranges()["load"].high
    if load is not None and load > high:
        message = f"{tyre.name}: the load {load:g} N is beyond {high:g} N, where the forces are constant"
        announce([f"{message}. Give a smaller load, or change FZMAX."])


def _numbers(tyre: TyreFile, load: float | None) -> list[tuple[str, float, str]]:
    """Label, value and unit of what describes a tyre at a load."""
    from ...elements.forces.tyres import Slip
    from ...elements.forces.tyres.rounding import at_least
    from ...model import MagicFormulaTyre

    law, shortest = cast("Any", tyre.law()), MagicFormulaTyre.shortest_relaxation
    F_z = float(law.nominal_load) if load is None else load
    slip = law.in_range(Slip(0.0, 0.0, 0.0, F_z, float(law.LONGVL)))
    x, y, w = law.longitudinal(slip), law.lateral(slip, 0.0), law.wrench(slip)
    sigma_x, sigma_y = (at_least(length, shortest) for length in law.relaxation_lengths(slip))
    return [
        ("unloaded radius", float(law.unloaded_radius), "m"),
        ("load", F_z, "N"),
        ("longitudinal slip stiffness", x.K, "N"),
        ("cornering stiffness", abs(y.K), "N/rad"),
        ("longitudinal friction", x.mu, ""),
        ("lateral friction", y.mu, ""),
        ("longitudinal relaxation length", sigma_x, "m"),
        ("lateral relaxation length", sigma_y, "m"),
        ("lateral force without slip", w.F_y + 0.0, "N"),
        ("rolling resistance moment", w.M_y + 0.0, "N m"),
    ]
