"""Files of tyre coefficients: units, spellings, and what is wrong with them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main
from sarrus.model.tyres.magic_formula import KNOWN
from sarrus.views.figures.tyre import forces

SHIPPED = Path(sr.__file__).parent / "mechanisms" / "passenger_car.tir"
TEXT = SHIPPED.read_text()


def written(folder: Path, text: str) -> Path:
    path = folder / "car.tir"
    path.write_bytes(text.encode("latin-1"))
    return path


def replaced(key: str, value: str, text: str = TEXT) -> str:
    found, count = re.subn(rf"^{key} .*$", f"{key} = {value}", text, flags=re.MULTILINE)
    assert count == 1
    return found


def test_a_written_file_is_read_as_it_was(tmp_path: Path) -> None:
    tyre = sr.load_tyre("passenger_car")
    tyre.save(tmp_path / "copy.tir")
    copy = sr.load_tyre(tmp_path / "copy.tir")
    assert copy.coefficients == tyre.coefficients
    assert (tyre.side, copy.side, copy.mirrored().side) == ("left", "left", "right")
    assert copy.mirrored().mirrored().coefficients == tyre.coefficients


def test_every_known_number_has_a_section_of_written_files(tmp_path: Path) -> None:
    given = dict(sr.load_tyre("passenger_car").coefficients)
    every = dict.fromkeys(KNOWN, 1.25) | given
    sr.TyreFile("all", every).save(tmp_path / "all.tir")
    assert sr.load_tyre(tmp_path / "all.tir").coefficients == every


def test_units_are_those_of_the_file(tmp_path: Path) -> None:
    text = TEXT
    for key, value in {
        "LENGTH": "'mm'",
        "FORCE": "'kilonewton'",
        "ANGLE": "'degrees'",
        "PRESSURE": "'bar'",
        "UNLOADED_RADIUS": "317",
        "FNOMIN": "4.5",
        "FZMIN": "0.1",
        "FZMAX": "11",
        "LONGVL": "16700",
        "VERTICAL_STIFFNESS": "0.21",
        "VERTICAL_DAMPING": "0.00006",
        "LONGITUDINAL_STIFFNESS": "0.34",
        "LATERAL_STIFFNESS": "0.12",
        "INFLPRES": "2.2",
        "NOMPRES": "2.2",
        "ALPMIN": "-85.94366926962348",
        "ALPMAX": "85.94366926962348",
        "CAMMIN": "-11.459155902616466",
        "CAMMAX": "11.459155902616466",
    }.items():
        text = replaced(key, value, text)
    found = sr.load_tyre(written(tmp_path, text)).coefficients
    assert found == pytest.approx(sr.load_tyre("passenger_car").coefficients, rel=1e-14)


SPELLINGS = {
    "comments": TEXT.replace("= 1.62", "= 1.62   $ shape!").replace("= 0.21\n", "= 0.21 ! see $ 4\n"),
    "tabs": re.sub(r" +=", "\t=", TEXT),
    "spaces before keys": re.sub(r"^(?=[A-Z])", "   ", TEXT, flags=re.MULTILINE),
    "lower case": re.sub(r"^[A-Z]\w*", lambda key: key[0].lower(), TEXT, flags=re.MULTILINE),
    "another name of the load scale": TEXT.replace("LFZO", "LFZ0"),
    "exponents of Fortran": TEXT.replace("= 0.00004", "= 4.0D-05"),
    "latin letters": "$ Größe des Reifens\n" + TEXT,
    "windows": TEXT.replace("\n", "\r\n"),
    "the same key twice": TEXT + "[SHAPE]\n{radial width}\n 1.0 0.0\n 1.0 0.4\n",
    "quoted comments": "[MDI_HEADER]\nCOMMENTS = 'a tyre! for 10 $'\n" + TEXT,
}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_spellings_of_files(spelling: str, tmp_path: Path) -> None:
    assert SPELLINGS[spelling] != TEXT
    found = sr.load_tyre(written(tmp_path, SPELLINGS[spelling]))
    assert found.coefficients == sr.load_tyre("passenger_car").coefficients


def test_units_are_looked_up_in_their_section(tmp_path: Path) -> None:
    found = sr.load_tyre(written(tmp_path, "[MODEL]\nLENGTH = 'mm'\nTIME = 3\n" + TEXT)).coefficients
    assert found == sr.load_tyre("passenger_car").coefficients


def test_a_stiffness_of_zero_is_one_that_is_not_given(tmp_path: Path) -> None:
    tyre = sr.load_tyre(written(tmp_path, TEXT + "Q_FZ1 = 0\n"))
    law, plain = tyre.law(), sr.load_tyre("passenger_car").law()
    assert law.vertical_force(0.02, 0, 0, 1e-3) == plain.vertical_force(0.02, 0, 0, 1e-3)


def test_numbers_of_numpy_are_written_as_numbers(tmp_path: Path) -> None:
    given = {name: np.float64(value) for name, value in sr.load_tyre("passenger_car").coefficients.items()}
    sr.TyreFile("copy", given).save(tmp_path / "copy.tir")
    assert sr.load_tyre(tmp_path / "copy.tir").coefficients == given


def test_ranges_of_the_mirrored_tyre_are_exchanged() -> None:
    given = dict(sr.load_tyre("passenger_car").coefficients) | {"ALPMIN": -0.2, "ALPMAX": 0.3, "CAMMAX": 0.1}
    given.pop("CAMMIN")
    found = sr.TyreFile("", given).mirrored().coefficients
    assert (found["ALPMIN"], found["ALPMAX"], found["CAMMIN"]) == (-0.3, 0.2, -0.1)
    assert "CAMMAX" not in found


def test_the_command_warns_of_a_load_beyond_the_range_of_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tyre", "passenger_car", "--load", "1e9"]) == 0
    message = "the load 1e+09 N is beyond 11000 N, where the forces are constant. Give a smaller load"
    assert message in capsys.readouterr().err
    assert main(["tyre", "passenger_car", "--load", "4 kN"]) == 0
    assert "beyond" not in capsys.readouterr().err


def test_the_command_shows_the_relaxation_that_is_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = re.sub(r"(LATERAL_STIFF|LONGITUDINAL_STIFF|QSY).*\n", "", TEXT)
    assert main(["tyre", str(written(tmp_path, text))]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"longitudinal relaxation length +0.02 m\n +lateral relaxation length +0.02 m", shown)
    assert re.search(r"rolling resistance moment +0 N m", shown)


def test_diagrams_of_files_tyres_and_loads() -> None:
    tyre = sr.load_tyre("passenger_car")
    assert sr.views.tyre_figure(tyre).axes[0].get_legend().get_texts()[1].get_text() == "4.5 kN"
    wrong: object = 3
    with pytest.raises(sr.ModelError, match="law must be that of a tyre, but is 3"):
        sr.views.tyre_figure(wrong)
    for load in (0.0, -3.0, float("nan")):
        with pytest.raises(sr.ModelError, match="load must be a positive number"):
            sr.views.tyre_figure(tyre, load=load)
    narrow = sr.TyreFile("", dict(tyre.coefficients) | {"KPUMAX": 0.05}).law()
    points = forces(narrow, [0.2, 0.3], 0.0, 4000.0)
    assert points[0] == pytest.approx(points[1], rel=1e-4)


def test_pac2002_is_the_formula_5_2(tmp_path: Path) -> None:
    text = replaced("FITTYP", "61", TEXT).replace("FITTYP = 61", "PROPERTY_FILE_FORMAT = 'PAC2002'")
    text = replaced("Q_FZ2", "10", text.replace("INFLPRES", "IP").replace("NOMPRES", "IP_NOM"))
    text = text.replace("LMUX  ", "LCZ = 0.5\nLMUX  ")
    found = sr.load_tyre(written(tmp_path, text)).coefficients
    assert found["FITTYP"] == 6
    assert found["VERTICAL_STIFFNESS"] == 105000
    assert found["NOMPRES"] == 220000


WRONG = {
    "millimetres": (
        replaced("UNLOADED_RADIUS", "317"),
        ": UNLOADED_RADIUS is 317 m. Is the unit of the file mm? Give [UNITS] LENGTH.",
    ),
    "no loads": (replaced("FZMAX", "50"), ": FZMIN must be below FZMAX, 50 N. Correct it."),
    "another format": (
        re.sub(r"FITTYP .*", "PROPERTY_FILE_FORMAT = 'PAC89'", TEXT),
        "car.tir: PAC89 is not supported. Give a file of PAC2002, or of Magic Formula 5.2 to 6.2.",
    ),
    "no version": (
        re.sub(r"FITTYP.*\n", "", TEXT),
        "car.tir: FITTYP is missing, the version of the formulas. Add",
    ),
    "unknown version": (
        replaced("FITTYP", "70"),
        "car.tir:11: FITTYP is 70, which is not supported. Choose",
    ),
    "a word": (replaced("PDY1", "much"), 'car.tir:98: PDY1 must be a number, but is "much". Correct it.'),
    "infinite": (replaced("PDY1", "inf"), "car.tir:98: PDY1 must be a finite number"),
    "nothing": (replaced("PDY1", ""), 'car.tir:98: PDY1 must be a number, but is "". Correct it.'),
    "no radius": (re.sub(r"UNLOADED_RADIUS.*\n", "", TEXT), "the file has no UNLOADED_RADIUS. Add it."),
    "no lateral force": (re.sub(r"PKY2.*\n", "", TEXT), "the file has no PKY2. Add it."),
    "no load": (replaced("FNOMIN", "0"), ": FNOMIN must be greater than 0, but is 0. Correct it."),
    "negative friction": (
        replaced("PDX1", "-1"),
        ": PDX1 must be greater than 0, but is -1. Correct it.",
    ),
    "no shape": (replaced("PCY1", "0"), ": PCY1 must be greater than 0, but is 0. Correct it."),
    "no stiffness": (replaced("PKY1", "0"), ": PKY1 must not be 0. Correct it."),
    "an empty range": (
        replaced("ALPMAX", "-1.6"),
        "the range -1.5 to -1.6 of ALPMIN and ALPMAX, without zero",
    ),
    "no pressure": (
        replaced("NOMPRES", "0"),
        ": NOMPRES must be greater than 0, but is 0. Correct it, or",
    ),
    "negative damping": (
        replaced("VERTICAL_DAMPING", "-1"),
        "VERTICAL_DAMPING must not be negative. Correct it.",
    ),
    "a unit": (
        replaced("LENGTH", "'metres'"),
        'car.tir:4: LENGTH has the unknown unit "metres". Did you mean "metre',
    ),
    "too bent": (replaced("Q_FZ2", "60"), ": Q_FZ2 must be less than 54.71"),
    "two values": (
        replaced("PDY1", "1\nPDY1 = 2"),
        "PDY1 is 1 in line 98 and 2 in line 99. Remove one of them.",
    ),
    "no relaxation": (TEXT + "PTY1 = 1\nPTY2 = 0\n", "PTY2 must not be 0."),
    "two values in two sections": (TEXT + "[FURTHER]\nPDY1 = 2\n", "PDY1 is 1.06 in line 98 and 2 in line"),
    "no cornering stiffness": (replaced("PKY4", "0"), ": PKY4 must not be 0. Correct it."),
    "a file that is empty": ("", "car.tir: has no lines KEY = value of a text file. Give a .tir file"),
    "a binary file": (TEXT.replace("P", "\0"), "car.tir: has no lines KEY = value of a text file"),
    "no number": (replaced("PKY1", "nan"), ": PKY1 must be a finite number, but is nan"),
    "the axes of SAE": (
        replaced("PKY1", "21.5"),
        "must be negative: F_y < 0 for α > 0. Correct the signs of PKY1",
    ),
    "infinite forces": (replaced("PKX3", "-1e3"), "the file leads to forces that are not finite"),
    "infinite resistance": (replaced("QSY7", "-4"), ": QSY7 must not be negative. Correct it."),
    "a side": (
        replaced("TYRESIDE", "'MIDDLE'"),
        'TYRESIDE must be one of LEFT, RIGHT, SYMMETRIC, but is "middle". Correct it.',
    ),
    "no radius left": (replaced("UNLOADED_RADIUS", "0"), "UNLOADED_RADIUS must be greater than 0, but is 0"),
    "a negative vertical stiffness": (
        replaced("VERTICAL_STIFFNESS", "-1"),
        "VERTICAL_STIFFNESS must be greater than",
    ),
    "half of combined slip": (replaced("RCY1", "0"), "has RCX1, but no RCY1, for forces in combined slip"),
    "a negative stiffness": (
        TEXT + "Q_FZ1 = -3\n",
        ": Q_FZ1 must not be negative, but is -3. Correct it",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files_are_refused(name: str, tmp_path: Path) -> None:
    text, message = WRONG[name]
    with pytest.raises(sr.ModelError) as error:
        sr.load_tyre(written(tmp_path, text))
    assert message in str(error.value)


def test_a_written_file_is_one_of_other_programs(tmp_path: Path) -> None:
    """Adams needs a header and the unit of mass; versions of the formulas are whole numbers."""
    sr.load_tyre("passenger_car").save(file := tmp_path / "copy.tir")
    lines = [re.sub(r"\s+", "", line) for line in file.read_text().splitlines()]
    assert lines[1:5] == ["[MDI_HEADER]", "FILE_TYPE='tir'", "FILE_VERSION=3.0", "FILE_FORMAT='ASCII'"]
    assert "MASS='kg'" in lines
    assert "FITTYP=61" in lines


def test_a_missing_file_is_refused() -> None:
    with pytest.raises(sr.ModelError, match=r"nowhere\.tir does not exist\. Give the path"):
        sr.load_tyre("nowhere.tir")


NOTED = {
    "a nominal load out of range": (
        replaced("FZMAX", "4000"),
        "FNOMIN, 4500 N, is not between FZMIN and FZMAX. Correct them",
    ),
    "the belt": (TEXT + "Q_FCX = 0.4\nQ_FCY = 0\n", "Q_FCX not used: the belt and further effects"),
    "no combined slip": (re.sub(r"RC[XY]1.*\n", "", TEXT), "there are no RCX1 and RCY1"),
    "a curve of the load": (
        TEXT + "[DEFLECTION_LOAD_CURVE]\n{pen fz}\n0 0\n",
        "DEFLECTION_LOAD_CURVE is not used",
    ),
    "friction that ends": (
        replaced("PDX2", "-2"),
        "the longitudinal friction has the wrong sign from 7150 N to 1.1e.04 N. Give a smaller FZMAX",
    ),
    "no relaxation": (re.sub(r"LATERAL_ST.*\n", "", TEXT), "there is no lateral relaxation length"),
    "no longitudinal relaxation": (
        re.sub(r"LONGITUDINAL_ST.*\n", "", TEXT),
        "there is no longitudinal relaxation",
    ),
}


@pytest.mark.parametrize("name", NOTED)
def test_what_is_left_out_is_said(name: str, tmp_path: Path) -> None:
    text, message = NOTED[name]
    with pytest.warns(sr.SarrusWarning, match=f"car.tir: {message}"):
        tyre = sr.load_tyre(written(tmp_path, text))
    assert re.search(message, tyre.notes[0])


def test_coefficients_in_python_are_checked() -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.3))
    given = dict(sr.load_tyre("passenger_car").coefficients)
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=given | {"PDZ1": 1.0})
    with pytest.raises(sr.ModelError, match='coefficients has the unknown name "PDZ1"'):
        sr.System(sr.Model("wheel", [body], [], [tyre]))
    plain = {name: value for name, value in given.items() if name != "FITTYP"}
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=plain)
    with pytest.raises(sr.ModelError, match="coefficients has no FITTYP, the version of the formulas"):
        sr.System(sr.Model("wheel", [body], [], [tyre]))
    wrong: object = 3.0
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=wrong)  # type: ignore[arg-type]
    with pytest.raises(sr.ModelError, match="coefficients must be a mapping"):
        sr.System(sr.Model("wheel", [body], [], [tyre]))


def test_the_command_describes_draws_and_converts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plot, copy = tmp_path / "tyre.png", tmp_path / "right.tir"
    code = main(
        ["tyre", str(SHIPPED), "--plot", str(plot), "--mirrored", "--output", str(copy), "--load", "3 kN"]
    )
    assert code == 0
    assert "cornering stiffness" in capsys.readouterr().out
    assert plot.stat().st_size > 10_000
    assert sr.load_tyre(copy).coefficients == sr.load_tyre("passenger_car").mirrored().coefficients
    before = copy.read_bytes()
    assert main(["tyre", str(copy), "--output", str(copy)]) == 2
    assert copy.read_bytes() == before
    assert "is the file of the tyre itself. Name another one." in capsys.readouterr().err
    assert main(["tyre", str(copy), "--output", str(tmp_path / "tyre.yaml")]) == 2
    assert "must end in .tir, but is" in capsys.readouterr().err
