"""One look for every figure: fonts, colours and lines, and the words that go with a picture.

Nothing here changes matplotlib's global settings: figure functions wear ``@styled()``, which applies
`STYLE` on matplotlib's defaults while they run, so that a user's own settings change no figure.
Figures are Agg figures outside pyplot, so none lingers in memory.
"""

import base64
import io
from contextlib import contextmanager
from html import escape
from itertools import cycle

import numpy as np
from matplotlib import rc_context, rcParams, rcParamsDefault
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from .._arguments import instance, number, text
from ..bench.arguments import one_of

# Okabe and Ito's colours: told apart by readers with any of the common colour deficiencies. Orange
# and sky are darker than theirs, so that a line on white has a contrast of 3 to 1.
COLORS = dict(
    black="#000000",
    orange="#BF8600",
    sky="#3595D2",
    green="#009E73",
    yellow="#F0E442",
    blue="#0072B2",
    vermillion="#D55E00",
    purple="#CC79A7",
    grey="#6B6B6B",
    pale="#EDEFF2",
)

STYLE = {
    "figure.facecolor": "white",
    "figure.dpi": 100,
    "savefig.facecolor": "white",
    # Named, not "sans-serif": the alias is resolved when a figure is drawn, outside the style.
    "font.family": ["DejaVu Sans"],
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.labelsize": 11,
    "legend.fontsize": 10,
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "mathtext.fontset": "dejavusans",
    "axes.facecolor": "white",
    "axes.edgecolor": COLORS["grey"],
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#DADADA",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.8,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "none",
    "svg.hashsalt": "pendlab",
}

# Whatever a user's matplotlibrc says of drawing.
_PROGRAM = ("backend", "interactive", "keymap", "macosx", "timezone", "tk", "toolbar", "webagg")
SETTINGS = {k: v for k, v in rcParamsDefault.items() if not k.startswith(_PROGRAM)} | STYLE

ANGLES = "vermillion", "green", "purple", "orange", "sky"  # from the second on
LONG, MIXED, SHORT = (0, (7, 1.4)), (0, (6, 1.4, 1.4, 1.4)), (0, (2.2, 1.2))


def angle_name(i):
    """Key in `LINES` of the i-th measured angle: theta1, theta2-theta1, ...

    >>> angle_name(1), angle_name(3)
    ('theta1', 'theta3-theta2')
    """
    return "theta1" if i == 1 else f"theta{i}-theta{i - 1}"


def angle_label(i):
    """The i-th measured angle as a formula; nothing where there is no look for it."""
    return LINES.get(angle_name(i), {"label": ""})["label"]


def _line(color, linestyle, label, **more):
    return dict(color=COLORS[color], linestyle=linestyle, label=label, **more)


# Signal or curve -> how it is drawn, everywhere. Signals of time and curves of frequency never
# share axes, so that the colours may serve twice.
LINES = {
    # told apart without colour too
    "theta1": _line("blue", "-", r"$\theta_1$"),
    **{
        angle_name(i): _line(color, stroke, rf"$\theta_{i}-\theta_{i - 1}$")
        for i, (color, stroke) in enumerate(zip(ANGLES, cycle((LONG, MIXED, SHORT, "-"))), 2)
    },
    "rate": _line("purple", "-", r"$\dot\theta_1$"),
    **{
        f"u{i}": _line(color, "-" if i % 2 else (0, (7, 1.5)), f"$u_{i}$")
        for i, color in enumerate(("black", "orange", "sky", "grey", "green"), 1)
    },
    "reference": _line("grey", "--", "reference", linewidth=1.4),
    "estimate": _line("sky", ":", "estimate", linewidth=2.2),
    # curves of frequency, in the paper's line styles
    "nominal": _line("black", "-", "state feedback, nominal"),
    "filters": _line("vermillion", "--", "with filters"),
    "observer2": _line("blue", ":", "observer 2, with filters", linewidth=2.2),
    "unit circle": _line("grey", "-.", "unit circle", linewidth=1.0),
    # points
    "stable": _line("blue", "none", "stable", marker="o", markersize=6),
    "unstable": _line("vermillion", "none", "unstable", marker="X", markersize=8),
    "critical": _line("black", "none", "critical point", marker="P", markersize=9, zorder=5),
}


