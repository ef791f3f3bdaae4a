"""A builder applied to its own result: as many names as states, each of them once."""

import numpy as np
import pytest

import pendlab as pl


def named(model):
    assert len(set(model.state_labels)) == len(model.state_labels) == model.nstates
    return model


def test_integrators_one_after_the_other(triple_design):
    """The same as both at once, names apart."""
    model = triple_design.model
    both = named(pl.add_integrator(model, [0, 1]))
    one_by_one = named(pl.add_integrator(named(pl.add_integrator(model, 0)), 1))
    np.testing.assert_array_equal(one_by_one.A, both.A)
    np.testing.assert_array_equal(one_by_one.C, both.C)
    thrice = named(pl.add_integrator(pl.add_integrator(both, [2]), [0, 1]))
    assert thrice.nstates == 6 + 5


def test_filters_twice(rig):
    """Two first-order filters in series: the state of the first drives the second."""
    plant = pl.linearize(rig)
    twice = named(pl.with_filters(named(pl.with_filters(plant, rig.filters)), rig.filters))
    w = 2 * np.pi * 3.0
    f_in, f_out = (1 / (1 + 1j * w / (2 * np.pi * np.array(hz)))
                   for hz in (rig.filters.input_hz, rig.filters.output_hz))  # fmt: skip
    expected = np.diag(f_out**2) @ pl.frequency_response(plant, w)[0] @ np.diag(f_in**2)
    np.testing.assert_allclose(pl.frequency_response(twice, w)[0], expected, rtol=1e-9)


def test_align_twice(triple):
    four = pl.Pendulum([*triple.links, triple.links[1]], [*triple.motors, triple.motors[0]])
    model = pl.sample(pl.linearize(four))
    twice = named(pl.align(named(pl.align(model, 10)), 20))
    F = np.zeros((3, 8))
    F[2, 3], F[1, 2] = 10, 20
    np.testing.assert_allclose(twice.A, model.A - model.B @ F, atol=1e-12)
    with pytest.raises(ValueError, match=r"model: aligning takes .* found 1; a rig"):
        pl.align(twice, 1)


def test_delayed_model_with_filters_and_integrators(rig):
    plant = pl.with_filters(pl.linearize(rig), rig.filters)
    named(pl.add_integrator(pl.sample(plant, 0.01, 0.002), 0))


@pytest.mark.parametrize("again", [lambda m: pl.sample(m), lambda m: pl.with_filters(m, None)])
def test_what_cannot_be_done_twice_is_a_sentence(triple_design, again):
    with pytest.raises(ValueError, match="plant: expected a continuous model, found one already"):
        again(triple_design.model)
