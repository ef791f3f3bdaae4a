"""Every widget: all controls to their ends, captions that equal the design's own numbers."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import pendlab as pl
from pendlab.figures import frequency, outcomes, pages
from pendlab.figures.response import controller_gains, step_response, step_words
from pendlab.figures.sampling import lag
from pendlab.figures.traces import frame
from pendlab.widgets import bench_panels as bench
from pendlab.widgets import design_panels as designs
from pendlab.widgets import model_panels as models

MAKERS = {
    "kp": pl.kp_panel,
    "weights double": lambda: pl.weights_panel("double"),
    "weights triple": lambda: pl.weights_panel("triple"),
    "observer double": lambda: pl.observer_panel("double"),
    "observer triple": lambda: pl.observer_panel("triple"),
    "triple": pl.triple_panel,
    "bench double": lambda: pl.bench_panel("double"),
    "bench triple": lambda: pl.bench_panel("triple"),
    "bar": lambda: pl.bar_panel("double"),
    "sampling": pl.sampling_panel,
}
# Ends at which no controller exists: the reason that the caption gives, and how many ends.
IMPOSSIBLE = {
    "weights double": ("integrator needs a weight", 1),
    "weights triple": ("integrator needs a weight", 1),
    "observer double": ("inside the unit circle", 1),
    "observer triple": ("inside the unit circle", 2),
    "triple": ("", 3),
    "bench double": ("", 2),
    "bench triple": ("", 3),
}


@pytest.fixture(scope="module")
def panels():
    """Panels by name, each made once."""
    make = cache(lambda name: MAKERS[name]())
    made = []
    yield lambda name: made.append(make(name)) or made[-1]
    for panel in made:
        panel.close()


@pytest.fixture
def panel(panels):
    """A panel by name, as it starts."""

    def fresh(name):
        panel = panels(name)
        panel.at(**panel.presets["Reset"])
        return panel

    return fresh


def stops(control):
    """The ends of a control."""
    if isinstance(control, pl.Slider):
        return [*[0.0] * control.zero, control.low, control.high]
    return [not control.value] if isinstance(control, pl.Switch) else control.stops


@pytest.mark.parametrize("name", MAKERS)
def test_ends_of_all_controls(panel, name):
    p = panel(name)
    start, values, captions = (p.caption, p.picture), p.values, []
    for control in p.controls.values():
        for stop in stops(control):
            captions.append(p.at(**{**values, control.name: stop}))
            assert p.values == {**values, control.name: stop}
    p.at(**values)
    assert p.values == values
    reason, count = IMPOSSIBLE.get(name, ("", 0))
    bad = [caption for caption in captions if "cannot work" in caption]
    assert len(bad) == count and all(reason in caption for caption in bad)
    assert len(captions) >= len(p.controls)
    assert "nan" not in "".join(captions)
    assert (p.caption, p.picture) == start


@pytest.mark.parametrize("name", MAKERS)
def test_presets_are_within_the_controls(panel, name):
    p = panel(name)
    for preset, values in p.presets.items():
        p.at(**values)
        assert {k: p.values[k] for k in values} == values, preset


@pytest.mark.parametrize("name", MAKERS)
def test_labels_carry_units_and_widths_fit(panel, name):
    for control in panel(name).controls.values():
        if isinstance(control, pl.Slider):
            units = (",", "E", "beta", "times")
            assert any(unit in control.label for unit in units), control.label
        assert len(control.label) <= 29


@pytest.mark.parametrize("name", MAKERS)
def test_picture_fits_a_lab_pc(panel, name):
    width, height = panel(name).view.figure.bbox.size
    assert width <= 920 and height <= 460


def said(curves):
    return [outcomes.margins_in_words(curve) for curve in curves]


def both(design, index=0):
    """The words about one loop, from loops computed here."""
    loops = (design.loop(index, filters) for filters in (False, True))
    return said([frequency.nyquist(loop, pages.POINTS) for loop in loops])


@pytest.mark.parametrize("k_p", [0.0, 0.5, 2.0, 60.0, 90.0])
def test_kp_caption_holds_for_its_value(panel, triple_design, k_p):
    words = panel("kp").at(k_p=k_p)
    design = replace(triple_design, kp=k_p)
    eigenvalues = np.linalg.eigvals(pl.align(design.model, k_p).A)
    assert f"leaves {np.sum(np.abs(eigenvalues) > 1)} of 6" in words
    low, high = pl.alignment_interval(design.model)
    assert f"{low:.2f} < k_p < {high:.2f}" in words
    assert all(part in words for part in both(design, 1))
    assert outcomes.gain_in_words(design.F) in words


def test_margins_in_words_are_those_of_the_loop(triple_design):
    loop = triple_design.loop(1, filters=True)
    words = outcomes.margins_in_words(frequency.nyquist(loop))
    m = pl.margins(loop)
    assert words == (
        f"stable, gain ×{m.gain_down:.2g}–{m.gain_up:.3g}, phase {np.degrees(m.phase):.1f}°, "
        f"distance {m.modulus:.3g}"
    )


def test_unstable_loop_is_called_so(double_design):
    slow = replace(double_design.rig, filters=pl.Filters((0.5,), (0.5,) * 3))
    loop = replace(double_design, rig=slow).loop(0, filters=True)
    outside = np.sum(np.abs(pl.closed_loop_eigenvalues(loop)) > 1)
    words = outcomes.margins_in_words(frequency.nyquist(loop))
    assert outside > 0 and words.startswith(f"UNSTABLE, {outside} eigenvalue")


@pytest.mark.parametrize("name", ["double", "triple"])
def test_weights_caption_holds_for_its_values(panel, name):
    words = panel(f"weights {name}").at(Q1=2.0, R=0.5)
    paper = pl.paper_design(name)
    design = replace(paper, Q=(2.0, *paper.Q[1:]), R=(0.5,))
    assert outcomes.gain_in_words(design.F) in words
    assert step_words(step_response(design)) in words
    for index in range(design.rig.n_motors):
        assert all(part in words for part in both(design, index))


@pytest.mark.parametrize("name, key", [("double", "eq23.F"), ("triple", "eq32.F")])
def test_papers_weights_give_the_printed_gain(panel, name, key):
    p = panel(f"weights {name}")
    p.at(R=100.0)
    words = p.at(**p.presets[designs.PAPER])
    ours = [float(v) for v in words[words.index("[") + 1 : words.index("]")].split(",")]
    printed = pl.published(key)
    # The caption shows four digits: half of the fourth is at most 5e-4 of the number.
    allowed = printed.half_digit + 5e-4 * np.abs(printed.values)
    assert np.all(np.abs(ours - printed.values) <= np.ravel(allowed))


@pytest.mark.parametrize("k", [1, 2])
def test_doubles_observers_are_the_printed_ones(panel, double_design, k):
    p = panel("observer double")
    preset = next(values for name, values in p.presets.items() if f"Observer {k}" in name)
    o = pl.paper_design("double", k).observer
    words = p.at(**preset)
    assert outcomes.rows_in_words(np.hstack([o.L1, o.L2])[3:]) in words
    assert all(part in words for part in both(pl.paper_design("double", k)))


def test_neither_observer_is_refused(panel):
    p = panel("observer double")
    assert "[C; T] is singular" in p.at(**p.presets["Neither"])


def test_triples_observer_is_the_printed_one(panel, triple_design):
    p = panel("observer triple")
    o = triple_design.observer
    assert outcomes.rows_in_words(np.hstack([o.L1, o.L2])[4:]) in p.caption
    made = designs.near_printed(triple_design, 0.9, 0.9)
    assert np.allclose(made.coefficients, triple_design.coefficients, atol=1e-9)


def test_equal_eigenvalues_make_the_choice_vanish(panel):
    p = panel("observer triple")
    loops = lambda words: words.split("\n")[1:]  # noqa: E731
    turned = p.at(phi1=30, phi2=-20)
    assert loops(turned) == loops(p.at(phi1=0, phi2=0)) and turned != p.caption
    apart = p.at(alpha=0.9, beta=0.5)
    assert loops(p.at(phi1=30, phi2=-20)) != loops(apart)


def test_doubles_choice_matters_with_filters_only(panel):
    p = panel("observer double")
    one, other = p.at(beta1=1, beta2=0), p.at(beta1=0, beta2=1)
    without = lambda words: words.split("; with")[0].split("without filters")[1]  # noqa: E731
    assert without(one) == without(other)
    assert one.split("; with")[1] != other.split("; with")[1]


def test_all_in_one_tells_margins_and_the_run(panel, triple_design):
    words = panel("triple").at(k_p=4.0, beta=0.8)
    design = designs.near_printed(replace(triple_design, kp=4.0), 0.9, 0.8)
    rig = design.rig
    run = pl.simulate(
        pl.bench_rig(rig),
        design.controller,
        8.0,
        initial=pl.bench_start(rig),
        imperfections=pl.bench_imperfections(rig),
    )
    assert outcomes.run_in_words(run) in words
    for index in (0, 1):
        assert all(part in words for part in both(design, index))


@pytest.mark.parametrize("name", ["double", "triple"])
def test_bench_starts_as_the_data_file_says(panel, name):
    p, rig = panel(f"bench {name}"), pl.load(name)
    case = bench.bench_case(rig, p.values)
    expected, got = pl.bench_imperfections(rig), case["imperfections"]
    n, m = rig.n_links, rig.n_motors
    for entry, count in (
        ("resolution", n + 1),
        ("voltage_resolution", m),
        ("offset", n + 1),
        ("noise", n + 1),
        ("hinge_friction", n),
        ("gear_friction", m),
        ("gap", m),
        ("contact_stiffness", m),
    ):
        assert got.each(entry, count) == pytest.approx(expected.each(entry, count), rel=5e-3), entry
    assert got.delay == pytest.approx(expected.delay)
    assert (got.filters, got.saturation) == (expected.filters, expected.saturation)
    assert case["initial"] == pytest.approx(pl.bench_start(rig)) and case["disturbance"] is None


def test_ideal_rig_has_no_imperfection(panel):
    p = panel("bench triple")
    p.at(**p.presets["Ideal rig"])
    on = bench.bench_case(pl.load("triple"), p.values)["imperfections"]
    kept = {k: getattr(on, k) for k in ("contact_stiffness", "contact_damping", "presliding")}
    assert on == pl.Imperfections(resolution=0.0, offset=0.0, noise=0.0, **kept)


def test_bench_caption_is_that_of_the_run(panel, double_design):
    p, rig = panel("bench double"), double_design.rig
    words = p.at(reference=0.1, height=0.05, at=2.0, link=1)
    case = bench.bench_case(rig, p.values)
    assert case["disturbance"] == pl.Pulse(1, 2.0, p.values["length"], 0.05)
    assert case["reference"] == 0.1
    window = p.values["window"]
    run = pl.simulate(bench.bench_plant(rig, p.values), double_design.controller, window[1], **case)
    assert words == outcomes.run_in_words(run, window[0])


def test_bench_tells_a_fall_and_moves_a_pendulum(panel):
    p = panel("bench double")
    before = p._widget.beside
    words = p.at(height=2.0, length=1.0, at=1.0)
    assert "falls at" in words and 'src="data:image/svg' in before and p._widget.beside != before
    word, good = p.view.figure.verdict
    assert word.startswith("falls at") and not good


def test_push_after_the_time_shown_is_answered(panel):
    p = panel("bench triple")
    assert p.view.figure.verdict == ("stays up", True)
    words = p.at(height=2.0, length=1.0, at=12.5)  # the window ends at 7 s
    assert "falls at 1" in words and p.view.figure.verdict[0] in words


@pytest.mark.parametrize("name", ["observer triple", "bench double", "bench triple"])
def test_what_is_called_idle_moves_nothing(panel, name):
    p = panel(name)
    if "bench" in name:
        p.at(**p.presets["Ideal rig"])
    idle = p.view.idle(p.values)
    assert len(idle) >= 2
    told = p.view.figure.table
    for control in idle:
        before = p.values[control]
        for stop in stops(p.controls[control]):
            p.at(**{control: stop})
            assert p.view.figure.table == told, control
        p.at(**{control: before})


@pytest.mark.parametrize("name", MAKERS)
def test_panels_tell_verdict_and_table_in_sight(panel, name):
    p = panel(name)
    state = p._widget.state
    assert len(p._widget.face["groups"][0]["controls"]) <= 4
    assert state["alt"] and state["words"]
    if name != "bar":
        assert state["verdict"][1] and len(state["table"]) >= 2


def test_hardest_push_is_survived_and_the_next_one_not(panel, double_design):
    p, rig = panel("bench double"), double_design.rig
    p.at(at=1.0, link=2)
    seen = []
    sentence = bench.hardest_push(
        rig, double_design.controller, p.values, lambda done, total: seen.append((done, total))
    )
    assert seen[0] == (0, 80) and seen[-1] == (80, 80)
    step = (bench.HARDEST / 0.1) ** (1 / 39)
    height = float(sentence.split("may reach +")[1].split()[0])
    fell = []
    for push in (0.97 * height, 1.05 * height * step):
        pulse = pl.Pulse(2, 1.0, p.values["length"], push)
        case = {**bench.bench_case(rig, p.values), "disturbance": pulse}
        t_end = 1.0 + p.values["length"] + 5.0
        plant = bench.bench_plant(rig, p.values)
        fell.append(pl.simulate(plant, double_design.controller, t_end, **case).fell)
    assert fell == [False, True]


def test_bar_caption_is_that_of_the_measures(panel):
    words = panel("bar").at(bar2=0.1)
    bare = pl.controllability_measures(pl.load("double"))
    barred = pl.controllability_measures(pl.with_bar(pl.load("double"), 2, 0.1))
    assert f"{np.degrees(bare.tilt):.1f} to {np.degrees(barred.tilt):.1f} degrees" in words


def test_sampling_caption_holds_for_its_values(panel, double_design):
    words = panel("sampling").at(dt=20.0, input_hz=20.0)
    cut = double_design.rig.filters.output_hz[0]
    design = models.sampled_design(double_design, 0.02, 20.0, cut)
    assert design.dt == 0.02 and design.E[0] == pytest.approx(0.81)
    values = np.linalg.eigvals(design.model.A)
    for z in values[np.abs(values) > 1].real:
        assert f"{z:.4f}" in words
    crossover = max(pl.margins(design.loop()).crossover)
    hz = crossover / (2 * np.pi)
    filters = np.degrees(np.arctan(hz / 20.0) + np.arctan(hz / cut))
    assert f"filters lag by {filters:.1f}°" in words
    assert f"hold by {np.degrees(crossover * 0.02 / 2):.1f}°" in words
    assert all(part in words for part in both(design))


def test_sampling_at_the_papers_values_is_the_papers_design(double_design):
    filters = double_design.rig.filters
    same = models.sampled_design(double_design, 0.01, filters.input_hz[0], filters.output_hz[0])
    assert np.allclose(same.observer.T, double_design.observer.T)
    assert same.rig == double_design.rig


# What the pages show


def test_step_response_is_that_of_a_simulation(design):
    """A small step: the nonlinear simulation with filters follows the linear answer."""
    response = step_response(design, decades=4)
    run = pl.simulate(
        design.rig,
        design.controller,
        1.0,
        reference=1e-4,
        imperfections=pl.Imperfections(filters=True),
    )
    samples = np.round(response.t / design.dt).astype(int)
    early = samples <= 100
    assert samples[early].tolist() == list(range(101))
    size = np.abs(response.angles[early]).max()
    assert run.angles[samples[early]] / 1e-4 == pytest.approx(
        response.angles[early], abs=1e-3 * size
    )
    assert run.u[samples[early]] / 1e-4 == pytest.approx(
        response.u[early], abs=1e-3 * np.abs(response.u[early]).max()
    )


def test_step_response_ends_at_the_reference(design):
    response = step_response(design)
    assert response.angles[-1, 1] == pytest.approx(1, abs=1e-6)
    at_rest = np.append(response.angles[-1], np.zeros(design.rig.n_links))
    balance = design.plant.A @ at_rest + design.plant.B @ response.u[-1]
    assert balance == pytest.approx(0, abs=1e-6 * np.abs(design.plant.B).max())
    assert 0 < response.rise < response.t[-1] and response.overshoot < 0.01


def test_controller_gains_are_those_of_its_transfer_function(double_design):
    hz, gains = controller_gains(double_design.controller)
    P = double_design.controller.system
    z = np.exp(2j * np.pi * hz[50] * P.dt)
    direct = P.C @ np.linalg.solve(z * np.eye(P.nstates) - P.A, P.B) + P.D
    assert gains[50] == pytest.approx(np.abs(direct[0]))
    assert hz[-1] == pytest.approx(0.5 / P.dt) and gains.shape == (len(hz), 3)


def test_lag_of_filters_is_the_phase_of_their_response(double_design):
    cuts = double_design.rig.filters.input_hz[0], double_design.rig.filters.output_hz[0]
    filters, hold = lag(double_design, 2.0)
    response = np.prod([1 / (1 + 2j / cut) for cut in cuts])
    assert filters == pytest.approx(-np.degrees(np.angle(response)), rel=1e-12)
    assert hold == pytest.approx(3.6)


def test_frames_end_at_round_numbers():
    t = np.array([0.0, 1.0, 2.0])
    assert frame([np.array([0.0, -0.3, 9.0])], t, (0, 1)) == (-0.5, 0.5)
    assert frame([np.array([0.0, 0.5, 0.0])], t, (0, 2)) == (-0.5, 0.5)
    assert frame([np.array([0.0, 0.51, 0.0])], t, (0, 2)) == (-1.0, 1.0)


@pytest.mark.parametrize("make", [pages.weights_page, pages.observer_page])
def test_pages_change_data_only(design, make):
    fig = make(design)
    before = [len(ax.get_children()) for ax in fig.axes]
    caption = fig.caption
    fig.update(replace(design, R=tuple(2 * r for r in design.R)))
    assert [len(ax.get_children()) for ax in fig.axes] == before
    assert fig.caption != caption and fig.alt
    assert fig.update(design).caption == caption
    assert all(artist.axes in fig.axes for artist in fig.moving)


def test_design_keeps_what_a_change_leaves_alone(triple_design):
    for choice in (dict(kp=3.0), dict(R=(2.0,)), dict(E=(0.8, 0.7), coefficients=(1, 2, 3, 4.0))):
        kept, anew = triple_design.changed(**choice), replace(triple_design, **choice)
        assert kept == anew
        assert np.allclose(kept.F, anew.F) and np.allclose(kept.observer.L1, anew.observer.L1)
        assert np.allclose(kept.filtered_loop.A, anew.filtered_loop.A)
    assert triple_design.changed(kp=3.0).filtered is triple_design.filtered
    assert triple_design.changed(dt=0.02).model is not triple_design.model
