"""PyTorch differentiates a simulation by its own derivative."""

import numpy as np
import pytest
from tests.bridges.mechanism import problem, second_of_square_times

torch = pytest.importorskip("torch")
pytestmark = pytest.mark.needs("torch")


def test_gradcheck() -> None:
    """PyTorch's own comparison with differences."""
    from sarrus.bridges.torch import Mechanism

    x = torch.tensor(problem().x0, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(Mechanism(problem()), (x,), eps=1e-4, rtol=1e-4, atol=1e-5)


def test_gradients_of_a_loss_and_of_a_batch() -> None:
    from sarrus.bridges.torch import Mechanism

    p = problem()
    designs = torch.tensor(np.array([p.x0, p.x0 * 1.01]), dtype=torch.float64, requires_grad=True)
    found = Mechanism(p)(designs)
    assert found.shape == (2, 2)
    found.sum().backward()
    for row, x in zip(designs.grad.numpy(), designs.detach().numpy(), strict=True):
        assert np.allclose(row, p.gradient(x).matrix.sum(axis=0), rtol=1e-9)


def test_a_mechanism_is_a_layer() -> None:
    """A small network in front of it learns through it."""
    from sarrus.bridges.torch import Mechanism

    torch.manual_seed(0)
    p = problem()
    network = torch.nn.Linear(1, 3, dtype=torch.float64)
    scale = torch.tensor(p.x0)
    model = Mechanism(p)
    goal = torch.tensor(p.values(p.x0 * np.array([1.1, 0.95, 1.0])))

    def loss() -> object:
        return (
            (model(scale * (1 + 0.1 * torch.tanh(network(torch.ones(1, dtype=torch.float64))))) - goal) ** 2
        ).sum()

    optimizer = torch.optim.Adam(network.parameters(), lr=0.1)
    first = float(loss().detach())
    for _ in range(25):
        optimizer.zero_grad()
        loss().backward()
        optimizer.step()
    assert float(loss().detach()) < 0.1 * first


def test_second_derivatives() -> None:
    """Of a function of two responses, as JAX gives them; they were zero without a word."""
    from sarrus.bridges.torch import Mechanism

    p = problem()
    model, x = Mechanism(p), torch.tensor(p.x0)
    found = torch.autograd.functional.hessian(lambda at: model(at)[0] ** 2 * model(at)[1], x).numpy()
    wanted = second_of_square_times()
    assert np.allclose(found, wanted, rtol=0, atol=1e-9 * abs(wanted).max())


def test_another_number_of_values_is_refused() -> None:
    from sarrus.bridges.torch import Mechanism

    for wrong in (torch.tensor(3.0), torch.ones(2), torch.ones(3, 2)):
        with pytest.raises(ValueError, match=r"3 values are expected, for spring\.k"):
            Mechanism(problem())(wrong)
