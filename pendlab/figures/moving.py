"""The pendulum that moves: its geometry, a small drawing to update, and an animation in SVG."""

import re
from html import escape
from itertools import pairwise
from pathlib import Path
from string import Template
from xml.etree import ElementTree

import numpy as np

from .._arguments import array, instance, number, text
from ..parameters import Pendulum
from .style import COLORS, angle_name, image_html, look, styled

FPS = 25  # frames per second of an animation as it is played
BAR = 34  # px kept below its drawing for the time
# Of the film's two drawings one is shown: the moving one, or positions that stand still. Its page
# draws the film again as a part of itself: only the clock of such a drawing can be halted.
FILM, PAGE = (
    Template(Path(__file__).with_name(name).read_text(encoding="utf-8"))
    for name in ("film.svg", "film.html")
)


def check_rig(rig):
    """`rig` itself, or a sentence on what it should have been."""
    return instance("rig", rig, Pendulum, 'pl.load("double") or pl.load("triple")')


def joints(rig, angles):
    """Positions x (m, to the right) and y (m, up) of hinges and tip, shape (..., n+1, 2).

    `angles` are relative ones, theta1, theta2-theta1, ..., rad, shape (..., n); a positive angle
    leans to the right.

    >>> from pendlab.parameters import load
    >>> joints(load("double"), [0.0, 0.0])[:, 1].round(3).tolist()
    [0.0, 0.174, 0.674]
    """
    n = check_rig(rig).n_links
    angles = array("angles", angles)
    if angles.shape[-1:] != (n,):
        raise ValueError(f"angles: expected {n} in the last axis, found shape {angles.shape}.")
    theta = np.cumsum(angles, axis=-1)
    lengths = np.array([link.length for link in rig.links])
    steps = lengths[:, None] * np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    return np.concatenate([np.zeros_like(steps[..., :1, :]), np.cumsum(steps, axis=-2)], axis=-2)


def film(rig, t, angles):
    """Checked times (N,) and angles (N, n) of a run, and a function of times that gives joints."""
    t = array("t", t, (None,))
    if len(t) < 2 or np.any(np.diff(t) <= 0):
        raise ValueError("t: expected at least two increasing times in s; pass the run's t.")
    angles = array("angles", angles, (len(t), check_rig(rig).n_links))

    def joints_at(times):
        return joints(rig, np.stack([np.interp(times, t, column) for column in angles.T], axis=-1))

    return t, angles, joints_at


def link_color(i):
    """Colour of link i: that of the angle measured at its lower hinge."""
    return look(angle_name((i - 1) % 6 + 1))["color"]


def draw_links(ax, points, **line):
    """Links between points (n+1, 2), each in the colour of its angle."""
    for i, ends in enumerate(pairwise(points), 1):
        ax.plot(*zip(*ends), color=link_color(i), solid_capstyle="round", **line)


def _faces(rig):
    """Colours of the hinges: filled where a motor is, open where it turns freely."""
    return ["black" if 1 <= i <= rig.n_motors else "white" for i in range(rig.n_links)]


@styled()
def draw_pendulum(ax, rig, angles):
    """Draw the rig at relative angles (rad), in axes that hold every attitude above the ground.

    Links wear the colour of their angle; a filled hinge has a motor, an open one is free.
    """
    points = joints(rig, array("angles", angles, (check_rig(rig).n_links,)))
    reach = sum(link.length for link in rig.links)
    ax.set_axis_off()
    ax.set(xlim=(-1.08 * reach, 1.08 * reach), ylim=(-0.15 * reach, 1.08 * reach), aspect="equal")
    ax.plot([-0.15 * reach, 0.15 * reach], [0, 0], color=COLORS["grey"], linewidth=3, zorder=1)
    ax.plot([0, 0], [0, 1.04 * reach], color=COLORS["grey"], linewidth=0.8, linestyle=":", zorder=1)
    draw_links(ax, points, linewidth=5, zorder=2)
    hinge = dict(markersize=8, markeredgewidth=1.6, markeredgecolor="black", zorder=3)
    for at, face in zip(points, _faces(rig)):
        ax.plot(*at, "o", markerfacecolor=face, **hinge)


