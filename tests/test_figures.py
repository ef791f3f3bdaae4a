"""Computed figures: identities of their data, captions, redrawing, frames, files, errors."""

import io
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import pendlab as pl
from pendlab.figures import loops, pages
from pendlab.figures.frequency import HZ, decibels, draw_loops, frequencies, nyquist, sigma_min
from pendlab.figures.rootlocus import draw_root_locus, root_locus
from pendlab.figures.sampling import sampling_page
from pendlab.figures.style import CaptionedFigure, image_html, look, new_figure, small_png
from pendlab.figures.turns import full_nyquist
from pendlab.loop import (
    broken_at,
    frequency_response,
    margins,
    return_differences,
    state_feedback_loop,
)
from pendlab.nyquist import encirclements
from pendlab.paper.ledger import published
from pendlab.sampled import add_integrator, align

COMPUTED = (6, 7, 8, 10, 11, 12, 13, 14)
NEAR = (8, 10, 11, 12)


@pytest.fixture(scope="module")
def double():
    return pl.paper_design("double")


@pytest.fixture(scope="module")
def triple():
    return pl.paper_design("triple")


@pytest.fixture(scope="module")
def figures():
    return {number: pl.figure(number) for number in COMPUTED}


def numbers(text):
    return [float(word) for word in re.findall(r"-?\d+\.\d+", text)]


def data_of(fig):
    """Everything that the artists of a figure show."""
    lines = [line.get_xydata() for ax in fig.axes for line in ax.lines]
    words = [t.get_text() for ax in fig.axes for t in [*ax.texts, *legend_texts(ax)]]
    return lines, words


def legend_texts(ax):
    return ax.get_legend().get_texts() if ax.get_legend() else []


# What the curves are


@pytest.mark.parametrize("observer", [1, 2])
def test_nominal_curve_of_fig_8_is_state_feedback(observer):
    """H = 0 recovers F (zI - A)^-1 B whichever observer is used, equation (11)."""
    design = pl.paper_design("double", observer)
    curve = nyquist(design.loop(0))
    A, B = design.augmented.A, design.augmented.B
    z = np.exp(1j * curve.omega * design.dt)
    by_hand = [(design.F @ np.linalg.solve(s * np.eye(len(A)) - A, B))[0, 0] for s in z]
    np.testing.assert_allclose(curve.curve, by_hand, rtol=1e-6)


def test_filters_change_the_curve(double):
    nominal, filtered = nyquist(double.loop(0)), nyquist(double.loop(0, filters=True))
    assert np.abs(nominal.curve - filtered.curve).max() > 0.1


@pytest.mark.parametrize("filters", [False, True])
def test_return_differences_multiply_to_the_determinant(triple, filters):
    """rd1 (1 + p2 g2) = rd2 (1 + p1 g1) = det(I + P G)."""
    loop = triple.filtered_loop if filters else triple.nominal_loop
    rd1, rd2 = (nyquist(triple.loop(i, filters)).curve + 1 for i in (0, 1))
    det = nyquist(loop)
    L = frequency_response(loop, det.omega)
    np.testing.assert_allclose(rd1 * (1 + L[:, 1, 1]), det.curve, rtol=1e-6)
    np.testing.assert_allclose(rd2 * (1 + L[:, 0, 0]), det.curve, rtol=1e-6)


@pytest.mark.parametrize("filters", [False, True])
def test_curves_of_figs_10_to_14_are_equations_33_to_35(triple, filters):
    plant = triple.filtered if filters else triple.model
    loop = triple.filtered_loop if filters else triple.nominal_loop
    sigma = sigma_min(loop)
    rd = return_differences(triple.controller, plant, sigma.omega)
    np.testing.assert_allclose(sigma.sigma, rd.sigma_min, rtol=1e-8)
    curve = lambda loop: nyquist(loop, points=1200).curve  # noqa: E731
    np.testing.assert_allclose(curve(loop), rd.det, rtol=1e-8)
    np.testing.assert_allclose(curve(triple.loop(0, filters)), rd.rd1 - 1, rtol=1e-6)
    np.testing.assert_allclose(curve(triple.loop(1, filters)), rd.rd2 - 1, rtol=1e-6)


