"""Parameters, formulas, units and named points in a model file."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import pytest

from sarrus.model import Curve, Force, Joint, Model, ModelError, load
from sarrus.model.bodies.body import Body
from sarrus.model.bodies.inertia import Inertia
from sarrus.model.expansion.blueprint import blueprint
from sarrus.model.expression import Expression
from sarrus.model.file.numbers import Numbers
from sarrus.model.file.stated import function_in
from sarrus.model.measure import In, measures, typed
from sarrus.model.quantity import Vector

CRANK = """\
name: parameters
parameters:
  l: 20 mm
  crank: {l: 2*l, density: 3 kg/m}
  turn: 30 deg
points:
  A: [0, 0, l]
  B: [0, "${A.z} + 1", 0]
bodies:
  rod:
    mass: ${crank.density}*(1 m + ${crank.l})
    inertia: [1 kg m^2, 1, 1e4 kg*cm^2]
    position: A
    orientation: {axis: [0, 0, 1], angle: turn}
  bob:
    mass: rod.mass/2
    inertia: {xx: rod.inertia.x, yy: rod.inertia.yy, zz: 1}
    position: [rod.position.z, 0, 1]
joints:
  pin: {type: revolute, bodies: [ground, rod], point: B, axis: [0, 0, 1]}
  stay: {type: distance, points: [{body: rod, global: A}, {body: bob, at: [0, 0, l]}], length: 1 m + l}
forces:
  spring:
    type: tsda
    points: [{body: ground, at: [0, 0, 3 m]}, {body: rod, at: [0, 0, 0]}]
    k: {table: [[0 mm, 1 kN/m], [1, 2 N/mm]]}
    length: ${stay.length}
    force: 10*sin(turn)
