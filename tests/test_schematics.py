"""Drawn figures: they show the rig's numbers, and the pendulum stands where its geometry says."""

import base64
import dataclasses
import io
import xml.etree.ElementTree as ET

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

import pendlab as pl
from pendlab.figures.apparatus import apparatus
from pendlab.figures.blocks import apparatus_blocks, observer_blocks, triple_loops
from pendlab.figures.moving import BAR, animate_svg, draw_pendulum, joints
from pendlab.figures.schematics import schematic
from pendlab.figures.style import (
    COLORS,
    LINES,
    STYLE,
    describe,
    freeze_layout,
    look,
    new_figure,
    save,
    small_png,
    styled,
)
from pendlab.parameters import Pendulum, load

SVG = "{http://www.w3.org/2000/svg}"
SIZES = [(2, 1), (3, 1), (4, 2), (5, 4), (6, 5)]


def chain(n, m):
    """A rig of n links, the lower ones like the triple's middle link."""
    triple = load("triple")
    links = [triple.links[0], *[triple.links[1]] * (n - 2), triple.links[2]]
    motors = [triple.motors[min(i, 1)] for i in range(m)]
    return Pendulum(links=links, motors=motors, name=f"{n}-link")


def drawings(rig):
    return [
        apparatus(rig),
        schematic(rig),
        apparatus_blocks(rig),
    ]


def words(fig):
    """Every visible text of a figure."""
    texts = [text for ax in fig.axes for text in ax.texts] + fig.texts
    return [text.get_text() for text in texts]


def by_hand(rig, angles):
    """Joint positions, added up link by link."""
    x = y = theta = 0.0
    points = [(x, y)]
    for link, angle in zip(rig.links, angles):
        theta += angle
        x, y = x + link.length * np.sin(theta), y + link.length * np.cos(theta)
        points.append((x, y))
    return np.array(points)


@pytest.mark.parametrize("rig", [load("double"), load("triple"), *[chain(*s) for s in SIZES]])
def test_drawings_of_any_rig_have_words_and_stay_on_the_page(rig):
    for fig in drawings(rig):
        assert len(fig.axes) == 1
        assert fig.caption.endswith(".") and len(fig.alt) > 60
        assert small_png(fig).startswith(b"\x89PNG")
        page = fig.bbox
        for text in [text for ax in fig.axes for text in ax.texts] + fig.texts:
            box = text.get_window_extent()
            assert box.x0 >= page.x0 and box.x1 <= page.x1, text.get_text()
            assert box.y0 >= page.y0 and box.y1 <= page.y1, text.get_text()


@pytest.mark.parametrize("rig", [load("double"), load("triple"), chain(4, 3)])
def test_no_two_labels_overlap(rig):
    figures = [*drawings(rig), observer_blocks(), triple_loops()]
    for fig in figures:
        small_png(fig)
        texts = [text for ax in fig.axes for text in ax.texts if text.get_text()] + fig.texts
        boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
        for i, (one, a) in enumerate(boxes):
            for other, b in boxes[:i]:
                across = min(a.x1, b.x1) - max(a.x0, b.x0)
                down = min(a.y1, b.y1) - max(a.y0, b.y0)
                # Boxes of text hold some air: a few pixels of overlap are invisible.
                assert min(across, down) < 5, f"{one!r} and {other!r} overlap"


def test_block_diagrams_have_words():
    for fig, names in [
        (observer_blocks(), ["$F$", "$H$", "$K$", "$L_1$", "$L_2$", "X", "$u_r$"]),
        (triple_loops(), ["$g_1(z)$", "$g_2(z)$", "$p_1(z)$", "$p_2(z)$", "X", "XX"]),
    ]:
        assert set(names) <= set(words(fig))
        assert fig.caption and fig.alt and len(fig.axes) == 1


def test_figures_follow_the_parameters():
    rig = load("triple")
    heavier = dataclasses.replace(
        rig, links=[dataclasses.replace(rig.links[0], mass=7.531), *rig.links[1:]], u_max=(4.25, 1)
    )
    for draw, found in [(apparatus, "7.53"), (schematic, "7.531")]:
        assert any(found in text for text in words(draw(heavier)))
        assert not any(found in text for text in words(draw(rig)))
    assert any("4.25 V" in text for text in words(apparatus_blocks(heavier)))
    assert schematic(heavier).caption != schematic(rig).caption


