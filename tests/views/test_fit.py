"""A fitted simulation over its measurements."""

import numpy as np
import pytest

import sarrus as sr

T = np.linspace(0.05, 0.5, 10)


def pendulum(k: float) -> sr.System:
    """A rod on a spring."""
    rod = sr.Body.rod("rod", (0, 0, 0), (1, 0, 0), mass=2)
    pin = sr.Revolute("pin", sr.ground, rod, point=(0, 0, 0), axis=(0, 0, 1))
    spring = sr.TSDA("spring", sr.ground.point(0, 1, 0), rod.point(0, 0, 0), k=k, c=1, length=1)
    return sr.System(sr.Model("pendulum", [rod], [pin], [spring], gravity=(0, -9.81, 0)))


def test_the_fit_goes_through_its_data() -> None:
    exact = sr.simulate(pendulum(60), until=0.5, t_eval=[0, *T])
    data = exact["pin.angle"][1:] + 1e-3 * np.cos(np.arange(10))
    speed = sr.Misfit(
        lambda o: 2 * o("pin.angle.rate"), at=T, data=2 * exact["pin.angle.rate"][1:], sigma=0.01
    )
    misfits = [sr.Misfit("pin.angle", at=T, data=data, sigma=1e-3), speed]
    found = sr.fit(pendulum(50), misfits, ["spring.k"])
    assert len(found.run.t) == 1001, "the motion of the best design has the default output times"
    upper, lower = found.plot_fit()
    assert upper.get_ylabel() == "pin.angle [rad]"
    assert lower.get_xlabel() == "t [s]"
    assert len(upper.lines[-1].get_xdata()) == 1001
    (measured,) = (line for line in upper.lines if line.get_marker() == "o")
    assert np.array_equal(measured.get_ydata(), data)
    t, curve = upper.lines[-1].get_data()
    assert abs(np.interp(T, t, curve) - data).max() < 5e-3
    assert np.allclose(lower.lines[-1].get_ydata(), found.measurements[1].values)
    with pytest.raises(ValueError, match="nothing was measured"):
        sr.optimize(
            pendulum(50), "pin.angle", ["spring.k"], until=0.1, bounds=[(40, 60)], iterations=1
        ).plot_fit()
