"""The pendulum that moves: its geometry, a small drawing to update, and an animation in SVG."""

import re
from html import escape, unescape
from itertools import pairwise

import numpy as np

from .._arguments import array, instance, number, text
from ..parameters import Pendulum
from .style import COLORS, angle_name, image_html, look, styled

FPS = 25  # frames per second of an animation as it is played


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


def link_color(i):
    """Colour of link i: that of the angle measured at its lower hinge."""
    return look(angle_name((i - 1) % 6 + 1))["color"]


def draw_links(ax, points, **line):
    """Links between points (n+1, 2), each in the colour of its angle; returns their lines."""
    return [
        ax.plot(*zip(*ends), color=link_color(i), solid_capstyle="round", **line)[0]
        for i, ends in enumerate(pairwise(points), 1)
    ]


def _faces(rig):
    """Colours of the hinges: filled where a motor is, open where it turns freely."""
    return ["black" if 1 <= i <= rig.n_motors else "white" for i in range(rig.n_links)]


@styled()
def draw_pendulum(ax, rig, angles):
    """Draw the rig at relative angles and return ``update(angles)``, which moves the drawing.

    Links wear the colour of their angle; a filled hinge has a motor, an open one is free. The axes
    are fixed and hold every attitude above the ground. ``update`` returns the moved artists.
    """
    n = check_rig(rig).n_links
    reach = sum(link.length for link in rig.links)
    ax.set_axis_off()
    ax.set(xlim=(-1.08 * reach, 1.08 * reach), ylim=(-0.15 * reach, 1.08 * reach), aspect="equal")
    ax.plot([-0.15 * reach, 0.15 * reach], [0, 0], color=COLORS["grey"], linewidth=3, zorder=1)
    ax.plot([0, 0], [0, 1.04 * reach], color=COLORS["grey"], linewidth=0.8, linestyle=":", zorder=1)
    links = draw_links(ax, np.zeros((n + 1, 2)), linewidth=5, zorder=2)
    hinge = dict(markersize=8, markeredgewidth=1.6, markeredgecolor="black", zorder=3)
    hinges = [ax.plot([], [], "o", markerfacecolor=face, **hinge)[0] for face in _faces(rig)]

    def update(angles):
        points = joints(rig, array("angles", angles, (n,)))
        for i in range(n):
            links[i].set_data(*points[i : i + 2].T)
            hinges[i].set_data(*points[i : i + 1].T)
        return [*links, *hinges]

    update(angles)
    return update


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
    n = check_rig(rig).n_links
    t = array("t", t, (None,))
    if len(t) < 2 or np.any(np.diff(t) <= 0):
        raise ValueError("t: expected at least two increasing times in s; pass the run's t.")
    angles = array("angles", angles, (len(t), n))
    number("speed", speed, above=0)
    number("width", width, above=60)
    number("height", height, above=60)
    playing = (t[-1] - t[0]) / speed
    if not playing <= 3600:
        raise ValueError(f"t, speed: expected a film of an hour at most, found {playing:.3g} s.")
    times = np.linspace(t[0], t[-1], max(2, round(playing * FPS) + 1))
    frames = np.stack([np.interp(times, t, column) for column in angles.T], axis=-1)
    points, ground = _to_pixels(rig, joints(rig, frames), width, height)
    title = f"{rig.name}: pendulum in motion" if title is None else text("title", title)
    ends = f"{t[0]:g} s to {t[-1]:g} s"
    largest = ", ".join(
        f"{angle_name(i + 1)} {np.abs(angles[:, i]).max():.3f} rad" for i in range(n)
    )
    clock = f'dur="{playing:.2f}s" repeatCount="indefinite"'
    moving = [_link(points[:, i : i + 2], link_color(i + 1), clock) for i in range(n)]
    moving += [_hinge(points[:, i], face, clock) for i, face in enumerate(_faces(rig))]
    x, y = ground
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" width="{width:g}" height="{height:g}"'
        f' viewBox="0 0 {width:g} {height:g}">'
        f"<title>{escape(title)}</title>"
        f"<desc>Moving drawing of {n} links over {ends}, at {speed:g} times real speed. "
        f"Largest angles: {escape(largest)}.</desc>"
        f'<rect width="{width:g}" height="{height:g}" fill="white"/>{STILL}{_positions(points)}'
        f'<path d="M{x - 40:.1f} {y:.1f}h80" stroke="{COLORS["grey"]}" stroke-width="4"/>'
        f"<g class='pendlab-m'>{''.join(moving)}{_time_bar(width, height, ends, clock)}</g></svg>"
    )