def test_filter_lag_in_the_caption_is_that_of_two_first_order_filters():
    response = 1 / (1 + 2j / 10.26) / (1 + 2j / 33.86)
    lag = -np.degrees(np.angle(response))
    assert f"{lag:.1f} degrees" in apparatus_blocks(load("triple")).caption


def test_motor_hinges_are_filled_and_free_ones_open():
    fig = new_figure(3, 3)
    ax = fig.add_subplot()
    draw_pendulum(ax, load("triple"), [0, 0, 0])
    assert [line.get_markerfacecolor() for line in ax.lines[-3:]] == ["white", "black", "black"]


@pytest.mark.parametrize("rig", [load("double"), load("triple"), chain(5, 2)])
def test_draw_pendulum_stands_where_cumulative_angles_say(rig):
    n = rig.n_links
    rng = np.random.default_rng(n)
    for _ in range(3):
        angles = rng.uniform(-0.4, 0.4, n)
        expected = by_hand(rig, angles)
        ax = new_figure(3, 3).add_subplot()
        draw_pendulum(ax, rig, angles)
        drawn = np.array([link.get_xydata() for link in ax.lines[-2 * n : -n]])
        np.testing.assert_allclose(drawn[:, 0], expected[:-1], atol=1e-12)
        np.testing.assert_allclose(drawn[:, 1], expected[1:], atol=1e-12)
        np.testing.assert_allclose(joints(rig, angles), expected, atol=1e-12)


def test_joints_of_many_moments_at_once():
    rig = load("triple")
    angles = np.random.default_rng(1).normal(size=(4, 3))
    each = [by_hand(rig, row) for row in angles]
    np.testing.assert_allclose(joints(rig, angles), each, atol=1e-12)


def run_of(rig, n_samples=301):
    t = np.linspace(0, 3, n_samples)
    angles = 0.2 * np.sin(np.outer(t, 1 + np.arange(rig.n_links))) + 0.05
    return t, angles


@pytest.mark.parametrize("name", ["double", "triple"])
def test_animation_is_xml_and_ends_at_the_last_sample(name):
    rig = load(name)
    t, angles = run_of(rig)
    root = ET.fromstring(animate_svg(rig, t, angles, title="a < b & c"))
    assert root.get("role") == "img"
    assert root.find(f"{SVG}title").text == "a < b & c"
    assert "3 s" in root.find(f"{SVG}desc").text
    links = root.findall(f"{SVG}g[@class='pendlab-m']/{SVG}polyline")
    assert len(links) == rig.n_links
    frames = [link.find(f"{SVG}animate").get("values").split(";") for link in links]
    assert {len(values) for values in frames} == {76}  # 3 s at 25 frames a second, and the first
    for pick, sample in [(-1, -1), (0, 0)]:
        ends = [np.array([pair.split(",") for pair in values[pick].split()], float)
                for values in frames]  # fmt: skip
        pixels = np.vstack([ends[0], *[pair[1:] for pair in ends[1:]]])
        metres = by_hand(rig, angles[sample])
        scale = np.linalg.norm(np.diff(pixels, axis=0), axis=1).sum() / sum(
            link.length for link in rig.links
        )
        expected = pixels[0] + scale * metres * [1, -1]
        np.testing.assert_allclose(pixels, expected, atol=0.3)  # each rounded to 0.1 px


def test_animation_is_deterministic_small_and_keeps_to_its_frame():
    rig = load("triple")
    t, angles = run_of(rig)
    text = animate_svg(rig, t, angles, width=300, height=200)
    assert text == animate_svg(rig, t.copy(), angles.copy(), width=300, height=200)
    assert len(text) < 20_000
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "") and "script" not in text
    for link in ET.fromstring(text).findall(f"{SVG}g[@class='pendlab-m']/{SVG}polyline"):
        for frame in link.find(f"{SVG}animate").get("values").split(";"):
            for x, y in (map(float, pair.split(",")) for pair in frame.split()):
                assert 0 < x < 300 and 0 < y < 200 - BAR


