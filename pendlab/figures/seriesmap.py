"""The map of the series: every notebook on the way of the data, with a sign of what it is about."""

from functools import partial
from itertools import pairwise

import numpy as np

from ..parameters import load
from .moving import draw_pendulum
from .sketch import arrow, box, canvas, note, unit_circle
from .style import COLORS, describe, look, styled

WIDTH, HEIGHT = 2.1, 2.2  # of a box, inches


def _pendulum(angles, ax):
    draw_pendulum(ax, load("triple"), angles)
    ax.set_aspect("equal", adjustable="box")


def _formula(text, ax):
    ax.text(0.5, 0.5, text, fontsize=19, ha="center", va="center", transform=ax.transAxes)


def _samples(ax):
    t = np.linspace(0, 6, 200)
    ax.plot(t, np.sin(t), **look("theta1"))
    ax.plot(t, np.sin(np.floor(t / 0.5) * 0.5), color=COLORS["black"], drawstyle="steps-post")


def _nyquist(ax):
    s = 1j * np.geomspace(1e-2, 1e2, 300)
    loop = 2.6 / ((s - 1) * (0.15 * s + 1) ** 2)
    unit_circle(ax)
    ax.plot(loop.real, loop.imag, **look("nominal"))
    ax.plot(-1, 0, **look("critical"))
    ax.set_aspect("equal")


def _swing(ax):
    t = np.linspace(0, 14, 300)
    ax.plot(t, np.sin(t), **look("theta1"))
    ax.plot(t, 0.55 * np.tanh(9 * np.sin(t + 0.9)), **look("theta2-theta1"))


# Notebook, title, what it makes of the data, its sign.
STOPS = (
    ("01", "introduction", "why is it hard?", partial(_pendulum, (0.15, -0.35, 0.3))),
    ("A", "Lagrange", "energies to equations", partial(_formula, r"$\frac{d}{dt}\frac{\partial T}{\partial\omega}$")),
    ("02", "models", "rig to sampled model", _samples),
    ("03", "observers", "states to estimates", partial(_formula, r"$\hat x=L_1y+L_2v$")),
    ("B", "lemma", "why H = 0", partial(_formula, "$I+PG$")),
    ("04", "design", "model to controller", _nyquist),
    ("05", "experiment", "controller to traces", _swing),
    ("06", "outlook", "what was left to do", partial(_pendulum, (-0.25, 0.2, 0.8))),
)  # fmt: skip


@styled()
def series_map():
    """One picture of the series: eight notebooks in the order in which the data flow."""
    fig, ax = canvas(10, 5.4)
    places = [(0.2 + 2.5 * (k % 4), 2.95 - 2.75 * (k // 4)) for k in range(len(STOPS))]
    for (x, y), stop in zip(places, STOPS, strict=True):
        _box(ax, x, y, *stop)
    for (x, y), (x_next, y_next) in pairwise(places):
        if y_next == y:
            way = (x + WIDTH + 0.04, y + HEIGHT / 2), (x_next - 0.04, y + HEIGHT / 2)
        else:
            turn, x, x_next = y - 0.27, x + WIDTH / 2, x_next + WIDTH / 2
            way = (x, y - 0.04), (x, turn), (x_next, turn), (x_next, y_next + HEIGHT + 0.02)
        arrow(ax, *way, size=14, color=COLORS["blue"])
    return describe(
        fig,
        "The series follows the data: from the parameters of the rig through equations, models, "
        "observers and design to the traces on the bench. Boxes A and B are the paper's appendices.",
        "Eight boxes joined by arrows: "
        + ", ".join(f"{name} {title} ({does})" for name, title, does, _ in STOPS)
        + ".",
    )


def _box(ax, x, y, name, title, does, draw):
    box(ax, x + WIDTH / 2, y + HEIGHT / 2, WIDTH, HEIGHT, rounded=0.08, edgecolor=COLORS["blue"],
        linewidth=1.5)  # fmt: skip
    top = y + HEIGHT - 0.25
    note(ax, x + 0.1, top, f"{name}  {title}", ha="left", weight="bold", fontsize=14)
    note(ax, x + 0.1, y + 0.22, does, ha="left", fontsize=12)
    sign = ax.inset_axes((x + 0.15, y + 0.45, WIDTH - 0.3, HEIGHT - 0.95), transform=ax.transData)
    draw(sign)
    sign.axis("off")
