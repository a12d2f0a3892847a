"""OpenMDAO gets exact partial derivatives, and optimizes with them."""

import numpy as np
import pytest
from tests.bridges.mechanism import problem
from tests.system.mechanisms import slider_crank

import sarrus as sr

pytestmark = [
    pytest.mark.needs("openmdao"),
    pytest.mark.filterwarnings("ignore"),
]  # OpenMDAO warns of its own matters
om = pytest.importorskip("openmdao.api")


def group(p: sr.Problem) -> object:
    from sarrus.bridges.openmdao import MechanismComponent

    whole = om.Problem(reports=False)
    whole.model.add_subsystem("mechanism", MechanismComponent(problem=p), promotes=["*"])
    return whole


def test_partials() -> None:
    p, whole = problem(), group(problem())
    whole.setup()
    whole.run_model()
    assert whole.get_val("last_place")[0] == p.values(p.x0)[0]
    found = whole.compute_totals(of=["work"], wrt=["spring_k", "rod_mass"])
    assert found["work", "rod_mass"][0, 0] == pytest.approx(p.gradient(p.x0).matrix[1, 1], rel=1e-12)
    told = whole.check_partials(out_stream=None, method="fd", form="central", step=1e-4)["mechanism"]
    assert len(told) == 6
    for name, errors in told.items():
        assert np.allclose(errors["J_fwd"], errors["J_fd"], rtol=1e-4, atol=1e-6), name


def test_a_driver_finds_what_optimize_finds() -> None:
    effort = sr.Integral(lambda o: o("slider.velocity.x") ** 2, name="effort")
    settings = {"until": 1.0, "method": sr.Radau(rtol=1e-5, atol=1e-7)}
    whole = group(sr.Problem(slider_crank(), effort, ["spring.k", "spring.c"], **settings))
    bounds = {"spring.k": (5.0, 40.0), "spring.c": (0.5, 5.0)}
    whole.driver = om.ScipyOptimizeDriver(optimizer="SLSQP", tol=1e-8, disp=False)
    for name, (low, high) in bounds.items():
        whole.model.add_design_var(name.replace(".", "_"), lower=low, upper=high, ref=10)
    whole.model.add_objective("effort")
    whole.setup()
    whole.run_driver()
    found = sr.optimize(slider_crank(), effort, [*bounds], bounds=bounds, **settings)
    assert whole.get_val("effort")[0] == pytest.approx(found.value, rel=1e-4)


def test_a_design_that_cannot_be_simulated_is_an_analysis_error() -> None:
    whole = group(problem())
    whole.setup()
    whole.set_val("rod_mass", -1.0)
    with pytest.raises(om.AnalysisError, match="mass must be greater than 0"):
        whole.run_model()


def test_equal_names_are_told_apart() -> None:
    wanted = [sr.Final(lambda o: o("slider.x")), sr.Final(lambda o: o("slider.velocity.x"))]
    p = sr.Problem(slider_crank(), wanted, ["spring.k"], until=0.1)
    whole = group(p)
    whole.setup()
    whole.run_model()
    assert [whole.get_val(name)[0] for name in ("final_of_lambda", "final_of_lambda_2")] == [*p.values(p.x0)]