def test_animation_speed_stretches_the_time_shown():
    rig = load("double")
    t, angles = run_of(rig)
    slow = ET.fromstring(animate_svg(rig, t, angles, speed=0.5))
    assert {node.get("dur") for node in slow.iter(f"{SVG}animate")} == {"6.00s"}


@pytest.mark.parametrize(
    "call, word",
    [
        (lambda: apparatus("triple"), "rig"),
        (lambda: schematic(None), "rig"),
        (lambda: schematic(load("triple"), [0.1, 0.2]), "angles"),
        (lambda: schematic(load("triple"), [0.1, np.nan, 0]), "angles"),
        (lambda: apparatus_blocks(load("double"), dt=0), "dt"),
        (lambda: joints(load("double"), np.zeros((5, 3))), "angles"),
        (lambda: animate_svg(load("double"), [0, 1], np.zeros((3, 2))), "angles"),
        (lambda: animate_svg(load("double"), [1, 0], np.zeros((2, 2))), "t"),
        (lambda: animate_svg(load("double"), [0], np.zeros((1, 2))), "t"),
        (
            lambda: animate_svg(load("double"), [0, 1], np.zeros((2, 2)), speed=0),
            "speed",
        ),
        (lambda: look("theta9"), "name"),
    ],
)
def test_bad_input_is_one_sentence_that_names_the_argument(call, word):
    with pytest.raises((ValueError, TypeError)) as problem:
        call()
    message = str(problem.value)
    assert message.startswith(f"{word}:") and message.endswith(".") and "\n" not in message


def test_style_leaves_the_global_settings_alone():
    before = dict(matplotlib.rcParams)
    for fig in drawings(load("triple")):
        small_png(fig)
    with styled():
        assert all(matplotlib.rcParams[key] == STYLE[key] for key in ("font.size", "axes.grid"))
    assert dict(matplotlib.rcParams) == before
    import matplotlib.pyplot as plt

    assert plt.get_fignums() == []


def test_every_line_has_a_colour_of_the_palette_and_a_label():
    for name, line in LINES.items():
        assert line["color"] in COLORS.values() and line["label"], name
    ax = new_figure().add_subplot()
    for name in LINES:
        ax.plot([0, 1], [0, 1], **look(name))


def test_words_of_a_figure_go_with_its_picture(tmp_path):
    fig = describe(new_figure(2, 2), "A  claim\n here.", 'Shows "x" < y.')
    fig.add_subplot().plot([0, 1])
    freeze_layout(fig)
    bundle = fig._repr_mimebundle_()
    assert bundle["text/plain"] == "A claim here." and bundle["image/png"] == small_png(fig)
    assert bundle["text/html"].startswith(
        '<img alt="Shows &quot;x&quot; &lt; y." src="data:image/png;'
    )
    for suffix in ("svg", "png"):
        first, second = (save(fig, tmp_path / f"{i}.{suffix}") for i in "ab")
        assert first.read_bytes() == second.read_bytes()


def test_small_picture_shows_the_same_with_fewer_bytes(tmp_path):
    fig = pl.figure(11)
    whole, small = save(fig, tmp_path / "whole.png", dpi=100).read_bytes(), small_png(fig)
    pixels, palette = (
        np.round(255 * imread(io.BytesIO(part))[:, :, :3]) for part in (whole, small)
    )
    assert len(small) < 0.45 * len(whole)
    assert np.mean(np.abs(pixels - palette).max(axis=2) > 16) < 0.001
    assert small_png(fig) == small  # equal figures give equal bytes


def test_animation_has_words_and_stands_still_when_asked():
    rig = load("double")
    page = pl.animation(rig, *run_of(rig), title="a < b").data
    assert "<summary>a &lt; b (show or hide" in page and 'alt="a &lt; b. Moving' in page
    svg, rest = (
        base64.b64decode(part.split('"')[0]).decode() for part in page.split("svg+xml;base64,")[1:]
    )
    assert "animate" in svg and "animate" not in rest and "style" not in rest
    assert rest.count("<polyline") == 6 * rig.n_links
    root = ET.fromstring(svg)
    still = root.find(f"{SVG}g[@class='pendlab-s']")
    assert len(still) == 6 * rig.n_links and not list(still.iter(f"{SVG}animate"))
    assert "prefers-reduced-motion" in root.find(f"{SVG}style").text
