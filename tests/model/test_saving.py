"""A model that is saved is read back the same, to the last bit; a file whose values changed keeps all else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest
from tests.analyses import linkages
from tests.outputs import every_kind
from tests.sensitivity import cases
from tests.sensitivity.zoo import zoo
from tests.states.test_driven_by_states import DRIVERS, FILTER, STATE, crank, slider
from tests.verdicts.random_mechanisms import KINDS, mechanism
from tests.workspace import mechanisms as arms

import sarrus as sr
from sarrus import functions, mechanisms
from sarrus.model import ModelError
from sarrus.model.file.save import first_difference
from sarrus.model.written import with_numbers, written_numbers
from sarrus.system import System

ROOT = Path(__file__).parent.parent.parent
FILES = sorted([*ROOT.glob("examples/*.yaml"), *(ROOT / "src/sarrus/mechanisms").glob("*.yaml")])
PANDA = ROOT / "tests/io/data/panda.urdf"
BUILT: dict[str, Callable[[], System]] = {
    **{f"zoo {seed}": lambda seed=seed: zoo(seed) for seed in (0, 1)},  # type: ignore[misc]
    **{
        f"{kind} {seed}": lambda k=kind, s=seed: mechanism(s, k).system() for kind in KINDS for seed in (0, 1)
    },  # type: ignore[misc]
    **{make.__name__: make for make in (linkages.bennett, linkages.bricard, linkages.sarrus, linkages.door)},
    "five bar": lambda: arms.five_bar()[0],
    "delta": lambda: arms.delta()[0],
    "gough": lambda: arms.gough()[0],
    "quarter car": cases.quarter_car,
}


def bits(system: System) -> list[Any]:
    """All that the equations are made of."""
    structure = [(p.kind, p.owners, p.labels, p.bodies.tolist()) for p in system.populations]
    arrays = [system.q0, system.v0, system.b, system.joint_coordinates.b]
    names = [system.name, system.bodies, system.parameter_names, system.row_names, [*system.rows]]
    return [structure, *(array.tobytes() for array in arrays), *names, dict(system.model.rates)]


def saved(model: sr.Model, file: Path) -> sr.Model:
    """The model after it was written and read, which must be the same."""
    model.save(file)
    found = sr.load(file)
    assert bits(System(found)) == bits(System(model))
    return found


def alone(model: sr.Model) -> sr.Model:
    """A model that does not know the file that it is from, so that all of it is written."""
    return replace(model, origin=None)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("ending", ["yaml", "json"])
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_mechanism_with_its_formulas(file: Path, ending: str, tmp_path: Path) -> None:
    model = sr.load(file)
    found = saved(alone(model), tmp_path / f"all.{ending}")
    assert found.parameters == model.parameters
    texts = [{path: str(tree) for path, tree in one.expressions.items()} for one in (model, found)]
    assert texts[0] == texts[1]
    for name in model.formulas.free():
        assert found.formulas.derivatives(name) == model.formulas.derivatives(name)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("ending", ["yaml", "json"])
@pytest.mark.parametrize("name", BUILT)
def test_models_that_are_built_in_python(name: str, ending: str, tmp_path: Path) -> None:
    saved(BUILT[name]().model, tmp_path / f"built.{ending}")


def test_a_link_a_path_and_rotors(tmp_path: Path) -> None:
    path = {"x": "1 + 10 mm/s * t", "y": [[0, 0], [1, 0.5], [2, 0.5]]}
    driver = sr.PointDriver("path", BOB.point(0.1, 0, 0), **path)
    ends = sr.ground.point(0, 0, 0), CAR.point(0.2, 0, 0)
    link = sr.RevoluteRevolute("link", *ends, axis_i=(0, 0, 1), axis_j=(0, 0.6, 0.8))
    place = {"point": (0, 0, 0), "axis": (0, 0, 1)}
    rotors = [
        sr.AngleInertia("rotor", sr.ground, BOB, inertia=0.1 / 3, **place),
        sr.DisplacementInertia("nut", BOB, CAR, inertia=2, **place),
    ]
    saved(sr.Model("path", [BOB, CAR], [link], rotors, drivers=[driver]), tmp_path / "path.yaml")


def test_every_kind_of_part(tmp_path: Path) -> None:
    saved(every_kind.system().model, tmp_path / "every kind.yaml")


@pytest.mark.parametrize("options", [{}, {"base": "floating", "mimic": "free"}, {"keep_fixed": True}])
def test_an_imported_robot(options: dict[str, Any], tmp_path: Path) -> None:
    robot = sr.load_urdf(PANDA, **options)
    with pytest.warns(sr.SarrusWarning, match="limits of joints"):
        saved(robot, tmp_path / "panda.yaml")


BOB = sr.Body("bob", 1.5, {"xx": 1, "yy": 2, "zz": 2.5, "xy": -0.0}, position=(1, 0.1 + 0.2, -0.0))
CAR = replace(BOB, name="car", position=(0, 2, 0))
LAWS: list[Any] = [
    3,
    0.1 + 0.2,
    "50 N/m + 10 N/m * sin(2*x/1 m)",
    "50 kN/m",
    "-(-2 N)*x/(3 mm)^2 - (x - (1 mm - x))*2 N/m^2",
    "step(x, 0, 0, 1, 1) + abs(x - 1) + min(x, 2, 3)",
    [[0, 1], [1, 2], [2, 1]],
    np.array([[0, 1], [1, 2], [2, 1], [3, 0.1], [4, 1 / 3]]),
    sr.Curve.table([[0, 1], [1, 2 / 3]]),
    lambda x: 3 * x * x + functions.sin(x) / (1 + np.exp(x)),
    sr.Formula(lambda x: functions.maximum(x, 2) + functions.atan(x) ** 2),
    sr.parse_expression("2*x^3 - 1e-17", ["x"]),
]


@pytest.mark.parametrize("law", LAWS, ids=range(len(LAWS)))
def test_every_kind_of_law(law: Any, tmp_path: Path) -> None:
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), BOB.point(0.1, 0, 0), k=law, length=1)
    axis = {"point": (0, 0, 0), "axis": (0, 0, 1), "angle": -0.0}
    spin = sr.RSDA("spin", sr.ground, BOB, k=1, c=law if "N" not in str(law) else 0.1, **axis)
    model, file = sr.Model("one", [BOB], [], [spring, spin]), tmp_path / "law.yaml"
    if not isinstance(law, FunctionType):
        saved(model, file)
        return
    model.save(file)  # read as a text, with places for its constants
    found, system = System(sr.load(file)), System(model)
    q, v = np.random.default_rng(3).normal(size=(2, system.nq))
    assert np.array_equal(found.Q(q, v), system.Q(q, v))
    assert np.array_equal(found.Q_q(q, v).toarray(), system.Q_q(q, v).toarray())


@pytest.mark.parametrize("motion", ["5*sin(2*pi*t)", "t", 0.3, [[0, 0], [1, 2]], lambda t: t * t / 3])
def test_every_kind_of_motion_and_load(motion: Any, tmp_path: Path) -> None:
    pin = sr.Revolute(
        "pin", sr.ground, BOB, frame_i=sr.ground.frame((0, 0, 0), z=(0, 0, 1)), frame_j=BOB.frame((0, 0, 0))
    )
    driver = sr.AngleDriver("motor", "pin", motion)
    forces = [
        sr.PointForce("push", BOB.global_point(0, 0, 1), (1, motion, "-2 N/s * t"), axes="body"),
        sr.Torque("turn", BOB, (1, 0, "2 N m"), factor=motion),
    ]
    saved(
        sr.Model("one", [BOB], [pin], forces, drivers=[driver], rates={"pin": 0.1}), tmp_path / "motion.json"
    )


@pytest.mark.parametrize("kind", DRIVERS)
def test_every_kind_of_driver_that_follows_a_state(kind: str, tmp_path: Path) -> None:
    saved(slider(DRIVERS[kind]), tmp_path / "driven.yaml")


FOLLOWED = {
    "a state": crank(),
    "a filter": crank(FILTER, motion="2*filter.output - 0.1"),
    "a state by a formula": crank(replace(STATE, rate="(2*t - lag)/0.2")),
    "an input": crank(sr.Input("u", 0.5), motion="u"),
}


@pytest.mark.parametrize("kind", FOLLOWED)
def test_a_motion_by_names_of_forces(kind: str, tmp_path: Path) -> None:
    saved(FOLLOWED[kind], tmp_path / "driven.yaml")


def test_a_law_that_is_the_name_of_an_input(tmp_path: Path) -> None:
    spring = sr.TSDA("spring", sr.ground.point(1, 1, 0), BOB.point(0, 0, 0), k=1, length=1, force="u")
    saved(sr.Model("one", [BOB], [], [sr.Input("u", 2.0), spring]), tmp_path / "input.yaml")


def test_a_curve_over_an_output(tmp_path: Path) -> None:
    curve = sr.Curve.table([[0, 1], [1, 3], [2, 4]])
    body = sr.Body("arm", mass=1, inertia=(1, 1, 1))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    model = sr.Model("arm", [body], [pin], [sr.Torque("motor", "pin", value=curve, over="pin.rate")])
    model.save(tmp_path / "arm.yaml")
    assert "table: [[0, 1], [1, 3], [2, 4]]" in (tmp_path / "arm.yaml").read_text()


def test_a_body_that_leaves_its_named_point(tmp_path: Path) -> None:
    """The name of a point is written only where the body still is at the point."""
    file = tmp_path / "arm.yaml"
    file.write_text("""
