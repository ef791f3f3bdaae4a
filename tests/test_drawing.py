"""What notebooks and homework draw with: `pl.lines`, illustrations, tables."""

import numpy as np
import pytest

import pendlab as pl
from pendlab.figures.style import LINES

T = np.linspace(0, 1, 20)


def test_a_signal_wears_its_own_look():
    fig = pl.lines({"rad": {"theta1": (T, T), "reference": (T, 0 * T)}}, "time, s", "c", "a")
    drawn, wanted = fig.axes[0].lines
    assert drawn.get_color() == LINES["theta1"]["color"] and drawn.get_label() == r"$\theta_1$"
    assert wanted.get_linestyle() == "--"
    assert (fig.caption, fig.alt) == ("c", "a") and fig.axes[0].get_ylabel() == "rad"


def test_other_curves_are_told_apart_without_being_told():
    curves = {f"curve {k}": (T, k * T) for k in range(9)}
    lines = pl.lines({"y": curves}, "x").axes[0].lines
    styles = [(line.get_color(), line.get_linestyle()) for line in lines]
    assert len(set(styles[:7])) == 7 and styles[7] == styles[0]
    assert [line.get_label() for line in lines] == list(curves)


def test_a_look_changes_what_it_names_alone():
    points = {"linestyle": "none", "marker": "o"}
    (line,) = pl.lines({"y": {"measured": (T, T, points)}}, "x").axes[0].lines
    assert line.get_marker() == "o" and line.get_linestyle() == "None"
    assert line.get_color() == pl.COLORS["black"]


def test_panels_axes_and_pieces():
    fig = pl.lines(
        {"gain": {"a": (T + 1, np.ones((20, 3)))}, "phase": {"b": (T + 1, T), "c": (2.0, 0.5)}},
        ["hertz", "rad/s"],
        log="x",
        frame=((1, 2), (None, None)),
    )
    left, right = fig.axes
    assert left.get_xlabel() == "hertz" and right.get_xlabel() == "rad/s"
    assert left.get_xscale() == "log" and left.get_yscale() == "linear"
    assert len(left.lines) == 3 and len({line.get_color() for line in left.lines}) == 1
    assert left.get_legend() is None and len(right.get_legend().get_texts()) == 2
    assert right.get_xlim() == (1, 2)


@pytest.mark.parametrize(
    "panels, more, words",
    [
        ([1, 2], {}, "panels: expected a dict"),
        ({}, {}, "panels: expected a dict"),
        ({"y": (T, T)}, {}, r"panels\['y'\]: expected a dict"),
        ({"y": {"a": T}}, {}, r"panels\['y'\]\['a'\]: expected \(x, y\)"),
        ({"y": {"a": (T, T, "red")}}, {}, "expected a look"),
        ({"y": {"a": (T, T[1:])}}, {}, r"one length, found \(20,\) and \(19,\)"),
        ({"y": {"a": (T, ["one"] * 20)}}, {}, "expected numbers"),
        ({"y": {"a": (T, T)}}, {"log": "z"}, "log: expected one of '', 'x', 'y', 'xy'"),
        ({"y": {"a": (T, T)}}, {"width": -1}, "width: expected a number of at least 0.5"),
        ({"y": {"a": (T, T)}}, {"x_label": ["one", "two"]}, "one for each of 1 panels"),
        ({"y": {"a": (T, T)}}, {"frame": 3}, "frame: expected"),
    ],
)
def test_bad_panels_are_answered_by_a_sentence(panels, more, words):
    with pytest.raises((TypeError, ValueError), match=words):
        pl.lines(panels, **{"x_label": "x", **more})


def test_illustrations_take_any_rig():
    for name in ("double", "triple"):
        rig = pl.load(name)
        n = rig.n_links
        fig = pl.modes(rig)
        assert len(fig.axes) == 2 * n
        growing = np.linalg.eigvals(pl.linearize(rig).A).real
        assert fig.caption.count(",") >= np.sum(growing > 0)
        fall = pl.strobe(rig, T, np.outer(T, np.ones(n)), every=0.05, count=4)
        assert len(fall.axes[0].lines) == 4 * n + 1 and f"{np.degrees(1):.0f}" in fall.alt
    assert pl.biped().alt and len(pl.biped().axes) == 2
    with pytest.raises(ValueError, match="angles: expected shape 20 x 2"):
        pl.strobe(pl.load("double"), T, np.zeros((20, 3)))
    with pytest.raises(TypeError, match="rig"):
        pl.modes("double")


def test_chains_of_blocks():
    fig = pl.block_chains([[("A", "x"), ("B", "y")], [("C", "z")]], "c", "a")
    texts = [text.get_text() for text in fig.axes[0].texts]
    assert {"(a)", "(b)", "A", "B", "C", "x", "y", "z", "$u$"} <= set(texts)
    with pytest.raises(ValueError, match="rows: expected 1 to 10 lists of pairs"):
        pl.block_chains([["A"]])


def test_tables_hold_the_files():
    table = pl.parameter_table("triple").data
    rig = pl.load("triple")
    for link in rig.links:
        assert f"{link.mass:g}" in table and f"{link.inertia:g}" in table
    assert "Table" in table and "| motor 2 |" in table
    with pytest.raises(ValueError, match="quadruple"):
        pl.parameter_table("quadruple")
    bench = pl.bench_imperfections(rig)
    assert f"| {bench.gap[0]} |" in pl.bench_table().data
    assert pl.bench_notes().data.startswith("> ")


@pytest.mark.parametrize(
    "call, word",
    [
        (lambda: pl.show(3), "fig"),
        (lambda: pl.save(3, ".", "a"), "fig"),
        (lambda: pl.save(pl.biped(), 3, "a"), "folder"),
        (lambda: pl.describe(3, "a", "b"), "fig"),
        (lambda: pl.describe(pl.biped(), 3, "b"), "caption"),
        (lambda: pl.bars(3), "study"),
        (lambda: pl.compare([1]), "runs"),
        (lambda: pl.pushes_figure({}), "maps"),
        (lambda: pl.Choice("a", "b", 3, 4), "a options"),
        (lambda: pl.Panel("t", 3, pl.View(pl.biped(), str)), "controls"),
        (lambda: pl.Panel("t", [pl.Switch("a", "b")], 4), "view"),
    ],
)
def test_wrong_kinds_are_named(call, word):
    with pytest.raises(TypeError, match=f"^{word}: expected"):
        call()