def test_fig_10_is_the_loop_that_F_was_designed_for(triple):
    """The solid curve of Fig 10 is F (zI - A_t1)^-1 B_t1."""
    rd1 = nyquist(triple.loop(0))
    L = frequency_response(triple.state_feedback_loop, rd1.omega)[:, 0, 0]
    np.testing.assert_allclose(rd1.curve, L, rtol=1e-6)


def test_smallest_singular_value_lies_below_both_return_differences(triple):
    sigma = sigma_min(triple.filtered_loop, points=3000)
    for index in (0, 1):
        assert np.all(sigma.sigma <= np.abs(1 + nyquist(triple.loop(index, True)).curve) + 1e-12)
    assert sigma.lowest <= sigma.sigma.min()


def test_marks_lie_on_axis_and_circle(double, triple):
    for loop in (double.loop(0), double.loop(0, True), triple.loop(0), triple.loop(1, True)):
        data = nyquist(loop)
        real_axis, circle = data.marked
        assert abs(real_axis.imag) < 1e-6 and real_axis.real < -1
        assert abs(circle) == pytest.approx(1, abs=1e-6)
        assert data.distance <= np.abs(1 + data.curve).min()
    det = nyquist(triple.nominal_loop)
    assert abs(det.marked[0].imag) < 1e-6 and det.marked[0].real < 0 and np.isnan(det.marked[1])


def test_frequencies_end_at_half_the_sampling_rate():
    omega = frequencies(0.02)
    assert omega[-1] == pytest.approx(np.pi / 0.02) and np.all(np.diff(omega) > 0)


# Turns


@pytest.mark.parametrize("which", ["double", "rd1", "rd2", "rd2 with filters", "det"])
def test_turns_on_the_ray_are_the_counted_ones(double, triple, which):
    loop = {
        "double": double.state_feedback_loop,
        "rd1": triple.loop(0),
        "rd2": triple.loop(1),
        "rd2 with filters": triple.loop(1, True),
        "det": triple.nominal_loop,
    }[which]
    data = full_nyquist(loop)
    _, radii, signs = data.ray
    assert signs.sum() == encirclements(loop).turns == len(data.unstable)
    assert len(radii) == len(signs) and np.all(radii > 0)
    np.testing.assert_allclose(data.closed, data.closed[::-1].conj())


def test_unstable_loop_turns_less_often(double):
    """Below the smallest gain that stabilises, the count drops below the number of poles."""
    loop = double.state_feedback_loop
    weak = state_feedback_loop(double.augmented, 0.3 * double.F)
    assert margins(loop).gain_down > 0.3
    data = full_nyquist(weak)
    assert data.ray[2].sum() == data.count.turns < data.count.unstable_open
    assert "unstable" in loops.turns_figure(weak).caption


def test_third_turn_of_rd2_is_the_integrators(triple):
    """Input 1 fed back without integrator leaves two unstable poles, with it a third, slow one."""
    plant, F = triple.model, triple.F
    states = plant.nstates
    unstable = lambda A: np.sum(np.abs(np.linalg.eigvals(A)) > 1)  # noqa: E731
    assert unstable(plant.A - plant.B[:, :1] @ F[:, :states]) == 2
    augmented = add_integrator(plant, 1)
    closed = augmented.A - augmented.B[:, :1] @ F
    assert unstable(closed) == 3
    slow = min(np.linalg.eigvals(closed), key=lambda z: abs(z - 1))
    assert slow.imag == 0 and 1 + 5e-6 < slow.real < 1 + 2e-5
    assert encirclements(broken_at(triple.nominal_loop, 1)).turns == 3
    assert f"{slow.real:.7f}" in pl.figure(11).caption


# Root locus


