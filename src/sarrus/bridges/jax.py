"""A simulation as a JAX function with exact derivatives: ``jax.grad``, ``jacrev``, twice, ``jit``, ``vmap``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..analyses import Problem

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    raise ImportError("this bridge needs JAX. Install it with: pip install jax") from None


def jax_function(problem: Problem) -> Callable[[Any], Any]:
    """Return the function of JAX that gives the responses (r,) of design variables (p,).

    Parameters
    ----------
    problem : the simulation

    Returns
    -------
    Callable
        Its derivatives are those of the simulation, by one sweep backwards for each call; second ones are exact too, by
        ``jax.jacrev(jax.grad(...))`` (``jax.hessian`` goes forwards, which functions with a derivative of their own
        refuse). JAX computes with single precision unless ``jax_enable_x64`` is set: simulations are in double
        precision all the same, their results are rounded. Whole numbers are taken for floating ones. A design that
        cannot be simulated is an error of JAX that contains the message.

    Raises
    ------
    ValueError
        By the function, for another number of values.
    """
    count, size = len(problem.titles), len(problem.names)

    def called(function: Callable[..., Any], length: int, *args: Any) -> Any:
        """A function of the problem, outside of JAX, that gives so many numbers."""
        kind = args[0].dtype
        shape = jax.ShapeDtypeStruct((length,), kind)
        return jax.pure_callback(_cast(function, kind), shape, *args, vmap_method="sequential")

    @jax.custom_vjp
    def responses(x: Any) -> Any:
        return called(problem.values, count, x)

    @jax.custom_vjp
    def pulled(x: Any, bar: Any) -> Any:
        return called(problem.vjp, size, x, bar)

    responses.defvjp(lambda x: (responses(x), x), lambda x, bar: (pulled(x, bar),))
    pulled.defvjp(
        lambda x, bar: (pulled(x, bar), (x, bar)),
        lambda stored, adjoint: (
            called(problem.hvp_of_sum, size, stored[0], adjoint, stored[1]),
            called(problem.jvp, count, stored[0], adjoint),
        ),
    )

    def checked(x: Any) -> Any:
        values = jnp.asarray(x)
        if values.shape != (size,):
            raise ValueError(problem.expected())
        return responses(values if jnp.issubdtype(values.dtype, jnp.floating) else values.astype(float))

    return checked


def _cast(function: Callable[..., Any], kind: Any) -> Callable[..., Any]:
    """The function of plain arrays in double precision, its result of another kind."""
    return lambda *args: function(*(np.asarray(arg, dtype=float) for arg in args)).astype(kind)
