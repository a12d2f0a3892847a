"""All methods of simulation beside SUNDIALS IDA, which shares nothing with them but the equations."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.analyses.test_simulation import rigid_velocity, table
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr

OTHERS = (sr.HHT(), sr.Radau(), sr.ODE())


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sksundae.ida", None)
    with pytest.raises(ImportError, match=r"pip install 'sarrus\[ida\]'"):
        sr.simulate(slider_crank(), until=0.1, method=sr.IDA())


@pytest.mark.slow
@pytest.mark.needs("sksundae")
def test_the_error_falls_with_the_tolerance() -> None:
    reference, errors = table("spatial_slidercrank_paper.csv"), []
    for rtol in (1e-5, 1e-7, 1e-9):
        run = sr.simulate(
            slider_crank(), until=10.0, t_eval=reference["t"], method=sr.IDA(rtol=rtol, atol=rtol)
        )
        assert run.success, run.message
        errors.append(abs(run["slider"].position[:, 0] - reference["x_slider"]).max())
    # The order and the steps that IDA takes depend on rounding: where one machine gains 20 another gains 8.
    assert errors[0] > 10 * errors[1]
    assert errors[1] > 2 * errors[2]
    assert errors[2] < 3e-6
    assert run.violation.max() < 1e-12


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.needs("sksundae")
def test_slider_crank(method: object) -> None:
    settings = {"until": 2.0, "t_eval": np.linspace(0, 2, 21)}
    one, other = (
        sr.simulate(slider_crank(), method=replace(m, rtol=1e-8, atol=1e-8), **settings)
        for m in (method, sr.IDA())
    )
    assert np.allclose(one.q, other.q, rtol=0, atol=1e-4 if isinstance(method, sr.HHT) else 2e-6)
    share = 1e-4 if isinstance(method, sr.HHT) else 2e-6
    assert np.allclose(one.lam, other.lam, rtol=0, atol=share * abs(other.lam).max())


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.needs("sksundae")
def test_hmmwv(method: object) -> None:
    system = hmmwv()
    v = rigid_velocity(system, np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05]))
    start = sr.assemble(system, system.q0, v)
    settings = {"until": 0.5, "t_eval": np.linspace(0, 0.5, 11)}
    one, other = (
        sr.simulate(system, start, method=replace(m, rtol=1e-8, atol=1e-8), **settings)
        for m in (method, sr.IDA())
    )
    assert np.allclose(one.q, other.q, rtol=0, atol=1e-5 if isinstance(method, sr.HHT) else 1e-7)


@pytest.mark.needs("sksundae")
def test_it_is_saved_as_it_goes_but_not_gone_on_with(tmp_path: Path) -> None:
    def stop(t: float) -> None:
        if t > 0.5:
            raise KeyboardInterrupt

    given = {"until": 1.0, "t_eval": np.linspace(0, 1, 101), "method": sr.IDA()}
    plain, folder = sr.simulate(slider_crank(), **given), tmp_path / "r"
    sr.simulate(slider_crank(), save=folder, **given)
    assert np.array_equal(np.asarray(sr.load_run(folder).q), plain.q)
    assert (
        sr.simulate(slider_crank(), save=sr.Save(folder, overwrite=True), progress=stop, **given).status
        == "stopped"
    )
    with pytest.raises(
        ValueError, match="IDA: a saved run cannot be resumed, as its past steps are inside of IDA"
    ):
        sr.resume(folder)
    assert np.array_equal(sr.repeat(folder).q, plain.q)


@pytest.mark.needs("sksundae")
def test_dependent_equations() -> None:
    door = sr.Body(
        "door", 2.0, (1, 1, 1), position=(0.5, 0, 0), velocity=(0, 0.5, 0), angular_velocity=(0, 0, 1)
    )
    hinges = [sr.Revolute(f"hinge_{n}", sr.ground, door, point=(0, 0, n), axis=(0, 0, 1)) for n in (0, 1)]
    system = sr.System(sr.Model("door", bodies=[door], joints=hinges, gravity=(0, 0, -9.81)))
    run = sr.simulate(system, until=2.0, t_eval=[1.0, 2.0], method=sr.IDA(rtol=1e-8))
    assert run.success, run.message
    assert np.allclose(run["door"].position[:, 0], 0.5 * np.cos(run.t), atol=1e-6)
