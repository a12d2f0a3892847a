"""JAX differentiates a simulation by its own derivative."""

import numpy as np
import pytest
from tests.bridges.mechanism import problem, second_of_square_times

jax = pytest.importorskip("jax")
pytestmark = pytest.mark.needs("jax")
jax.config.update("jax_enable_x64", True)


def test_gradients() -> None:
    from sarrus.bridges.jax import jax_function

    p = problem()
    f = jax_function(p)
    assert np.array_equal(f(p.x0), p.values(p.x0))
    found = jax.grad(lambda x: f(x)[0] ** 2 + f(x)[1])(jax.numpy.asarray(p.x0))
    values, matrix = p.values(p.x0), p.gradient(p.x0).matrix
    assert np.allclose(found, 2 * values[0] * matrix[0] + matrix[1], rtol=1e-9)
    assert np.allclose(jax.jacrev(f)(jax.numpy.asarray(p.x0)), matrix, rtol=1e-9)


def test_second_derivatives() -> None:
    """Of a function of two responses: their Hessians, and what their gradients make of its own."""
    from sarrus.bridges.jax import jax_function

    p = problem()
    f = jax_function(p)
    found = jax.jacrev(jax.grad(lambda x: f(x)[0] ** 2 * f(x)[1]))(jax.numpy.asarray(p.x0))
    wanted = second_of_square_times()
    assert np.allclose(found, wanted, rtol=0, atol=1e-9 * abs(wanted).max())


def test_differences_agree() -> None:
    from jax.test_util import check_grads

    from sarrus.bridges.jax import jax_function

    check_grads(
        jax_function(problem()), (problem().x0,), order=1, modes=["rev"], eps=1e-4, rtol=1e-4, atol=1e-5
    )


def test_compiled_and_mapped() -> None:
    from sarrus.bridges.jax import jax_function

    p = problem()
    f = jax_function(p)
    designs = np.array([p.x0, p.x0 * 1.01])
    wanted = np.array([p.values(x) for x in designs])
    assert np.allclose(jax.vmap(f)(designs), wanted, rtol=1e-12)
    slope = jax.jit(jax.grad(lambda x: f(x)[0]))(p.x0)
    assert np.allclose(slope, p.gradient(p.x0).matrix[0], rtol=1e-9)


def test_a_step_of_learning() -> None:
    """The stiffness for a wanted place is learned by plain descent."""
    from sarrus.bridges.jax import jax_function

    p = problem()
    f, goal = jax_function(p), p.values(p.x0 * np.array([1.1, 1.0, 1.0]))[0]
    loss = jax.value_and_grad(lambda k: (f(jax.numpy.asarray(p.x0).at[0].set(k))[0] - goal) ** 2)
    k, before = 10.0, loss(10.0)[0]
    slope = p.gradient(p.x0).matrix[0, 0]
    for _ in range(3):
        k = k - loss(k)[1] / (2 * slope**2)
    assert loss(k)[0] < 1e-4 * before
    assert k == pytest.approx(11.0, rel=1e-3)


def test_whole_numbers_and_other_numbers_of_values() -> None:
    from sarrus.bridges.jax import jax_function

    p = problem()
    f = jax_function(p)
    assert np.array_equal(f(jax.numpy.array([10, 1, 1])), p.values([10.0, 1.0, 1.0]))
    for wrong in (3.0, np.ones(2), np.ones((2, 3))):
        with pytest.raises(ValueError, match=r"3 values are expected, for spring\.k"):
            f(wrong)