# Of the two drawings one is shown: the moving one, or positions that stand still. The names must be
# nobody else's: a page may hold the drawing itself.
STILL = (
    "<style>.pendlab-s{display:none}@media (prefers-reduced-motion: reduce)"
    "{.pendlab-s{display:inline}.pendlab-m{display:none}}</style>"
)


def _positions(points, count=6):
    """The links at `count` times, later ones darker."""
    some = points[np.linspace(0, len(points) - 1, count).round().astype(int)]
    drawn = "".join(
        f'<polyline points="{x0:.1f},{y0:.1f} {x1:.1f},{y1:.1f}" stroke="{link_color(i + 1)}" '
        f'opacity="{(k + 1) / count:.2f}"/>'
        for k, pose in enumerate(some)
        for i, ((x0, y0), (x1, y1)) in enumerate(pairwise(pose))
    )
    return f"<g class='pendlab-s' fill='none' stroke-width='5' stroke-linecap='round'>{drawn}</g>"


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
    title, about = (
        unescape(svg.split(f"<{part}>")[1].split(f"</{part}>")[0]) for part in ("title", "desc")
    )
    still = re.sub("<style>.*</style>|<g class='pendlab-m'>.*</g>", "", svg)
    moving, still = (
        image_html(drawing.encode(), f"{title}. {words}", "image/svg+xml")
        for drawing, words in (
            (svg, about),
            (still, "Six positions of the run, later ones darker."),
        )
    )
    return HTML(
        f"{FOLDED}<details open class='pendlab-moving'><summary>{escape(caption or title)} "
        f"(show or hide the moving picture)</summary>{moving}{PAUSE}</details>"
        f"<div class='pendlab-rest'>{still}</div>"
    )


FOLDED = "<style>.pendlab-moving[open] + .pendlab-rest { display: none }</style>"
# An image hides its clock; the same drawing as a part of the page has one that can be halted.
PAUSE = """<script>{
const image = document.currentScript.previousElementSibling, button = document.createElement("button");
fetch(image.src).then((answer) => answer.text()).then((text) => {
  const box = document.createElement("div");
  box.innerHTML = text;
  const svg = box.firstChild;
  button.textContent = "Pause";
  button.onclick = () => {
    const halted = svg.animationsPaused();
    halted ? svg.unpauseAnimations() : svg.pauseAnimations();
    button.textContent = halted ? "Pause" : "Go on";
  };
  image.replaceWith(box, button);
});
}</script>"""


BAR = 34  # px kept below the drawing for the time


def _to_pixels(rig, points, width, height):
    """Joints (N, n+1, 2) in m to px in a frame that holds all of them and the upright rig."""
    reach = sum(link.length for link in rig.links)
    left, low = np.minimum(points.min(axis=(0, 1)), [-0.3 * reach, 0])
    right, high = np.maximum(points.max(axis=(0, 1)), [0.3 * reach, reach])
    margin = 14
    scale = min((width - 2 * margin) / (right - left), (height - BAR - 2 * margin) / (high - low))
    origin = np.array([width / 2 - scale * (left + right) / 2, height - BAR - margin + scale * low])
    return origin + scale * points * [1, -1], origin


def _animate(attribute, values, clock):
    return f'<animate attributeName="{attribute}" {clock} values="{";".join(values)}"/>'


def _link(ends, color, clock):
    values = [" ".join(f"{x:.1f},{y:.1f}" for x, y in pair) for pair in ends]
    return (
        f'<polyline points="{values[0]}" fill="none" stroke="{color}" stroke-width="7" '
        f'stroke-linecap="round">{_animate("points", values, clock)}</polyline>'
    )


def _hinge(centres, fill, clock):
    x, y = ([f"{value:.1f}" for value in column] for column in centres.T)
    circle = f'<circle cx="{x[0]}" cy="{y[0]}" r="5" fill="{fill}" stroke="black" stroke-width="2"'
    if np.ptp(centres, axis=0).max() == 0:
        return circle + "/>"
    return f"{circle}>{_animate('cx', x, clock)}{_animate('cy', y, clock)}</circle>"


def _time_bar(width, height, ends, clock):
    y, full = height - 10, width - 28
    rect = f'<rect x="14" y="{y:g}" width="{full:g}" height="4" fill='
    return (
        f'<text x="14" y="{y - 6:g}" font-family="DejaVu Sans, sans-serif" font-size="13">{ends}'
        f'</text>{rect}"{COLORS["pale"]}"/>{rect}"{COLORS["grey"]}">'
        f"{_animate('width', ['0', f'{full:g}'], clock)}</rect>"
    )