name: arm
parameters: {L: 500 mm}
points: {A: [L/2, 0, 0]}
bodies:
  arm: {mass: 2, inertia: [1, 1, 1], position: A}
  leg: {mass: 2, inertia: [1, 1, 1], position: A}
""")
    moved = with_numbers(sr.load(file), {"arm.position.x": 0.3})
    moved.save(tmp_path / "moved.yaml")
    assert "position: [0.3, 0, 0]" in (tmp_path / "moved.yaml").read_text()
    assert first_difference(moved, sr.load(tmp_path / "moved.yaml")) == ""
    assert sr.load(tmp_path / "moved.yaml").bodies[1].position[0] == 0.25


def test_a_text_without_its_variable_is_a_number() -> None:
    ends = sr.ground.point(0, 0, 0), BOB.point(0.1, 0, 0)
    systems = [
        System(sr.Model("one", [BOB], [], [sr.TSDA("s", *ends, k=k, length=1)])) for k in ("2 N/mm", 2000)
    ]
    assert bits(systems[0]) == bits(systems[1])


def test_orientations_shapes_and_colours(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    mesh = tmp_path / "meshes" / "rod.stl"
    mesh.write_bytes((b"solid" + b" " * 80)[:80] + bytes(4))
    shape = sr.Shape(str(mesh), 0.001, (0, 0, 1), sr.AxisAngle((0, 0, 1), 0.3), "#3b76b5")
    turns: list[Any] = [
        sr.AxisAngle((1, 1, 0), 0.1),
        sr.EulerAngles((0.1, 0.2, 0.3), "zxz"),
        np.eye(3),
        (0.6, 0, 0.8, 0),
    ]
    inertias: list[Any] = [(1, 1, 1), np.diag([1, 2, 2.5]), {"xx": 1, "yy": 1, "zz": 1, "xz": 0.1}, [1, 1, 1]]
    bodies = [
        sr.Body(f"b{n}", 1, inertias[n], orientation=turn, center_of_mass=(0, 0, 0), shape=shape)
        for n, turn in enumerate(turns)
    ]
    model = sr.Model("drawn", bodies)
    found = saved(model, tmp_path / "drawn.yaml")
    looks, own = found.looks(), model.looks()
    assert [(x.color, x.size, x.pose.r.tobytes(), x.pose.p.tobytes()) for x in looks] == [
        (x.color, x.size, x.pose.r.tobytes(), x.pose.p.tobytes()) for x in own
    ]
    assert [x.file.resolve() for x in looks if x.file] == [mesh.resolve()] * 4
    assert "file: meshes/rod.stl" in (tmp_path / "drawn.yaml").read_text()
    (tmp_path / "other").mkdir()
    with pytest.raises(ModelError, match=r'body "b0".*outside of the model'):
        model.save(tmp_path / "other" / "drawn.yaml")


COMMENTED = """\
# a crank ⚙, measured on Monday
parameters:
  l: 200 mm     # of the rod
  m: 2
  w: 3 rad/s