def test_branches_are_the_eigenvalues_of_the_aligned_model(triple):
    data = root_locus(triple.model, np.linspace(0, 20, 21), 10.0)
    assert set(np.linspace(0, 20, 21)) <= set(data.kps) and np.all(np.diff(data.kps) > 0)
    for k in (0, len(data.kps) // 3, -1):
        expected = np.linalg.eigvals(align(triple.model, data.kps[k]).A)
        np.testing.assert_allclose(
            np.sort_complex(data.branches[k]), np.sort_complex(expected), atol=1e-9
        )
    assert np.abs(np.diff(data.branches, axis=0)).max() < 0.01, "branches jump"


def test_changes_put_an_eigenvalue_on_the_circle(triple):
    data = root_locus(triple.model, np.linspace(0, 100, 101), 10.0)
    assert len(data.changes) == 2
    for kp in data.changes:
        size = np.abs(np.linalg.eigvals(align(triple.model, kp).A))
        assert np.abs(size - 1).min() < 1e-9
    assert data.unstable == published("eq18.unstable").values


def test_fig_6_shows_five_of_six(figures):
    fig = figures[6]
    assert published("fig6.eigenvalues").values == 5
    assert "5 of 6" in fig.alt
    for kp in (0, 10, 20):
        assert published(f"eq18.eigenvalue.k_p_{kp}").printed in fig.caption


@pytest.mark.parametrize("kps", [[1.0], [2.0, 1.0], [[0.0, 1.0]]])
def test_gains_of_the_sweep_must_rise(triple, kps):
    with pytest.raises(ValueError, match="kps: expected"):
        root_locus(triple.model, kps, 10.0)


# Figures


def test_figures_carry_words_and_frames(figures):
    for number, fig in figures.items():
        assert isinstance(fig, CaptionedFigure)
        assert fig.caption.startswith(f"Fig {number}. ") and len(fig.alt) > 80
        assert "nan" not in fig.caption + fig.alt and "inf" not in fig.caption + fig.alt
    for number in (6, *NEAR, 14):
        ax = figures[number].axes[0]
        frame = published(f"fig{number}.frame").values
        np.testing.assert_allclose([ax.get_xlim(), ax.get_ylim()], frame)
        assert ax.get_xlabel() and ax.get_ylabel()
    for number in NEAR:
        assert figures[number].axes[0].get_aspect() == 1


def test_nothing_is_cut_off_at_the_edge_of_the_page(figures):
    for number, fig in figures.items():
        fig.draw_without_rendering()
        page = fig.bbox
        for ax in fig.axes:
            for artist in [ax.title, *ax.texts, *legend_texts(ax), ax.xaxis.label, ax.yaxis.label]:
                if artist.get_text() and artist.get_visible():
                    box = artist.get_window_extent()
                    assert box.x0 >= -1 and box.y0 >= -1, (number, artist.get_text())
                    assert box.x1 <= page.x1 + 1 and box.y1 <= page.y1 + 1, (
                        number,
                        artist.get_text(),
                    )


def test_no_mark_hides_the_critical_point(figures):
    for number in NEAR:
        lines = figures[number].axes[0].lines
        critical = next(line for line in lines if str(line.get_label()).startswith("critical"))
        assert all(
            line.get_zorder() < critical.get_zorder() for line in lines if line is not critical
        )


def test_captions_say_what_the_margins_are(figures, triple, double):
    for i, (number, index) in enumerate([(10, 0), (11, 1)]):
        nominal, filtered = (margins(triple.loop(index, f)) for f in (False, True))
        said = numbers(figures[number].caption)
        assert any(abs(x - nominal.modulus) < 5e-3 for x in said)
        assert any(abs(x - filtered.modulus) < 5e-3 for x in said)
        assert any(abs(x - filtered.gain_up) < 0.05 for x in said), i
    said = numbers(figures[11].caption)
    assert any(abs(x - np.degrees(margins(triple.loop(1, True)).phase)) < 0.05 for x in said)
    said = numbers(figures[8].caption)
    for observer in (1, 2):
        m = margins(pl.paper_design("double", observer).loop(0, True))
        assert f"bears {m.gain_up:.3g} times the gain" in figures[8].caption
        for expected in (m.modulus, m.phase_omega / HZ):
            assert any(abs(x - expected) <= 5e-3 for x in said)
    lowest = [sigma_min(loop).lowest for loop in (triple.nominal_loop, triple.filtered_loop)]
    assert all(f"{decibels(x):.1f} dB" in figures[14].caption for x in lowest)


def test_printed_frequencies_stand_beside_ours_for_the_papers_design_only(triple):
    fig = pl.figure(10)
    words = " ".join(data_of(fig)[1])
    for curve in ("nominal", "filters"):
        for end in ("lower", "upper"):
            assert f"(paper {published(f'fig10.frequencies.{curve}.{end}').printed})" in words
    other = pl.figure(10, replace(triple, kp=8.0))
    assert "paper" not in " ".join(data_of(other)[1])


def test_frequencies_are_near_the_printed_ones(figures):
    """Each within 0.04 Hz of the number printed beside its own curve."""
    for number in NEAR:
        pairs = re.findall(r"([\d.]+) Hz \(paper ([\d.]+)\)", " ".join(data_of(figures[number])[1]))
        assert len(pairs) == {8: 6, 10: 4, 11: 4, 12: 2}[number]
        assert all(abs(float(ours) - float(paper)) <= 0.04 for ours, paper in pairs)


@pytest.mark.parametrize(
    "make, name, change",
    [
        (pages.kp_page, "triple", {"kp": 6.0}),
        (pages.weights_page, "double", {"Q": (0.1, 1e4, 0, 0.01, 1)}),
        (pages.observer_page, "triple", {"E": (0.8, 0.7)}),
        (sampling_page, "double", {"dt": 0.02}),
    ],
)
def test_updated_page_equals_a_fresh_one(make, name, change):
    first = pl.paper_design(name)
    changed = replace(first, coefficients=None, **change)
    fig, fresh = make(first), make(changed)
    before = fig.caption
    count = [len(ax.get_children()) for ax in fig.axes]
    assert fig.update(changed) is fig
    assert [len(ax.get_children()) for ax in fig.axes] == count, "artists were added"
    assert fig.caption == fresh.caption != before and fig.alt == fresh.alt
    assert (fig.lead, fig.table, fig.verdict) == (fresh.lead, fresh.table, fresh.verdict)
    for ours, theirs in zip(fig.moving, fresh.moving, strict=True):
        assert ours.get_label() == theirs.get_label()
        np.testing.assert_allclose(ours.get_xydata(), theirs.get_xydata(), rtol=1e-9, atol=1e-12)


def test_panels_take_several_curves_and_any_frame(triple):
    fig = new_figure()
    ax = fig.subplots()
    curves = [nyquist(triple.loop(0)), nyquist(triple.loop(1))]
    update = draw_loops(ax, curves, [look("nominal"), look("filters")], ((-4, 1), (-2, 2)))
    np.testing.assert_array_equal(ax.lines[2].get_xdata(), curves[0].curve.real)
    update(curves[::-1])
    np.testing.assert_array_equal(ax.lines[2].get_xdata(), curves[1].curve.real)
    assert ax.get_xlim() == (-4, 1)
    fig = new_figure()
    frame = (-1.2, 1.2), (-1.2, 1.2)
    draw_root_locus(fig.subplots(), root_locus(triple.model, [0.0, 10.0, 20.0], 5.0), frame)
    assert small_png(fig)[:4] == b"\x89PNG"


def test_unstable_design_is_drawn_and_said_to_be_so(triple):
    """Filters and a high k_p: the loop with filters is unstable, and the words say so."""
    fig = pl.figure(11, replace(triple, kp=30.0, coefficients=None))
    assert "with filters the closed loop is unstable" in fig.caption
    assert "without" not in fig.caption
    assert len(small_png(fig)) > 5000


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_drawings_take_a_design_or_a_rig(number, double):
    assert pl.figure(number, double).caption == pl.figure(number, double.rig).caption


@pytest.mark.parametrize("number", [5, 9])
def test_diagrams_have_one_form(number, double):
    assert pl.figure(number, double).caption == pl.figure(number).caption


@pytest.mark.parametrize("number", [0, 99, -1, "8", None, [8]])
def test_unknown_figure(number):
    with pytest.raises(ValueError, match="number: expected a figure of the paper, one of 1, 2, 3"):
        pl.figure(number)


@pytest.mark.parametrize("number", [10, 11, 12, 13, 14])
def test_figures_of_two_inputs_ask_for_them(number, double):
    with pytest.raises(ValueError, match=f"design: Fig {number} takes a rig with two motors"):
        pl.figure(number, double)


def test_wrong_design_is_named():
    with pytest.raises(TypeError, match=r"design: expected a pl\.Design"):
        pl.figure(8, "double")
    with pytest.raises(TypeError, match=r"other: expected a pl\.Design"):
        pl.figure(8, other=3)
    with pytest.raises(TypeError, match="other: Fig 10 shows one design"):
        pl.figure(10, other=pl.paper_design("triple"))
    with pytest.raises(ValueError, match="k_p to mark"):
        pl.figure(6, pl.paper_design("double"))


# Files and notebooks


def test_files_are_the_same_each_time(tmp_path):
    written = []
    for folder in ("one", "two"):
        paths = pl.save(pl.figure(14), tmp_path / folder, "fig14")
        assert [path.name for path in paths] == ["fig14.png", "fig14.svg"]
        written.append([path.read_bytes() for path in paths])
    assert written[0] == written[1]
    assert b"<dc:date>" not in written[0][1]
    assert Image.open(io.BytesIO(written[0][0])).info.get("Software") is None


def test_show_gives_picture_caption_and_folded_description(monkeypatch):
    shown = []
    import IPython.display

    def keep(thing, **more):
        shown.append((thing, more))

    monkeypatch.setattr(IPython.display, "display", keep)
    fig = pl.figure(14)
    assert pl.show(fig) is None
    (bundle, more), (words, _) = shown
    assert bundle["image/png"] == small_png(fig) and bundle["text/plain"] == fig.caption
    assert bundle["text/html"] == image_html(small_png(fig), fig.alt) and more["raw"]
    assert words.data.startswith("**Fig 14.** ") and "<summary>Description</summary>" in words.data


def test_settings_of_the_user_change_no_figure(tmp_path):
    """A matplotlibrc in the working folder: no TeX is asked for, and the picture is the same."""
    settings = "text.usetex: True\nsavefig.dpi: 30\naxes.linewidth: 9\naxes.facecolor: red\n"
    (tmp_path / "matplotlibrc").write_text(settings)
    code = "import pendlab as pl; pl.save(pl.figure(5), '.', 'ours')"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    pl.save(pl.figure(5), tmp_path, "plain")
    for kind in ("png", "svg"):
        ours, plain = (tmp_path / f"{name}.{kind}" for name in ("ours", "plain"))
        assert ours.read_bytes() == plain.read_bytes()


@pytest.mark.parametrize("number, critical", [(10, -1), (11, -1), (12, 0)])
def test_another_design_gets_axes_that_fit_it(number, critical):
    """Critical point and marked crossings in sight; the paper's design keeps the paper's axes."""
    paper = pl.paper_design("triple")
    other = replace(
        paper, Q=(0.1, 250, 250, 1, 1, 1, 1e-3, 1e-3), R=(1, 1), kp=None, coefficients=None, tracked=(1, 2),
    )  # fmt: skip
    ax = pl.figure(number, other).axes[0]
    dots = [line.get_xydata() for line in ax.lines if len(line.get_xydata()) == 1]
    dots = np.concatenate([*dots, [[critical, 0]]])
    dots = dots[np.hypot(*(dots - [critical, 0]).T) < 4]  # what is far away is told in words
    assert len(dots) >= 2
    for values, (low, high) in zip(dots.T, (ax.get_xlim(), ax.get_ylim())):
        assert low < values.min() and values.max() < high
    assert not ax.child_axes
    frame = pl.published(f"fig{number}.frame").values
    kept = pl.figure(number).axes[0]
    np.testing.assert_allclose([kept.get_xlim(), kept.get_ylim()], frame)