"""


@pytest.fixture
def model(tmp_path: Path) -> Model:
    return written(tmp_path, CRANK)


def written(folder: Path, text: str) -> Model:
    """Return the model of a text."""
    (folder / "m.yaml").write_text(text, encoding="utf-8")
    return load(folder / "m.yaml")


def test_parameters_have_values_in_si_units(model: Model) -> None:
    assert model.parameters == {
        "l": 0.02,
        "crank.l": 0.04,
        "crank.density": 3.0,
        "turn": pytest.approx(math.pi / 6, rel=1e-15),
    }
    assert model.formulas.free() == ("l", "crank.density", "turn")
    assert model.formulas.points == {"A": [0, 0, 0.02], "B": [0, 1.02, 0]}


def test_formulas_give_the_numbers_of_the_model(model: Model) -> None:
    rod, bob = model.bodies
    assert (rod.mass, bob.mass) == (pytest.approx(3.12), pytest.approx(1.56))
    assert rod.inertia == [1, 1, 1]
    assert bob.position == [0.02, 0, 1]
    plan = blueprint(model)
    assert plan.q[2] == 0.02
    assert plan.q[3] == pytest.approx(math.cos(math.pi / 12))
    values = {one.owner: one.values for one in plan.placed}
    assert values["stay"] == ((0, 0, 0), (0, 0, 0.02), 1.02)
    assert values["spring"][4] == 1.02
    assert values["spring"][5] == pytest.approx(5.0)


def test_the_formula_of_each_number_is_kept(model: Model) -> None:
    told = {path: str(tree) for path, tree in model.expressions.items()}
    assert told["bodies", "bob", "mass"] == "rod.mass/2"
    assert told["bodies", "rod", "position", 2] == "l"
    assert told["joints", "stay", "points", 1, "at", 2] == "l"
    assert told["forces", "spring", "force"] == "10*sin(turn)"
    assert all(isinstance(tree, Expression) for tree in model.expressions.values())


def test_formulas_can_be_evaluated_again(model: Model) -> None:
    values = model.formulas.values({"l": 0.03})
    assert model.expressions["joints", "stay", "length"].value(values) == 1.03
    assert values["crank.l"] == 0.06


def test_derivatives_go_through_all_formulas(model: Model) -> None:
    found = model.formulas.derivatives("l")
    assert found["bodies", "bob", "mass"] == 3.0
    assert found["bodies", "rod", "mass"] == 6.0
    assert found["joints", "pin", "point", 1] == 1.0
    assert ("forces", "spring", "force") not in found
    with pytest.raises(ModelError, match=r'no parameter "ll". Did you mean "l"'):
        model.formulas.derivatives("ll")


def test_derivatives_agree_with_a_changed_file(tmp_path: Path, model: Model) -> None:
    """Against central differences of whole models, for every number that depends on the length."""
    step = 1e-6
    more, less = (load(tmp_path / "m.yaml", parameters={"l": 0.02 + s}) for s in (step, -step))
    for path, rate in model.formulas.derivatives("l").items():
        values = [one.expressions[path].value(one.formulas.values()) for one in (more, less)]
        assert (values[0] - values[1]) / (2 * step) == pytest.approx(rate, rel=1e-8)


def test_parameters_can_be_given_when_a_file_is_loaded(tmp_path: Path, model: Model) -> None:
    other = load(tmp_path / "m.yaml", parameters={"l": 1.0, "crank.density": "7 kg/m", "turn": "2*l"})
    assert other.parameters["crank.l"] == 2.0
    assert other.bodies[0].mass == 21.0
    assert other.parameters["turn"] == 2.0
    with pytest.raises(ModelError, match='model: there is no parameter "lenght"'):
        load(tmp_path / "m.yaml", parameters={"lenght": 1.0})


def test_a_function_of_time_keeps_its_variable() -> None:
    from pydantic import TypeAdapter

    from sarrus.model.file.numbers import Numbers

    form = TypeAdapter(function_in("N", "s"))
    numbers = Numbers({"parameters": {"w": "2 rad/s", "a": "3 N"}})
    law = form.validate_python("a*sin(${w}*t) + 1 N", context=numbers)
    assert law.names() == ("t",)
    assert law.derivative("t").value({"t": 0.0}) == 6.0
    assert form.validate_python(4.0, context=numbers).value() == 4
    assert form.validate_python("10*sin(2*pi*t)", context=numbers).value({"t": 0.25}) == 10
    with pytest.raises(ValueError, match=r"expects N, but .* is in"):
        form.validate_python("1 m * t", context=numbers)


def test_an_unknown_name_in_a_function_is_told_its_variable() -> None:
    numbers = Numbers({"parameters": {"pace": 2.0}})
    with pytest.raises(ModelError, match=r'unknown name "x". Choose from t, pace'):
        numbers.function("sin(pace*x)", "N", "s")


def test_a_curve_may_be_a_formula() -> None:
    from pydantic import TypeAdapter

    from sarrus.model.file.fields import form_of
    from sarrus.model.file.numbers import Numbers
    from sarrus.model.laws.curve import Formula

    form = TypeAdapter(form_of(Annotated[float | Curve | Formula, In("N", over="m")]))
    numbers = Numbers({"parameters": {"k": "2 N/mm"}})
    law = form.validate_python("k*x + 1 N", context=numbers).build({})
    assert isinstance(law, Formula)
    assert law(0.5) == 1001
    assert len(law.numbers()) > 3
    assert form.validate_python("k * 1 mm", context=numbers) == 2.0
    assert form.validate_python({"table": [["0 mm", 1], [1, "2 kN"]]}, context=numbers).build({})(1) == 2000
    with pytest.raises(ValueError, match="expects N, but"):
        form.validate_python("1 kg * x", context=numbers)


# Kinds of parts with numbers in the unit of their input, or of a state
ANY_UNIT = {"input", "state_variable", "first_order_lag", "transfer_function", "state_space_block", "pid"}


def test_every_number_of_every_part_says_what_it_measures() -> None:
    numeric = [typed(form).members for form in (float, Vector, float | Curve, Inertia)]
    forces = [kind for name, kind in Force.kinds.items() if name not in ANY_UNIT]
    for kind in [Body, *Joint.kinds.values(), *forces]:
        if kind.__module__.startswith("sarrus."):
            for name, hint in kind.__annotations__.items():
                assert measures(kind)[name].unit or not _is_numeric(kind, name, numeric), (kind, name, hint)


def _is_numeric(kind: type, name: str, numeric: list[frozenset[object]]) -> bool:
    from typing import get_type_hints

    return typed(get_type_hints(kind)[name]).members in numeric


BASE = """\
name: a
parameters: {parameters}
points: {points}
bodies:
  rod:
    mass: {mass}
    inertia: [1, 1, 1]
    position: {position}
