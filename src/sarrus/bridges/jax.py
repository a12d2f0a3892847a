"""A simulation as a function of JAX, with its own derivative: ``jax.grad``, ``jacrev``, ``jit``, ``vmap``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..analyses import Problem

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    raise ImportError("this bridge needs JAX; install it with: pip install jax") from None


def jax_function(problem: Problem) -> Callable[[Any], Any]:
    """Return the function of JAX that gives the responses (r,) of design variables (p,).

    Parameters
    ----------
    problem : the simulation

    Returns
    -------
    Callable
        Its derivatives are those of the simulation, by one sweep backwards for each call. JAX computes with single
        precision unless ``jax_enable_x64`` is set: simulations are in double precision all the same, their results are
        rounded.
    """
    count, size = len(problem.titles), len(problem.names)

    @jax.custom_vjp
    def responses(x: Any) -> Any:
        shape = jax.ShapeDtypeStruct((count,), x.dtype)
        return jax.pure_callback(_cast(problem.values, x.dtype), shape, x, vmap_method="sequential")

    def forward(x: Any) -> tuple[Any, Any]:
        return responses(x), x

    def backward(x: Any, bar: Any) -> tuple[Any]:
        shape = jax.ShapeDtypeStruct((size,), x.dtype)
        found = jax.pure_callback(_cast(problem.vjp, x.dtype), shape, x, bar, vmap_method="sequential")
        return (found,)

    responses.defvjp(forward, backward)
    return lambda x: responses(jnp.asarray(x))


def _cast(function: Callable[..., Any], kind: Any) -> Callable[..., Any]:
    """The function of plain arrays in double precision, its result of another kind."""
    return lambda *args: function(*(np.asarray(arg, dtype=float) for arg in args)).astype(kind)
