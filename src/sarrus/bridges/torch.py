"""A simulation as a PyTorch function with exact first and second derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analyses import Problem

try:
    import torch
except ImportError:
    raise ImportError("this bridge needs PyTorch. Install it with: pip install torch") from None


class _Responses(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x: Any, problem: Problem) -> Any:
        ctx.problem = problem
        ctx.save_for_backward(x)
        return _like(x, problem.values(_plain(x)))

    @staticmethod
    def backward(ctx: Any, bar: Any) -> Any:
        (x,) = ctx.saved_tensors
        return _Gradient.apply(x, bar, ctx.problem), None


class _Gradient(torch.autograd.Function):
    """The gradient of the responses' sum with weights, as a function of the design and of the weights."""

    @staticmethod
    def forward(ctx: Any, x: Any, bar: Any, problem: Problem) -> Any:
        ctx.problem = problem
        ctx.save_for_backward(x, bar)
        return _like(x, problem.vjp(_plain(x), _plain(bar)))

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, change: Any) -> Any:
        x, bar = ctx.saved_tensors
        at, along = _plain(x), _plain(change)
        by_x = ctx.problem.hvp_of_sum(at, along, _plain(bar)) if ctx.needs_input_grad[0] else None
        by_bar = ctx.problem.jvp(at, along) if ctx.needs_input_grad[1] else None
        return *(None if derivative is None else _like(x, derivative) for derivative in (by_x, by_bar)), None


class Mechanism(torch.nn.Module):
    """A layer that gives the responses (r,) of design variables (p,), differentiated by one sweep backwards.

    It can be differentiated twice, ``torch.autograd.functional.hessian``, with runs of implicit methods.

    Parameters
    ----------
    problem : the simulation
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__()
        self.problem = problem

    def forward(self, x: Any) -> Any:
        """The responses of one design (p,), or of several one after the other (..., p).

        Raises
        ------
        ValueError
            For another number of values.
        """
        if x.shape[-1:] != self.problem.x0.shape:
            raise ValueError(self.problem.expected())
        if x.ndim == 1:
            return _Responses.apply(x, self.problem)
        return torch.stack([self.forward(row) for row in x])


def _plain(x: Any) -> Any:
    return np.asarray(x.detach().cpu().numpy(), dtype=float)


def _like(x: Any, values: Any) -> Any:
    return torch.as_tensor(values, dtype=x.dtype, device=x.device)
