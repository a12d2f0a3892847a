"""A simulation as a function of PyTorch, with its own gradient: a layer in a learning loop."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analyses import Problem

try:
    import torch
except ImportError:
    raise ImportError("this bridge needs PyTorch; install it with: pip install torch") from None


class _Responses(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x: Any, problem: Problem) -> Any:
        ctx.problem = problem
        ctx.save_for_backward(x)
        return torch.as_tensor(problem.values(_plain(x)), dtype=x.dtype, device=x.device)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, bar: Any) -> Any:
        (x,) = ctx.saved_tensors
        found = ctx.problem.vjp(_plain(x), _plain(bar))
        return torch.as_tensor(found, dtype=x.dtype, device=x.device), None


class Mechanism(torch.nn.Module):
    """A layer that gives the responses (r,) of design variables (p,), differentiated by one sweep backwards.

    Parameters
    ----------
    problem : the simulation
    """

    def __init__(self, problem: Problem) -> None:
        super().__init__()
        self.problem = problem

    def forward(self, x: Any) -> Any:
        """The responses of one design (p,), or of several one after the other (..., p)."""
        if x.ndim == 1:
            return _Responses.apply(x, self.problem)
        return torch.stack([self.forward(row) for row in x])


def _plain(x: Any) -> Any:
    return np.asarray(x.detach().cpu().numpy(), dtype=float)