"""
DEFAULTS = {"parameters": "{l: 2, w: 2 m}", "points": "{A: [0, 0, 1]}", "mass": "1", "position": "[0, 0, 0]"}
ROD, MODEL = 'body "rod"', "model"
WRONG = [
    ("mass", "3 m", 6, ROD, 'mass expects kg, but "3 m" is in m. Give it in kg, or omit the unit'),
    ("mass", "w", 6, ROD, 'mass expects kg, but "w" is in m. Give it in kg'),
    ("mass", "2 w", 6, ROD, 'mass has the unknown unit "w"'),
    ("mass", "30 deg", 6, ROD, 'mass expects kg, but "30 deg" is in rad'),
    ("position", "[1 kg, 0, 0]", 8, ROD, 'position[0] expects m, but "1 kg" is in kg'),
    ("mass", "w + 2 kg", 6, ROD, 'mass holds a formula in which "w + 2 kg" combines m and kg'),
    ("mass", "ll*2", 6, ROD, 'mass uses the unknown name "ll". Did you mean "l"?'),
    ("mass", "rod.mas", 6, ROD, 'mass uses the unknown name "rod.mas". Choose from l, w, A.x, A.y, A.z'),
    ("mass", "A.v", 6, ROD, 'mass uses the unknown name "A.v". Did you mean "A.'),
    ("mass", "rod", 6, ROD, 'mass uses "rod", which is a mapping and no number. Name one of its numbers'),
    ("mass", "A", 6, ROD, 'mass uses "A", which is a list and no number. Name one of its numbers, as in A.x'),
    ("mass", "rod.position", 6, ROD, 'mass uses "rod.position", which is a list and no number'),
    ("mass", "rod.mass", 6, ROD, 'formulas that go in a circle, "rod.mass" needs "rod.mass". Give one of'),
    ("mass", "1/(l - 2)", 6, ROD, 'mass holds "1/(l - 2)", which divides by zero. Change its numbers'),
    ("mass", "sqrt(-l)", 6, ROD, 'mass holds "sqrt(-l)", which has no real value there. Change its'),
    ("mass", "1e300*1e300", 6, ROD, 'mass must be a finite number, but "1e300*1e300" is inf. Change its'),
    ("mass", "l +", 6, ROD, 'mass holds a formula in which a number or a name is missing. Check "l +"'),
    ("mass", "l - 3", 6, ROD, "mass must be greater than 0, but is -1.0. Give the mass in kg"),
    ("mass", "1e60 kg", 6, ROD, "mass is too large, it is 1e+60. Give the mass in kg"),
    ("mass", "A.z kg", 6, ROD, 'mass holds a formula in which "kg" is out of place. Check "A.z kg"'),
    ("position", "B", 8, ROD, 'position has the unknown point "B". Choose from A'),
    ("position", "[0, A, 0]", 8, ROD, 'position[1] uses "A", which is a list and no number'),
    ("parameters", "{a: b, b: a}", 2, 'parameter "a"', 'in a circle, "b" needs "a" needs "b". Give one of'),
    ("parameters", "{a: b, b: c, c: 1/0}", 2, 'parameter "c"', 'holds "1/0", which divides by zero. Change'),
    ("parameters", "{a: true, b: a}", 2, 'parameter "a"', "must be a number, but is true. Write it as in"),
    ("parameters", "{a: [1], b: a}", 2, 'parameter "a"', "must be a number, but is a list. Write it as in"),
    ("parameters", "{g: {a: {b: 1}}}", 2, 'parameter "g"', "a must be a number, but is a mapping. Write"),
    ("parameters", "{a: two}", 2, 'parameter "a"', 'must be a number, but is "two". Write it as in'),
    ("parameters", "{a: '2'}", 2, 'parameter "a"', 'must be a number, but is "2". Write it without quotes'),
    ("parameters", "{a: .nan}", 2, 'parameter "a"', "must be a finite number, but is nan. Check its size"),
    ("parameters", "{a-b: 1}", 2, MODEL, 'has the name "a-b", which must be letters, digits and _, starting'),
    ("parameters", "{t: 1}", 2, MODEL, 'has the name "t", which has a meaning of its own. Rename it'),
    ("parameters", "{pi: 1}", 2, MODEL, 'has the name "pi", which has a meaning of its own. Rename it'),
    ("parameters", "[1]", 2, MODEL, "parameters must be a mapping, but is a list. Give keys and values"),
    ("points", "{A: [0, 1]}", 3, 'point "A"', "must have 3 entries, but has 2. Give 3"),
    ("points", "{A: [0, 1, 2 s]}", 3, 'point "A"', '[2] expects m, but "2 s" is in s. Give it in m'),
    ("points", "{A: B, B: [0, 0, 0]}", 3, 'point "A"', 'must be a list, but is "B". Write it in brackets'),
    ("points", "{A: [0, B.x, 0], B: [A.y, 0, 0]}", 3, 'point "A"', 'a circle, "B.x" needs "A.y" needs "B.x"'),
]


@pytest.mark.parametrize(("key", "value", "line", "part", "phrase"), WRONG, ids=lambda v: str(v)[:24])
def test_what_cannot_be_meant_is_refused(
    key: str, value: str, line: int, part: str, phrase: str, tmp_path: Path
) -> None:
    with pytest.raises(ModelError) as caught:
        written(tmp_path, BASE.format(**{**DEFAULTS, key: value}))
    told = str(caught.value)
    assert told.startswith(f"{tmp_path / 'm.yaml'}:{line}: {part}: "), told
    assert phrase in told
    assert told.isprintable()
    assert "more)" not in told


def test_a_wrong_parameter_is_told_once(tmp_path: Path) -> None:
    text = BASE.format(**{**DEFAULTS, "parameters": "{l: 1/0, w: l}", "mass": "l", "position": "[l, w, 0]"})
    with pytest.raises(ModelError, match=r'parameter "l": holds "1/0", which divides by zero\. [^(]*$'):
        written(tmp_path, text)


def test_a_brace_in_a_flow_list_gets_its_own_remedy(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"Inside brackets put .* in quotes or leave it away"):
        written(tmp_path, BASE.format(**{**DEFAULTS, "position": "[0, ${l}, 0]"}))
    written(tmp_path, BASE.format(**{**DEFAULTS, "position": '[0, "${l}", l]'}))


def test_a_chain_of_many_names_is_refused_and_one_in_order_is_not(tmp_path: Path) -> None:
    names = [f"p{n}: p{n - 1}" for n in range(300, 0, -1)]
    rising = "{p0: 1, " + ", ".join(reversed(names)) + "}"
    assert written(tmp_path, BASE.format(**{**DEFAULTS, "parameters": rising})).parameters["p300"] == 1
    with pytest.raises(ModelError, match=r"needs a chain of more than 60 names. Give one of them a number"):
        written(tmp_path, BASE.format(**{**DEFAULTS, "parameters": "{" + ", ".join(names) + ", p0: 1}"}))


def test_formulas_that_double_stay_quick(tmp_path: Path) -> None:
    doubling = ", ".join(f"p{n}: p{n - 1} + p{n - 1}" for n in range(1, 150))
    model = written(tmp_path, BASE.format(**{**DEFAULTS, "parameters": "{p0: 1, " + doubling + "}"}))
    assert model.parameters["p149"] == 2.0**149
    assert model.formulas.derivatives("p0")["parameters", "p149"] == 2.0**149


PIECES = ["l", "rod", "rod.mass", "A", "true", "[1]", "{}", "null", "1/0", "2 mm", "${l}"]
PIECES += ["'", "-", ":", "sin(", "t", "<<"]


def test_no_damage_to_formulas_gives_another_exception(tmp_path: Path) -> None:
    """Replace a piece of the file at many places by words that mean something elsewhere."""
    for place in range(20, len(CRANK), 9):
        piece, length = PIECES[place % len(PIECES)], place % 5
        with suppress(ModelError):
            written(tmp_path, CRANK[:place] + piece + CRANK[place + length :])


def test_a_model_with_formulas_can_be_sent_to_another_process(model: Model) -> None:
    other = pickle.loads(pickle.dumps(model))
    assert other.formulas.derivatives("l") == model.formulas.derivatives("l")
    assert blueprint(other).q.tolist() == blueprint(model).q.tolist()


def test_json_says_the_same(tmp_path: Path) -> None:
    text = '{"name": "a", "parameters": {"l": "20 mm"}, "bodies": {"rod": {"mass": "${l} * 2 kg/m", '
    (tmp_path / "m.json").write_text(text + '"inertia": [1, 1, 1]}}}')
    assert load(tmp_path / "m.json").bodies[0].mass == 0.04


def test_pint_is_imported_only_if_a_unit_is_met(tmp_path: Path) -> None:
    (tmp_path / "plain.yaml").write_text(BASE.format(**{**DEFAULTS, "parameters": "{l: 2}", "mass": "2*l"}))
    code = "import sys, sarrus; sarrus.load(sys.argv[1]); print('pint' in sys.modules)"
    command = [sys.executable, "-c", code, str(tmp_path / "plain.yaml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip() == "False"


def test_a_time_read_as_a_tonne_is_told(tmp_path: Path) -> None:
    file = tmp_path / "wheel.yaml"
    file.write_text(
        "name: wheel\n"
        "bodies:\n  wheel: {mass: 1, inertia: [1, 1, 1]}\n"
        "joints:\n  axle: {type: revolute, bodies: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1]}\n"
        "drivers:\n  motor: {type: angle, joint: axle, motion: 3 rad/s*t}\n"
    )
    with pytest.raises(ModelError, match=r't after "3 rad/s" is read as a tonne. Write "3 rad/s \* t"'):
        load(file)