def animate_svg(rig, t, angles, width=360, height=320, speed=1.0, title=None):
    """A run as a moving picture: an SVG that plays by itself, with neither script nor network.

    Equal arguments give equal text. The run is shown at `FPS` frames a second, coordinates are
    rounded to 0.1 px, and a bar below tells the time.

    Parameters
    ----------
    t, angles : (N,) times, s, increasing, N >= 2; (N, n) relative angles, rad
    width, height : of the picture, px
    speed : 1 is real time, 0.5 half as fast
    title : name of the picture; the rig's name if None
    """
    t, angles, joints_at = film(rig, t, angles)
    number("speed", speed, above=0)
    number("width", width, above=60)
    number("height", height, above=60)
    playing = (t[-1] - t[0]) / speed
    if not playing <= 3600:
        raise ValueError(f"t, speed: expected a film of an hour at most, found {playing:.3g} s.")
    times = np.linspace(t[0], t[-1], max(2, round(playing * FPS) + 1))
    points, ground = _to_pixels(rig, joints_at(times), width, height)
    clock = f'dur="{playing:.2f}s" repeatCount="indefinite"'
    drawn = _drawn(np.char.mod("%.1f", points.T), _faces(rig), clock)
    span, full = f"{t[0]:g} s to {t[-1]:g} s", f"{width - 28:g}"
    sizes = [f"{angle_name(i)} {a:.3f} rad" for i, a in enumerate(np.abs(angles).max(axis=0), 1)]
    return FILM.substitute(
        **COLORS,
        **drawn,
        width=f"{width:g}",
        height=f"{height:g}",
        title=escape(f"{rig.name}: pendulum in motion" if title is None else text("title", title)),
        about=f"Moving drawing of {rig.n_links} links over {span}, at {speed:g} times real speed. "
        f"Largest angles: {', '.join(sizes)}.",
        ground="{:.1f} {:.1f}".format(*ground),
        below=f"{height - 10:g}",
        span=span,
        full=full,
        bar=_moving(f'rect height="4" fill="{COLORS["grey"]}"', clock, width=["0", full]),
    )


def _drawn(places, faces, clock, count=6):
    """Links, hinges, and links at `count` times from joints as text, shape (2, n + 1, N)."""
    x, y = places
    some = np.linspace(0, x.shape[1] - 1, count).round().astype(int)
    links = hinges = positions = ""
    for i, face in enumerate(faces):
        ends = [f"{a},{b} {c},{d}" for a, b, c, d in zip(x[i], y[i], x[i + 1], y[i + 1])]
        shape = f'polyline stroke="{link_color(i + 1)}"'
        links += _moving(shape, clock, points=ends)
        hinges += _moving(f'circle r="5" fill="{face}"', clock, cx=x[i], cy=y[i])
        for k, at in enumerate(some, 1):
            positions += f'<{shape} points="{ends[at]}" opacity="{k / count:.2f}"/>'
    return dict(links=links, hinges=hinges, positions=positions)


def _moving(shape, clock, **values):
    """A shape of which attributes take values one after the other."""
    first = " ".join(f'{name}="{texts[0]}"' for name, texts in values.items())
    moves = [
        f'<animate attributeName="{name}" {clock} values="{";".join(texts)}"/>'
        for name, texts in values.items()
        if len(set(texts)) > 1
    ]
    return f"<{shape} {first}>{''.join(moves)}</{shape.split()[0]}>"


def animation(rig, t, angles, caption=None, **options):
    """`animate_svg` as something to display in a notebook: a picture that moves, and can be stopped.

    The pictures are ``<img>``: they show in a notebook that is not trusted, in exports and without a
    kernel. Where scripts run, the button Pause halts the motion and lets it go on. Where none does,
    as in a clone that is not trusted, nothing that the front ends let through can halt a picture:
    there the heading hides the moving one, and the same run as positions that stand still is seen
    below it. Whoever asks the system for reduced motion sees those alone.

    Parameters
    ----------
    rig, t, angles, options : as for `animate_svg`
    caption : the heading above it; its title by default
    """
    from IPython.display import HTML

    if caption is not None:
        text("caption", caption)
    svg = animate_svg(rig, t, angles, **options)
    title, about = (part.text for part in ElementTree.fromstring(svg)[:2])
    still = re.sub("(?s)<style>.*</style>|<g class=.pendlab-m.*</g>", "", svg)
    moving, still = (
        image_html(drawing.encode(), f"{title}. {words}", "image/svg+xml")
        for drawing, words in (
            (svg, about),
            (still, "Six positions of the run, later ones darker."),
        )
    )
    page = PAGE.substitute(caption=escape(caption or title), moving=moving, still=still)
    return HTML(page.strip())


def _to_pixels(rig, points, width, height):
    """Joints (N, n+1, 2) in m to px in a frame that holds all of them and the upright rig."""
    reach = sum(link.length for link in rig.links)
    left, low = np.minimum(points.min(axis=(0, 1)), [-0.3 * reach, 0])
    right, high = np.maximum(points.max(axis=(0, 1)), [0.3 * reach, reach])
    margin = 14
    scale = min((width - 2 * margin) / (right - left), (height - BAR - 2 * margin) / (high - low))
    origin = np.array([width / 2 - scale * (left + right) / 2, height - BAR - margin + scale * low])
    return origin + scale * points * [1, -1], origin
