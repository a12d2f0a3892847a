"""One name of an output is the same number, or the same message, in every place that takes names."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import sarrus as sr
from sarrus import mechanisms, model
from sarrus.analyses.dynamics.events.event_output import EventOutput
from sarrus.analyses.workspace.problem.formulation import formulate
from sarrus.cli import main
from sarrus.elements import Element, Force, output
from sarrus.elements.element import Scalar, Vec3
from sarrus.functions import sqrt
from sarrus.model.primitive import Primitive
from sarrus.model.quantity import Vector
from sarrus.outputs import outputs_of
from sarrus.outputs.measure import measured
from sarrus.studies.responses import responses_of
from sarrus.studies.runs import Simulation, lookup_of


class Magnet(Force, bodies=1, derivatives="automatic"):
    """A user's force: strength / d² towards a place."""

    place: Vec3
    strength: Scalar

    @output("m")
    def distance(self, x):
        d = self.place - x.r
        return sqrt(d @ d)

    @output("m/s", vector=True)
    def approach(self, x, v):
        return -v.r

    @output("N")
    def attraction(self, x, v, t):
        return self.strength / self.distance(x) ** 2

    def Q(self, x, v, t):
        return self.attraction(x, v, t) / self.distance(x) * (self.place - x.r), None


@dataclass(frozen=True, eq=False)
class Attraction(model.Force):
    """What its user writes."""

    body: sr.Body
    place: Vector
    strength: float

    def primitives(self, poses):
        yield Primitive(Magnet, (self.body.name,), (self.place, self.strength), "magnet")


del Element.registry["Magnet"]
for _kind, _class in tuple(model.Force.kinds.items()):
    if _class is Attraction:
        del model.Force.kinds[_kind]
PLACE = (6.0, 1.0, 0.5)
COIL = "  coil: {type: rsda, bodies: [ground, crank], point: [0, 1, 1], axis: [1, 0, 0], k: 1, c: 0.1}\n"


@cache
def text() -> str:
    return mechanisms.path("slider_crank").read_text(encoding="utf-8") + COIL