def look(name, **changes):
    """Keyword arguments for ``ax.plot`` of a signal or curve, with `changes` on top.

    >>> look("theta1", label="link 1")["label"]
    'link 1'

    Raises
    ------
    ValueError : a name that is not in `LINES`
    """
    if not isinstance(name, str) or name not in LINES:
        raise ValueError(f"name: no look for {name!r}; known are {', '.join(LINES)}.")
    return {**LINES[name], **changes}


@contextmanager
def styled():
    """The series' look for the time of a function (``@styled()``) or a block (``with styled():``).

    >>> with styled():
    ...     fig = new_figure(7, 3)
    ...     lines = fig.subplots().plot([0, 1], [0, 2], **look("theta1"))
    """
    with rc_context():
        # Every entry is one of matplotlib's own or of `STYLE`: checking each takes milliseconds.
        dict.update(rcParams, SETTINGS)
        yield


class CaptionedFigure(Figure):
    """A matplotlib figure that carries its words.

    At the end of a notebook cell it shows its picture with the description as its alternative text;
    the caption goes along as plain text.
    """

    caption = ""  # what the figure claims, one or two sentences
    alt = ""  # what it shows, for readers who do not see it

    def _repr_mimebundle_(self, include=None, exclude=None):
        return bundle(self)


@styled()
def new_figure(width=7.0, height=4.0, layout="constrained"):
    """An empty `CaptionedFigure` of width x height inches on its own Agg canvas.

    >>> with styled():
    ...     fig = new_figure(6, 3)
    ...     ax = fig.subplots()
    >>> describe(fig, "An empty frame.", "Two axes and nothing between them.").caption
    'An empty frame.'
    """
    width = number("width", width, least=0.5, most=100)
    height = number("height", height, least=0.5, most=100)
    one_of("layout", layout, ("constrained", "compressed", "tight", None))
    fig = CaptionedFigure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(fig)
    return fig


def describe(fig, caption, alt):
    """Give a figure its caption and alternative text; returns the figure."""
    instance("fig", fig, Figure, "pl.new_figure()")
    fig.caption = " ".join(text("caption", caption, empty=True).split())
    fig.alt = " ".join(text("alt", alt, empty=True).split())
    return fig


def freeze_layout(fig):
    """Lay the figure out once and keep it: later drawings of a moving figure skip that work."""
    with styled():
        fig.draw_without_rendering()
    fig.set_layout_engine("none")
    return fig


def small_png(fig, moving=(), colors=128):
    """The figure as a PNG with a palette: a third of the bytes, for pictures that are stored.

    `moving` are artists that a full drawing leaves out. The palette holds the most different
    colours, so that lines keep theirs; shades of edges move by a few levels.
    """
    with styled():
        fig.canvas.draw()
        for artist in moving:
            (artist.axes or fig).draw_artist(artist)
    pixels = Image.fromarray(np.asarray(fig.canvas.buffer_rgba())[:, :, :3])
    pixels = pixels.quantize(colors, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    pixels.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def bundle(fig):
    """What a notebook shows of a figure: picture with alternative text, caption as plain text."""
    picture, caption = small_png(fig), getattr(fig, "caption", "")
    return {
        "text/html": image_html(picture, getattr(fig, "alt", "") or caption),
        "image/png": picture,
        "text/plain": caption,
    }


def image_html(picture, alt, kind="image/png", width=None):
    """A picture as an ``<img>`` that holds its bytes and its alternative text.

    Front ends and exports ignore alternative text in the metadata of an output; this they show, and
    they show it in notebooks that are not trusted too.
    """
    data = base64.b64encode(picture).decode()
    size = "" if width is None else f' width="{width:g}"'
    return f'<img alt="{escape(alt)}"{size} src="data:{kind};base64,{data}">'


def save(fig, path, dpi=150):
    """Write the figure to a file; equal figures give equal files, without date or version."""
    suffix = str(path).rsplit(".", 1)[-1].lower()
    undated = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}
    with styled():
        fig.savefig(path, dpi=dpi, metadata=undated.get(suffix))
    return path
