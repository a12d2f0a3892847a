"""Every compiled operator of a random system with every element, against its kernels in plain NumPy."""

import numpy as np
import pytest
from tests.jit.mixed import by_hand, mixed_system, part_of, random_state

from sarrus.elements import BUILT_IN, GROUPS, OPERATORS
from sarrus.elements.operators import ALIASES
from sarrus.model import Force, Joint

VANISHING = ("Phi_q_xi_t", "S_q_xi_q")  # in all elements time is added to what depends on q
MACHINE = 1e-13  # relative to the largest entry: sums in another order, products and sums contracted


@pytest.fixture(scope="module")
def system(own_classes):
    return mixed_system(part_of(Joint), part_of(Force))


@pytest.fixture(scope="module")
def state(system):
    return random_state(system)


def dense(value):
    return value if isinstance(value, np.ndarray) else value.toarray()


def test_every_element_takes_part(system):
    assert {p.kind for p in system.populations if p.count} == set(BUILT_IN)
    grounds = {
        (p.kind, p.variant.slots.index(-1))
        for p in system.populations
        if p.count and p.kind.bodies == 2 and -1 in p.variant.slots
    }
    assert grounds == {(kind, n) for kind in BUILT_IN if kind.bodies == 2 for n in (0, 1)}


@pytest.mark.parametrize("name", OPERATORS)
def test_operator(system, state, name):
    operator = OPERATORS[name]
    found = getattr(system, name)(**{key: state[key] for key in ("q", *operator.operands)})
    expected = by_hand(system, operator, state)
    assert np.any(expected) or name in VANISHING
    np.testing.assert_allclose(dense(found), expected, rtol=0, atol=MACHINE * abs(expected).max())


@pytest.mark.parametrize("group", GROUPS)
def test_group(system, state, group):
    """Operators computed together are the same as one by one."""
    together = system.group(group)
    outputs = together.allocate()
    state = {**state, **{name: state[same] for name, same in ALIASES.get(together.names, {}).items()}}
    together.run(system.b, *(state[key] for key in together.operands), *outputs)
    for name, data in zip(together.names, outputs, strict=True):
        expected = by_hand(system, OPERATORS[name], state)
        np.testing.assert_allclose(
            system.matrix(name, data).toarray(), expected, rtol=0, atol=MACHINE * abs(expected).max()
        )
