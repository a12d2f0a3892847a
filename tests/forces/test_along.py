"""Forces along the gradient of a formula: a cam against the torque and the force that virtual work gives."""

import numpy as np
import pytest

import sarrus as sr

NUMBERS = {"A": 0.05, "k": 400.0, "c": 2.0}
VALUE = "-k*x - c*v"
GAP = "tappet.x - 0.3 - A*(1 - cos(2*pin.angle))"


def cam(*forces: sr.Force) -> sr.Model:
    shaft, tappet = (
        sr.Body("shaft", 1.0, (0.01, 0.01, 0.02)),
        sr.Body("tappet", 0.5, (0.01,) * 3, (0.3, 0, 0)),
    )
    joints = [
        sr.Revolute("pin", sr.ground, shaft, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Translational("guide", sr.ground, tappet, point=(0.3, 0, 0), axis=(1, 0, 0)),
    ]
    return sr.Model("cam", [shaft, tappet], joints, [*forces, sr.Torque("drive", "pin", value=0.3)])


def along(**more: object) -> sr.Force:
    return sr.Force("contact", **({"along": GAP, "value": VALUE, "parameters": NUMBERS} | more))


def by_hand() -> list[sr.Force]:
    """Its force on the tappet, and its torque on the shaft."""
    gap = GAP.replace("tappet.x", "guide.displacement + 0.3")
    rate = "(guide.displacement.rate - 2*A*sin(2*pin.angle)*pin.angle.rate)"
    value = f"(-k*({gap}) - c*{rate})"
    return [
        sr.Force("contact", joint="guide", value=value, parameters=NUMBERS),
        sr.Torque("on_shaft", "pin", value=f"-2*A*sin(2*pin.angle)*{value}", parameters=NUMBERS),
    ]


def run_of(*forces: sr.Force) -> sr.Trajectory:
    return sr.simulate(
        sr.System(cam(*forces)), until=1.0, method=sr.Radau(rtol=1e-10, atol=1e-12), store="steps"
    )


def test_it_acts_on_all_bodies_of_the_formula() -> None:
    run, other = run_of(along()), run_of(*by_hand())
    for name in ("pin.angle", "guide.displacement", "pin.torque", "guide.force"):
        assert run[name] == pytest.approx(other[name], abs=1e-7)
    force, angle = run["contact.value"], run["pin.angle"]
    gap = run["tappet.x"] - 0.3 - 0.05 * (1 - np.cos(2 * angle))
    rate = run["guide.displacement.rate"] - 0.1 * np.sin(2 * angle) * run["pin.angle.rate"]
    assert force == pytest.approx(-400 * gap - 2 * rate, abs=1e-9)
    assert run["contact.power"] == pytest.approx(force * rate, abs=1e-9)
    system, at = run.system, run.system.coordinates_of("shaft")
    for t, q, v, f, theta in zip(run.t, run.q, run.v, force, angle, strict=True):
        Q = system.Q(q, v, t)
        assert Q[system.coordinates_of("tappet")][:3] == pytest.approx([f, 0, 0], abs=1e-9)
        p, n = q[at][3:], Q[at][3:]
        torque = 0.5 * (-p[3] * n[0] - p[2] * n[1] + p[1] * n[2] + p[0] * n[3])
        assert torque == pytest.approx(0.3 - 0.1 * np.sin(2 * theta) * f, abs=1e-9)
    balance = run.energy_balance()
    assert np.ptp(balance.total) < 1e-6


def test_its_derivatives() -> None:
    names = [f"contact.parameters.{name}" for name in NUMBERS]
    formula = {"A": 0.05, "k": 400.0, "c": 2.0}

    def numbers(d: dict[str, float]) -> dict[str, float]:
        return {
            f"{force}.parameters.{name}": d[name] for force in ("contact", "on_shaft") for name in NUMBERS
        }

    run, other = run_of(along()), run_of(*by_hand())
    slopes = sr.sensitivity(run, "pin.angle", names).matrix
    same = sr.sensitivity(other, "pin.angle", [*formula], design=formula, formula=numbers).matrix
    assert slopes == pytest.approx(same, rel=1e-5)
    found = sr.hessian(run, "pin.angle", names)
    wanted = sr.hessian(other, "pin.angle", [*formula], design=formula, formula=numbers)
    assert found.matrix == pytest.approx(wanted.matrix, rel=1e-5, abs=1e-9 * abs(wanted.matrix).max())


def test_functions_and_files(tmp_path: object) -> None:
    def gap(o: object) -> object:
        return o["tappet.x"] - 0.3 - 0.05 * (1 - sr.functions.cos(2 * o["pin.angle"]))

    wanted = run_of(along())["pin.angle"][-1]
    assert run_of(along(along=gap))["pin.angle"][-1] == pytest.approx(wanted, abs=1e-8)
    path = tmp_path / "cam.yaml"  # type: ignore[operator]
    cam(along()).save(path)
    assert "along: " in path.read_text()
    run = sr.simulate(sr.System(sr.load(path)), until=1.0, method=sr.Radau(rtol=1e-10, atol=1e-12))
    assert run["pin.angle"][-1] == pytest.approx(wanted, abs=1e-8)


def test_an_angle_is_loaded_by_a_torque() -> None:
    """Of a pin, as by a torque on the joint, with its revolutions."""
    both = [sr.simulate(sr.System(cam(force)), until=12.0) for force in (
        sr.Force("spring", along="pin.angle", value="-0.002*x"), sr.Torque("spring", "pin", value="-0.002*x"),
    )]  # fmt: skip
    assert both[0]["pin.angle"] == pytest.approx(both[1]["pin.angle"], abs=1e-5)
    assert both[0].output("spring.value").unit == "N m"
    assert both[0]["pin.angle"].max() > 4 * np.pi


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"along": "tappet.velocity.x"},
            "uses 'tappet.velocity.x', but a force acts along a formula of positions",
        ),
        ({"along": "tappet.x - t"}, "uses 't'"),
        ({"along": "2*A"}, "has no output"),
        ({"joint": "guide"}, "has along, and a joint or points"),
        ({"along": "tapet.x"}, "Did you mean 'tappet'"),
    ],
)
def test_what_it_refuses(more: dict[str, object], message: str) -> None:
    with pytest.raises(sr.SarrusError, match="contact") as caught:
        sr.System(cam(along(**more)))
    assert message in str(caught.value).replace('"', "'")
