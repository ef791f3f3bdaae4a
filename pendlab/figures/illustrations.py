"""Drawings that go with the words of a notebook: a body on its legs, a fall, modes, block chains."""

from itertools import pairwise

import numpy as np

from .._arguments import found, number, whole
from ..models import linearize
from .blocks import Diagram
from .moving import check_rig, draw_links, film, joints
from .sketch import note
from .style import COLORS, describe, new_figure, styled

# Ankle, hinges and shoulders of a body, m, and its other leg where that is lifted.
POSES = {
    "two feet: double pendulum": ([(0, 0), (-0.16, 0.85), (0.1, 1.55)], []),
    "one foot: triple pendulum": (
        [(0, 0), (-0.1, 0.45), (-0.02, 0.9), (0.12, 1.55)],
        [(-0.02, 0.9), (0.3, 0.62), (0.14, 0.25)],
    ),
}


@styled()
def biped():
    """A body that balances over its ankle as a chain of links: one motor fewer than links."""
    fig = new_figure(7.5, 3.9)
    for ax, (title, (body, leg)) in zip(fig.subplots(1, 2), POSES.items(), strict=True):
        ax.plot([-0.8, 0.8], [-0.03, -0.03], color=COLORS["grey"], linewidth=2)
        ax.plot(*np.reshape(leg, (-1, 2)).T, color=COLORS["pale"], linewidth=9)
        draw_links(ax, np.array(body), linewidth=7)
        for i, hinge in enumerate(body[:-1]):
            face = "black" if i else "white"
            ax.plot(*hinge, "o", markersize=11, markerfacecolor=face, markeredgecolor="black")
            name = f"motor {i}" if i else "free"
            ax.annotate(name, hinge, (14, -4 if i else 7), textcoords="offset points")
        head = body[-1][0] + 0.03, body[-1][1] + 0.14
        ax.plot(*head, "o", markersize=26, color=COLORS["pale"], markeredgecolor=COLORS["grey"])
        ax.set(title=title, xlim=(-0.8, 0.8), ylim=(-0.12, 1.85), aspect="equal")
        ax.set_axis_off()
    return describe(
        fig,
        "A body that balances over its ankle is a chain of links on a free hinge: one motor fewer "
        "than links.",
        "Two stick figures. Left: legs and trunk as two links, ankle free, one motor at the hip. Right, "
        "on one foot: three links, ankle free, motors at the second and third hinge, the other leg "
        "lifted.",
    )


@styled()
def strobe(rig, t, angles, every=0.09, count=7):
    """The last `count` positions of a fall, one `every` so many seconds, the last one darkest.

    Parameters
    ----------
    rig : Pendulum with n links
    t : (N,) times, s, increasing
    angles : (N, n) relative angles, rad
    """
    t, angles, joints_at = film(rig, t, angles)
    number("every", every, above=0)
    times = t[-1] - every * np.arange(whole("count", count, least=1, most=1000))[::-1]
    fig = new_figure(6, 3.6)
    ax = fig.subplots()
    for points, shade in zip(joints_at(times), np.linspace(0.2, 1, count), strict=True):
        draw_links(ax, points, linewidth=5, alpha=shade)
    ax.plot([-0.1, 0.1], [0, 0], color=COLORS["grey"], linewidth=3)
    ax.set(aspect="equal", xlabel="m", ylabel="m", ylim=(-0.05, None))
    bent = ", ".join(f"{bend:.0f}" for bend in np.abs(np.degrees(angles[-1, 1:])))
    return describe(
        fig,
        f"The {rig.name} pendulum falls within {t[-1]:.2f} s; the last {every * (count - 1):.2f} s are "
        f"drawn, a position every {every:g} s. For the first second there is next to nothing to see.",
        f"Positions of a falling {rig.name} pendulum at equal intervals of time, close together near "
        f"upright and far apart near the floor. At the end the hinges above the lowest are bent by "
        f"{bent} degrees.",
    )


@styled()
def modes(rig, lean=0.4):
    """The eigenvectors' angles drawn as leaning pendulums, the fastest mode first.

    `lean` is the largest angle from the vertical in each drawing, rad; the largest of the relative
    angles is drawn to the right. The model is that of `linearize`.
    """
    n = check_rig(rig).n_links
    number("lean", lean, above=0)
    values, vectors = np.linalg.eig(linearize(rig).A)
    order = np.argsort(-np.abs(values))
    fig = new_figure(9, 2.3)
    for ax, i in zip(fig.subplots(1, 2 * n), order, strict=True):
        shape = vectors[:n, i].real
        largest = shape[np.abs(shape).argmax()]
        at = joints(rig, lean * shape / np.abs(np.cumsum(shape)).max() * np.sign(largest))
        draw_links(ax, at, linewidth=4, marker="o", markersize=4)
        ax.plot([0, 0], [0, at[:, 1].max()], color="0.6", linestyle="--", linewidth=1)
        ax.set(xlim=(-0.45, 0.45), ylim=(-0.05, 0.95), aspect="equal")
        ax.set_title(f"$s$ = {values[i].real:.3g}/s\n{1 / abs(values[i]):.2g} s", fontsize=10)
        ax.set_axis_off()
    falls = ", ".join(f"{value.real:.3g}" for value in values[order] if value.real > 0)
    return describe(
        fig,
        f"The {rig.name} pendulum's modes, fastest first: it leaves upright in the shapes with "
        f"s = {falls} 1/s and in no other. In each the largest relative angle is drawn to the right.",
        f"{2 * n} stick figures of the pendulum bent into the shape of each eigenvector, with "
        f"eigenvalue and time constant above.",
    )


@styled()
def block_chains(rows, caption="", alt=""):
    """Chains of blocks below each other, each from a signal u through blocks to named signals.

    Parameters
    ----------
    rows : for each chain a list of (text in the block, name of the signal behind it)

    >>> block_chains([[(r"$\\Phi B$", "$x$"), ("$-F$", "$u_r$")]], "From u to u_r.").caption
    'From u to u_r.'
    """
    if not (_some(rows) and all(_some(row) and all(map(_pair, row)) for row in rows)) or rows[10:]:
        raise ValueError(
            'rows: expected 1 to 10 lists of pairs of texts such as [[("$-F$", "$u_r$")]], '
            f"{found(rows)}."
        )
    diagram, left, right = (
        Diagram(9, 0.95 * len(rows)),
        0.875,
        8.225,
    )  # of the first and last signal
    for i, blocks in enumerate(rows):
        y = 0.95 * (len(rows) - i) - 0.52
        if len(rows) > 1:
            note(diagram.ax, 0.1, y, f"({'abcdefghij'[i]})", ha="left")
        texts, signals = zip(*blocks)
        places = np.linspace(left, right, len(blocks) + 1)
        diagram.names(*((x, y + 0.14, signal) for x, signal in zip(places, ["$u$", *signals])))
        pitch, names = places[1] - left, [f"{i} {k}" for k in range(len(blocks))]
        for name, x, text in zip(names, places + pitch / 2, texts):
            diagram.box(name, x, y, text, width=pitch - 0.75, height=0.52)
        for way in pairwise([(0.5, y), *names, (8.6, y)]):
            diagram.wire(*way)
    return describe(diagram.fig, caption, alt)


def _some(value):
    return isinstance(value, (list, tuple)) and len(value) > 0


def _pair(block):
    return _some(block) and len(block) == 2 and all(isinstance(text, str) for text in block)