bodies:
  rod:
    inertia: [1, 1, 1]
    mass: m     # the whole
    position: ["l/2", 0, 0]
joints:
  pin: {bodies: [ground, rod], type: hinge, axis: [0, 0, 1], point: [0, 0, 0]}   # in the wall
drivers: {motor: {type: angle, joint: pin, motion: w*t + 0.1*sin(t/1 s)}}
forces:
  pull: {type: spring, k: 10 N/mm, points: [{body: ground, at: [0, 1, 0]}, {body: rod, at: [0.1, 0, 0]}], length: 1}
"""


def changed(tmp_path: Path, change: Callable[[sr.Model], sr.Model]) -> list[tuple[str, str]]:
    """The lines that differ where a changed model is saved."""
    (tmp_path / "crank.yaml").write_text(COMMENTED, encoding="utf-8")
    saved(change(sr.load(tmp_path / "crank.yaml")), tmp_path / "crank.yaml")
    new = (
        (tmp_path / "crank.yaml")
        .read_text(encoding="utf-8")
        .removeprefix("# a crank ⚙, measured on Monday\nname: crank\n")
    )
    old = COMMENTED.removeprefix("# a crank ⚙, measured on Monday\n")
    pairs = list(zip(old.splitlines(), new.splitlines(), strict=True))
    return [pair for pair in pairs if pair[0] != pair[1]]


def test_comments_and_order_stay_where_parameters_change(tmp_path: Path) -> None:
    def longer(model: sr.Model) -> sr.Model:
        return sr.load(tmp_path / "crank.yaml", parameters={"l": 0.35, "m": 1 / 3})

    assert changed(tmp_path, longer) == [
        ("  l: 200 mm     # of the rod", "  l: 350 mm     # of the rod"),
        ("  m: 2", "  m: 0.3333333333333333"),
    ]


def test_comments_stay_where_numbers_of_parts_change(tmp_path: Path) -> None:
    def softer(model: sr.Model) -> sr.Model:
        return with_numbers(model, {"pull.k": 7500.0, "rod.inertia.zz": 1.5, "motor.motion.2": 0.2})

    (inertia, motion, spring) = changed(tmp_path, softer)
    assert inertia[1] == "    inertia: [1, 1, 1.5]"
    assert "motion: w*t + 0.2*sin(t/1 s)" in motion[1]
    assert "k: 7.5 N/mm" in spring[1]


def test_nothing_but_the_name_is_new_where_nothing_changed(tmp_path: Path) -> None:
    assert changed(tmp_path, lambda model: model) == []


def test_optimized_parameters_keep_formulas(tmp_path: Path) -> None:
    from sarrus.analyses.sensitivity.parameters.parameters import Parameters

    found = changed(tmp_path, lambda model: Parameters(System(model), ["l", "w"]).model_at([0.3, 4.0]))
    assert [new for _, new in found] == ["  l: 300 mm     # of the rod", "  w: 4 rad/s"]


def test_other_parts_are_written_as_a_whole(tmp_path: Path) -> None:
    (tmp_path / "crank.yaml").write_text(COMMENTED, encoding="utf-8")
    model = sr.load(tmp_path / "crank.yaml")
    saved(replace(model, forces=()), tmp_path / "new.yaml")
    text = (tmp_path / "new.yaml").read_text()
    for part in ("mass: m", "motion: w*t + 0.1*sin(t/1 s)", "l: 200 mm"):
        assert part in text
    assert "#" not in text


def test_every_number_of_the_shipped_mechanisms_can_change(tmp_path: Path) -> None:
    for name in mechanisms.names():
        model = sr.load(name)
        new = {
            key: value * (1 - 1e-9)
            for key, value in written_numbers(model).items()
            if value and "orient" not in key
        }
        whole = with_numbers(model, new)
        saved(whole, tmp_path / f"{name}.yaml")


def test_included_files_become_one_file(tmp_path: Path) -> None:
    (tmp_path / "rod.yaml").write_text(
        COMMENTED.replace("rod:", "left-rod:").replace("rod]", "left-rod]").replace("rod,", "left-rod,")
    )
    (tmp_path / "two.yaml").write_text(
        "name: two\ninclude: [rod.yaml, {file: rod.yaml, prefix: b_, parameters: {l: 3 m}}]\n"
    )
    model = sr.load(tmp_path / "two.yaml")
    (tmp_path / "elsewhere").mkdir()
    found = saved(model, tmp_path / "elsewhere" / "two.yaml")
    assert found.parameters["b_l"] == 3
    assert saved(
        model, tmp_path / "again.yaml"
    ).origin.files  # beside the files that it includes, it includes them


def test_what_a_file_cannot_contain_is_refused_by_name(tmp_path: Path) -> None:
    ends = sr.ground.point(0, 0, 0), BOB.point(0.1, 0, 0)
    bad = sr.TSDA("magnet", *ends, k=lambda x: functions.positive(x) + x, length=1)
    with pytest.raises(ModelError, match=r'force "magnet": k is a Python function.*Give a formula as a text'):
        sr.Model("one", [BOB], [], [bad]).save(tmp_path / "x.yaml")
    curve = sr.Curve((0.0, 1.0), ((0.0, 0.0, 0.0, 1.0),))
    with pytest.raises(ModelError, match=r'force "magnet": k is a curve of cubics.*Curve.table'):
        sr.Model("one", [BOB], [], [replace(bad, k=curve)]).save(tmp_path / "x.yaml")
    model = sr.Model("one", [BOB])
    with pytest.raises(ModelError, match=r"x.txt: must end in .yaml"):
        model.save(tmp_path / "x.txt")
    with pytest.raises(ModelError, match=r"none.*cannot be written, no such file"):
        model.save(tmp_path / "none" / "x.yaml")
    with pytest.raises(ModelError, match="mass"):
        sr.Model("one", [replace(BOB, mass=-1)]).save(tmp_path / "x.yaml")
    with pytest.raises(TypeError, match="path must be the path"):
        model.save(3)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_names_that_look_like_other_values(tmp_path: Path) -> None:
    names = ["null", "true", "no", "é", "_", "a-b", "Infinity"]
    bodies = [replace(BOB, name=name) for name in names]
    saved(sr.Model('1.5 "quoted": #no, {x}', bodies), tmp_path / "names.yaml")
    saved(sr.Model("1e3", bodies), tmp_path / "names.json")


def test_a_file_stays_whole_where_the_disk_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = sr.Model("one", [BOB])
    model.save(tmp_path / "x.yaml")
    before = (tmp_path / "x.yaml").read_text()

    def full(*args: Any, **kwargs: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(ModelError, match="no space left"):
        replace(model, name="two").save(tmp_path / "x.yaml")
    assert (tmp_path / "x.yaml").read_text() == before
    assert [*tmp_path.iterdir()] == [tmp_path / "x.yaml"]
