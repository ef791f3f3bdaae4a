"""The map of the series: every notebook on the way of the data, with a thumbnail of what it shows."""

import io

import numpy as np
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from PIL import Image

from ..parameters import load
from . import figure
from .moving import draw_pendulum
from .style import COLORS, describe, new_figure, png, styled

# Notebook, title, what it makes of the data, thumbnail: a figure's number, a formula, or the rig.
STOPS = (
    ("01", "introduction", "why is it hard?", "leaning"),
    ("A", "Lagrange", "energies to equations", r"$\frac{d}{dt}\frac{\partial T}{\partial\dot q}$"),
    ("02", "models", "rig to sampled model", 3),
    ("03", "observers", "states to estimates", 5),
    ("B", "lemma", "why H = 0", r"$I+PG$"),
    ("04", "design", "model to controller", 11),
    ("05", "experiment", "controller to traces", 15),
    ("06", "outlook", "the paper's future work", 14),
)


@styled()
def series_map():
    """One picture of the series: eight notebooks in the order in which the data flow."""
    fig = new_figure(10, 5.2, layout=None)
    ax = fig.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, 10), ylim=(0, 5.2))
    ax.axis("off")
    columns, width, height = 4, 2.1, 2.2
    places = []
    for k, (name, title, does, thumbnail) in enumerate(STOPS):
        row, column = divmod(k, columns)
        x, y = 0.2 + column * 2.5, 2.75 - row * 2.6
        places.append((x, y))
        ax.add_patch(
            FancyBboxPatch((x, y), width, height, boxstyle="round,pad=0,rounding_size=0.08",
                           facecolor="white", edgecolor=COLORS["blue"], linewidth=1.5)
        )  # fmt: skip
        ax.text(
            x + 0.1, y + height - 0.27, f"{name}  {title}", weight="bold", fontsize=12, va="center"
        )
        ax.text(x + 0.1, y + 0.2, does, fontsize=10, va="center", color=COLORS["grey"])
        inset = fig.add_axes(
            ((x + 0.1) / 10, (y + 0.4) / 5.2, (width - 0.2) / 10, (height - 0.9) / 5.2)
        )
        inset.imshow(_pixels(_thumbnail(thumbnail)))
        inset.axis("off")
    for k, (x, y) in enumerate(places[:-1]):
        following = places[k + 1]
        if following[1] == y:
            ends = (x + width + 0.04, y + height / 2), (following[0] - 0.04, y + height / 2)
        else:
            ends = (
                (x + width / 2, y - 0.04),
                (following[0] + width / 2, following[1] + height + 0.04),
            )
        ax.add_patch(
            FancyArrowPatch(*ends, arrowstyle="-|>", mutation_scale=14, color=COLORS["blue"])
        )
    return describe(
        fig,
        "The series follows the data: from the parameters of the rig through equations, models, "
        "observers and design to the traces on the bench. Boxes A and B are the paper's appendices.",
        "Eight boxes joined by arrows: "
        + ", ".join(f"{name} {title} ({does})" for name, title, does, _ in STOPS)
        + ".",
    )


def _pixels(fig):
    return np.asarray(Image.open(io.BytesIO(png(fig, dpi=50))).convert("RGB"))


def _thumbnail(what):
    if what == "leaning":
        return _leaning()
    return _formula(what) if isinstance(what, str) else figure(what)


@styled()
def _leaning():
    fig = new_figure(3, 2.6)
    draw_pendulum(fig.subplots(), load("triple"), (0.15, -0.35, 0.3))
    return fig


@styled()
def _formula(text):
    fig = new_figure(4, 2.6, layout=None)
    fig.text(0.5, 0.5, text, fontsize=44, ha="center", va="center")
    return fig