@cache
def system() -> sr.System:
    """The slider-crank with a coil, and a magnet that no file knows."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "m.yaml"
        path.write_text(text())
        found = sr.load(path)
    (slider,) = (body for body in found.bodies if body.name == "slider")
    parts = {name: list(found.sections()[name]) for name in ("bodies", "joints", "forces", "drivers")}
    parts["forces"].append(Attraction("magnet", slider, PLACE, 3.0))
    return sr.System(sr.Model("slider-crank", **parts, gravity=found.gravity))


@cache
def run() -> sr.Trajectory:
    """By a method whose nodes satisfy the constraints of velocities as samples do."""
    settings = {"method": sr.Radau(rtol=1e-9, atol=1e-11), "store": "steps"}
    return sr.simulate(system(), until=0.05, t_eval=np.linspace(0, 0.05, 11), **settings)


def body(name: str) -> sr.results.BodyMotion:
    return run()[name]


def joint(name: str) -> Any:
    return run().reaction(name)


WANTED: dict[str, Callable[[], Any]] = {  # at the end, from the states and other results
    "t": lambda: run().t[-1],
    "slider.x": lambda: body("slider").position[-1, 0],
    "slider.r.x": lambda: body("slider").position[-1, 0],
    "crank.e0": lambda: body("crank").euler[-1, 0],
    "slider.velocity.x": lambda: body("slider").velocity[-1, 0],
    "slider.acceleration.x": lambda: run().a[-1, 14],
    "crank.rotation_x": lambda: 0.5 + run().joint("pin").angle[-1],
    "rod(0, 0, 0).y": lambda: body("rod").position[-1, 1],
    "pin.angle": lambda: run().joint("pin").angle[-1],
    "pin": lambda: run().joint("pin").angle[-1],
    "pin.angle.rate": lambda: run().joint("pin").rate[-1],
    "crank.angular_velocity.x": lambda: run().joint("pin").rate[-1],
    "pin.force.y": lambda: joint("pin").force[-1, 1],
    "pin.torque.z": lambda: joint("pin").torque[-1, 2],
    "pin.multiplier.2": lambda: run().lam[-1, system().rows["pin"][1]],
    "spring.length": lambda: np.linalg.norm(body("slider").position[-1]),
    "spring.rate": lambda: body("slider").velocity[-1, 0],
    "spring.tension": lambda: 10 * (body("slider").position[-1, 0] - 5) + body("slider").velocity[-1, 0],
    "spring.force.x": lambda: 10 * (5 - body("slider").position[-1, 0]) - body("slider").velocity[-1, 0],
    "coil.angle": lambda: run().joint("pin").angle[-1],
    "coil.rate": lambda: run().joint("pin").rate[-1],
    "coil.torque": lambda: run().joint("pin").angle[-1] + 0.1 * run().joint("pin").rate[-1],
    "energy.kinetic": lambda: run().kinetic_energy[-1],
    "energy.total": lambda: run().total_energy[-1],
    "magnet.distance": lambda: np.linalg.norm(body("slider").position[-1] - PLACE),
    "magnet.approach.x": lambda: -body("slider").velocity[-1, 0],
    "magnet.attraction": lambda: 3.0 / np.sum((body("slider").position[-1] - PLACE) ** 2),
    "magnet.force.z": lambda: 0.5 * 3.0 / np.linalg.norm(body("slider").position[-1] - PLACE) ** 3,
}


def of_study(name: str) -> float:
    (response,) = responses_of(f"final({name})")
    Simulation(until=0.05).check(system(), [response], ())
    return response.value(run(), run().t, lookup_of(system(), run()))


def of_plot(name: str) -> float:
    return float(run().plot(name, ax=Figure().subplots()).lines[0].get_ydata()[-1])


def of_table(name: str, folder: Path) -> float:
    run().to_csv(folder / "run.csv", name)
    *_, last = csv.reader((folder / "run.csv").read_text().splitlines())
    return float(last[-1])  # the time is a single column


def at_end(name: str) -> float:
    """What an event and an impact see; both count turns from the last state."""
    return EventOutput(system(), name)(float(run().t[-1]), run().q[-1], run().v[-1])


PLACES: dict[str, Callable[[str, Path], float]] = {
    "output": lambda name, _: float(run().output(name).values[-1]),
    "coordinate": lambda name, _: float(run().coordinate(name)[-1]),
    "response": lambda name, _: sr.sensitivity(run(), sr.Final(name), ["rod.mass"]).value,
    "study": lambda name, _: of_study(name),
    "plot": lambda name, _: of_plot(name),
    "table": of_table,
    "event": lambda name, _: at_end(name),
}
POSITIONS: dict[str, Callable[[str], Any]] = {
    "workspace": lambda name: formulate(system(), [name]),
    "impact": lambda name: EventOutput(system(), name).gradient(0.0, system().q0, system().v0),
    "rates": lambda name: sr.assemble(system(), rates={name: 0.1}),
}
FUNCTIONS = {
    name
    for name in WANTED
    if name.partition(".")[2] in ("length", "angle", "distance", "r.x", "x", "rotation_x")
}
FUNCTIONS |= {"rod(0, 0, 0).y", "pin"}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", WANTED)
@pytest.mark.parametrize("place", PLACES)
def test_a_name_is_the_same_number(name: str, place: str, tmp_path: Path) -> None:
    found = PLACES[place](name, tmp_path)
    assert found == pytest.approx(float(WANTED[name]()), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", WANTED)
@pytest.mark.parametrize("place", POSITIONS)
def test_functions_of_the_position_work_where_these_are_wanted(name: str, place: str) -> None:
    if (
        name in FUNCTIONS
        or (name == "crank.e0" and place != "workspace")
        or (name == "t" and place == "impact")
    ):
        POSITIONS[place](name)
    else:
        with pytest.raises(sr.SarrusError, match=r"depends on|no element measures|takes coordinates of"):
            POSITIONS[place](name)


@pytest.mark.parametrize(
    "name", ["spring.length", "magnet.distance", "crank.rotation_x", "rod(0.1, 0.2, 0.3).y"]
)
def test_the_gradient_of_a_function_of_the_position_is_that_along_the_motion(name: str) -> None:
    rate = run().output(name, rate=True).values[-1]
    found = measured(system(), name, "a test")
    assert found.rate(run().q[-1], run().v[-1]) == pytest.approx(rate, rel=1e-12)
    assert found.gradient(run().q[-1]) @ run().v[-1] == pytest.approx([rate], rel=1e-12)


@pytest.mark.parametrize("place", [*PLACES, *POSITIONS])
def test_an_unknown_name_is_refused_by_the_same_message(place: str, tmp_path: Path) -> None:
    message = r"slider-crank has no output 'slider\.zz'. Did you mean \"slider\.z\"\?"
    with pytest.raises(sr.SarrusError, match=message):
        PLACES[place]("slider.zz", tmp_path) if place in PLACES else POSITIONS[place]("slider.zz")


def test_the_shell_takes_the_same_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "m.yaml"
    path.write_text(text())
    begin = ["run", str(path), "--until", "0.05", "--steps", "10"]
    files = ["--csv", str(tmp_path / "run.csv"), "--figure", str(tmp_path / "run.svg")]
    names = ["rod(0, 0, 0).y", "pin.multiplier.2", "spring.tension", "coil.torque"]
    assert main([*begin, *files, "--columns", *names, "--plot", *names]) == 0
    first, *_, last = csv.reader((tmp_path / "run.csv").read_text().splitlines())
    assert first[-2:] == ["spring.tension [N]", "coil.torque [N m]"]
    assert len(last) == 1 + len(names)
    responses = ["max(pin.multiplier.2)", "final(rod(0, 0, 0).y)", "mean(coil.torque)"]
    assert (
        main(["sensitivity", str(path), "--until", "0.05", "--response", *responses, "--wrt", "rod.mass"])
        == 0
    )
    capsys.readouterr()
    for line in ([*begin, "--plot", "slider.w"], [*begin, "--columns", "slider.w"]):
        assert main(line) == 2
        assert "slider-crank has no output 'slider.w'. Did you mean" in capsys.readouterr().err


def test_every_name_that_is_listed_has_a_value_and_a_unit() -> None:
    known = {one.name: one for one in outputs_of(system())}
    assert {"magnet.distance", "magnet.approach.z", "spring.torque.y", "slider.rotation_z"} < known.keys()
    for name in known:
        found = run().output(name)
        assert np.all(np.isfinite(found.values)), name
        assert found.unit or ".multiplier." in name


@pytest.mark.slow
def test_gradients_of_a_users_output() -> None:
    """At the start, from the formula; at the end, forward and backward."""
    names = ["magnet.strength", "rod.mass", "spring.k"]
    responses = [
        sr.At("magnet.attraction", time=0.0),
        sr.Final("magnet.attraction"),
        sr.Final("magnet.approach.x"),
    ]
    back, forward = (sr.sensitivity(run(), responses, names, method=way) for way in ("adjoint", "direct"))
    start = np.sum((run()["slider"].position[0] - PLACE) ** 2)
    assert back.matrix[0] == pytest.approx([1 / start, 0, 0], rel=1e-12)
    assert np.allclose(back.matrix, forward.matrix, rtol=1e-9, atol=1e-12)
    assert abs(back.matrix[1:]).min() > 1e-9


def test_the_time_of_an_event_changes_with_the_parameters_of_its_output() -> None:
    """A mass on a spring: cos(w t) = c / (k x), w² = k / m."""
    k, m, x, c = 40.0, 2.0, 0.5, 8.0
    mass = sr.Body("mass", mass=m, inertia=(1, 1, 1), position=(x, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), mass.point(0, 0, 0), k=k, length=1.0)
    one = sr.System(sr.Model("oscillator", bodies=[mass], joints=[guide], forces=[spring]))
    event = sr.Event("spring.tension - 8", terminal=True, name="slack")
    swing = sr.simulate(one, until=1.0, events=event, method=sr.Radau(rtol=1e-9, atol=1e-11), store="steps")
    w, u = np.sqrt(k / m), c / (k * x)
    time = np.arccos(u) / w
    assert swing.events[0].t == pytest.approx(time, rel=1e-8)
    found = sr.sensitivity(swing, sr.AtEvent("t", event="slack"), ["spring.k", "mass.mass"])
    by_k = -time / (2 * k) + u / (k * w * np.sqrt(1 - u * u))
    assert found.matrix[0] == pytest.approx([by_k, time / (2 * m)], rel=1e-6)


@pytest.mark.slow
def test_a_reaction_ends_a_run() -> None:
    """A pendulum from the horizontal: the tension of its pin is 3 m g sin(angle)."""
    bob = sr.Body("bob", mass=2.0, inertia=(1e-9, 1e-9, 1e-9), position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, 1, 0))
    one = sr.System(sr.Model("pendulum", bodies=[bob], joints=[pin], gravity=(0, 0, -9.81)))
    event = sr.Event("sqrt(pin.force.x**2 + pin.force.z**2) - 40", direction=1, terminal=True)
    fall = sr.simulate(one, until=1.0, events=event, method=sr.Radau(rtol=1e-9, atol=1e-11))
    assert fall.status == "event"
    angle = abs(one.joint("pin").angle(fall.events[0].q))
    assert 3 * 2.0 * 9.81 * np.sin(angle) == pytest.approx(40, rel=1e-6)
