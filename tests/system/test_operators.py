"""Calling conventions of the operators: shapes, memory, other numbers, trouble."""

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

from sarrus.elements import OPERATORS
from sarrus.system.check import random_state


def operands(name: str) -> dict[str, object]:
    state = random_state(slider_crank(), None, seed=3)
    return {key: state[key] for key in ("q", *OPERATORS[name].operands)}


@pytest.mark.parametrize("name", OPERATORS)
def test_out_is_reused_and_holds_the_same(name: str) -> None:
    evaluate = getattr(slider_crank(), name)
    fresh = evaluate(**operands(name))
    again = evaluate(**operands(name))
    data = again if OPERATORS[name].is_vector else again.data
    data[:] = 17.0
    assert evaluate(**operands(name), out=again) is again
    assert np.array_equal(data, fresh if OPERATORS[name].is_vector else fresh.data)


@pytest.mark.parametrize("name", OPERATORS)
def test_pattern_does_not_depend_on_the_state(name: str) -> None:
    if OPERATORS[name].is_vector:
        return
    system = slider_crank()
    rest = {key: 0.0 if key == "t" else np.zeros_like(value) for key, value in operands(name).items()}
    first, second = getattr(system, name)(**rest), getattr(system, name)(**operands(name))
    assert np.array_equal(first.indptr, second.indptr)
    assert np.array_equal(first.indices, second.indices)


@pytest.mark.parametrize("name", [n for n in OPERATORS if not OPERATORS[n].is_vector])
def test_pattern_is_sorted_and_without_duplicates(name: str) -> None:
    matrix = getattr(slider_crank(), name)(**operands(name))
    assert matrix.has_canonical_format


def test_another_operators_matrix_is_refused_as_out() -> None:
    system = slider_crank()
    other = system.M(system.q0)
    with pytest.raises(ValueError, match="`out` must be a matrix returned by an earlier call of Phi_q"):
        system.Phi_q(system.q0, out=other)
    with pytest.raises(ValueError, match="`out` must be a float array"):
        system.Phi(system.q0, out=other)


def test_wrong_shape_is_refused() -> None:
    system = slider_crank()
    with pytest.raises(ValueError, match=r"q must have shape \(21,\), got \(7,\)"):
        system.Phi(np.zeros(7))
    with pytest.raises(ValueError, match=r"lam must have shape \(20,\)"):
        system.Phi_qT_lam(system.q0, np.zeros(17))


def test_other_numbers_change_the_result() -> None:
    system = slider_crank()
    b = system.b.copy()
    b[system.parameter_names.index("spring[tsda].k")] *= 3
    v = np.zeros(system.nq)
    change = system.Q(system.q0, v, b=b) - system.Q(system.q0, v)
    expected = system.Q_b(system.q0, v) @ (b - system.b)
    assert np.allclose(change, expected, rtol=1e-12, atol=1e-12)
    assert abs(change).max() > 1


def test_contractions_agree() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=4)
    q, xi, eta, lam, a, v = (state[key] for key in ("q", "xi", "eta", "lam", "a", "v"))
    assert np.allclose(system.Phi_q(q) @ xi, system.Phi_q_xi(q, xi))
    assert np.allclose(system.Phi_q(q).T @ lam, system.Phi_qT_lam(q, lam))
    assert np.allclose(system.M(q) @ a, system.M_a(q, a))
    assert np.allclose(system.gamma(q, v), -system.Phi_q_xi_q(q, v) @ v)
    weighted = system.Phi_qT_lam_q_xi_q(q, lam, xi) @ eta
    assert np.allclose(weighted, system.Phi_q_xi_q_eta_q(q, xi, eta).T @ lam)
    assert np.isclose(system.kinetic_energy(q, v), 0.5 * v @ (system.M(q) @ v))


def test_group_equals_its_operators() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=5)
    state["xi"] = state["v"]
    group = system.group("kinematic")
    outputs = group.allocate()
    group.run(system.b, *(state[key] for key in group.operands), *outputs)
    for name, output in zip(group.names, outputs, strict=True):
        alone = getattr(system, name)(**{key: state[key] for key in ("q", *OPERATORS[name].operands)})
        assert np.allclose(output, alone.data, rtol=1e-13, atol=1e-14)


def test_results_do_not_share_the_pattern() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=6)
    before = system.Phi_q_xi_q(state["q"], state["v"]).toarray()
    system.Phi_q_xi_q(state["q"], state["v"]).eliminate_zeros()
    system.Phi_q_xi_q(state["q"], 0 * state["v"]).eliminate_zeros()
    assert np.array_equal(system.Phi_q_xi_q(state["q"], state["v"]).toarray(), before)


def test_out_must_not_be_an_operand() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=7)
    with pytest.raises(ValueError, match="must not share memory with an operand"):
        system.M_a(state["q"], state["a"], out=state["a"])


def test_out_must_have_the_operators_pattern() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=8)
    matrix = system.Phi_q(state["q"])
    with pytest.raises(ValueError, match="`out` must be a matrix"):
        system.Phi_q(state["q"], out=matrix.tocoo())
    shuffled = matrix.copy()
    shuffled.indices[:2] = shuffled.indices[1::-1]
    with pytest.raises(ValueError, match="`out` must be a matrix"):
        system.Phi_q(state["q"], out=shuffled)


def test_complex_and_other_operands_are_refused_in_words() -> None:
    system = slider_crank()
    with pytest.raises(TypeError, match=r"q must be real, got complex numbers\. Give the real part\."):
        system.Phi(system.q0 + 1e-20j)
    with pytest.raises(TypeError, match=r"q must be 21 numbers, got .rest.\. Give an array"):
        system.Phi("rest")


def test_unfit_groups_are_refused_in_words() -> None:
    system = slider_crank()
    with pytest.raises(ValueError, match=r"group: there is no operator 'Phi_qq'. Did you mean"):
        system.group("Phi_qq")
    with pytest.raises(ValueError, match=r"of the family .* Give one group for each family"):
        system.group("Phi_q", "Q")
    with pytest.raises(ValueError, match="at least one operator"):
        system.group()


def test_read_only_operands_are_taken_without_compiling_anew() -> None:
    system, state = slider_crank(), random_state(slider_crank(), None, seed=9)
    group = system.group("Phi_q")
    outputs, q = group.allocate(), state["q"].copy()
    q.setflags(write=False)
    before = len(group.compiled.signatures)
    group.run(system.b, *(q if key == "q" else state[key] for key in group.operands), *outputs)
    assert np.array_equal(outputs[0], system.Phi_q(q).data)
    assert len(group.compiled.signatures) == before


def test_a_matrix_shares_the_numbers_given_and_no_pattern() -> None:
    system, size = slider_crank(), slider_crank().pattern("Phi_q").size
    numbers = np.arange(size, dtype=float)
    first, second = (system.matrix("Phi_q", numbers) for _ in range(2))
    numbers[0] = 7.0
    assert first.data[0] == 7.0
    first.indices[:] = 0
    assert not np.array_equal(first.indices, second.indices)
    assert np.array_equal(second.indices, system.pattern("Phi_q").indices)
    with pytest.raises(ValueError, match=rf"data must have shape \({size},\)"):
        system.matrix("Phi_q", numbers[:3])


def test_the_chosen_kernels_are_compiled_in_their_order() -> None:
    system, told = slider_crank(), list[str]()
    chosen = [names for names in system.compilable() if names[0] in ("M", "Phi", "Phi_q")]
    system.compile(told.append, chosen[::-1])
    assert told == [" ".join(names) for names in reversed(chosen)]
    assert len(told) > 3
