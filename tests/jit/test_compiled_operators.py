"""Every compiled operator of a random system with every element, against its kernels in plain NumPy."""

import numpy as np
import pytest
from tests.elements.own import OWN
from tests.jit.mixed import by_hand, mixed_system, part_of, random_state

from sarrus.elements import BUILT_IN, GROUPS, OPERATORS
from sarrus.elements.operators import ALIASES
from sarrus.model import Force, Joint

pytestmark = pytest.mark.slow

VANISHING = ("S_q_xi_q",)  # S is linear in p
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
    assert {p.kind for p in system.populations if p.count} == {*BUILT_IN, *OWN}
    grounds = {
        (p.kind, p.variant.slots.index(-1))
        for p in system.populations
        if p.count and p.kind.bodies == 2 and -1 in p.variant.slots
    }
    pairs = {kind for kind in BUILT_IN if kind.bodies == 2}
    assert {(kind, n) for kind, n in grounds if kind in BUILT_IN} == {(k, n) for k in pairs for n in (0, 1)}


def test_numbers_lie_where_they_are_named(system):
    """Two timed elements and curves: a field that holds no number shifts none."""
    assert len(system.parameter_names) == len(set(system.parameter_names)) == system.nb
    timed = [p for p in system.populations if p.count and p.kind.timed and p.kind in OWN]
    assert len({p.kind for p in timed}) == 2
    for p in timed:
        fields = [field for field, kind in p.kind.fields.items() if kind != "Time"]
        for k in range(p.count):
            place = system.parameter_names.index(f"{p.owners[k]}[{p.labels[k]}].k")
            assert system.b[place] == p.values[k][fields.index("k")]


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
