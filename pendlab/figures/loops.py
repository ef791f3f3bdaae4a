"""The paper's computed figures: 6 to 8 and 10 to 14, from a design that can be changed.

Every function returns a `CaptionedFigure` with ``fig.update(design)``, which recomputes curves,
caption and description for another design and only changes the artists' data.
"""

from operator import attrgetter

import numpy as np

from .._arguments import instance
from ..design import Design
from ..paper.designs import paper_design
from ..paper.ledger import published
from . import words
from .frequency import decibels, draw_nyquist, draw_sigma_min, nyquist, sigma_min
from .picture import live
from .rootlocus import draw_root_locus, root_locus
from .style import look, new_figure, styled
from .turns import draw_contour, draw_turns, full_nyquist

LOOKS = [look("nominal", label="without filters"), look("filters")]
LOOKS_8 = [look("nominal"), look("filters", label="observer 1, with filters"), look("observer2")]
BROKEN_AT = {8: 0, 10: 0, 11: 1}  # Fig -> input at which its loop is broken; in the others at all
ZOOM = (0.42, 0.6, 0.28, 0.36), 0.12  # the inset of Fig 11


@styled()
def locus_figure(number, design=None, kps=None):
    """Fig 6: eigenvalues of A - B2 k_p C_p C, equation (19), over the gains `kps` (V/rad)."""
    design = _given(number, design)
    if design.kp is None:
        raise ValueError(
            "design: expected one with k_p to mark in Fig 6, found kp=None; "
            "use dataclasses.replace(design, kp=10.0)."
        )
    kps = np.linspace(*published("fig6.k_p_range").values, 201) if kps is None else kps
    fig = new_figure(7, 4.6)

    def draw(data):
        return [draw_root_locus(fig.subplots(), data, published("fig6.frame").values)]

    def compute(design):
        return root_locus(design.model, kps, design.kp)

    return live(fig, draw, compute, words.of_locus, design)


def whole_figure(number, design=None):
    """Figs 7 and 13: F (zI - A)^-1 B or det(I + P G) on the whole contour, turns counted."""
    name, loop = {
        7: ("F (zI - A)^-1 B", attrgetter("state_feedback_loop")),
        13: ("det(I + P G)", attrgetter("nominal_loop")),
    }[number]
    return turns_figure(_given(number, design), f"Fig {number}. {name}", loop)


@styled()
def turns_figure(subject, name="The loop", loop_of=None):
    """The whole Nyquist curve of a sampled loop with its contour, turns counted (Figs 7, 13).

    `name` begins the caption; `loop_of` gives the loop where the subject, also of ``fig.update``,
    is something else.
    """
    fig = new_figure(9, 5.95, layout=None)
    left, right = (fig.add_axes((x / 9, 1.3 / 5.95, 4.3 / 9, 4.3 / 5.95)) for x in (0.1, 4.6))

    def draw(data):
        return [draw_contour(left, data), draw_turns(right, data)]

    def compute(subject):
        return full_nyquist(subject if loop_of is None else loop_of(subject))

    def say(data, _):
        return words.of_turns(data, name)

    return live(fig, draw, compute, say, subject)


def observers_figure(number, design=None, other=None):
    """Fig 8: loop gain at the input, nominal and with filters, near the critical point.

    `other` is a second design whose filtered loop is drawn dotted; without arguments the two
    observers of the paper are compared. ``fig.update(design, other)`` takes as many designs.
    """
    if design is None and other is None:
        other = paper_design("double", 2)
    designs = [_given(number, design)]
    if other is not None:
        designs.append(_given(number, other, "other"))
    return near_figure(number, *designs)


@styled()
def near_figure(number, *designs):
    """Figs 8 and 10 to 12 near the critical point, without filters and with them for each design.

    The paper's frame and its printed frequencies are for its own designs, the legend is below.
    """
    designs = [_given(number, design) for design in designs or [None]]
    looks = (LOOKS_8 if number == 8 else LOOKS)[: 1 + len(designs)]
    data, printed = _near(number, *designs)
    frame = fitted(data) if printed is None else published(f"fig{number}.frame").values
    # An inset shows something only where a curve comes near.
    zoom = ZOOM if number == 11 and min(curve.distance for curve in data) <= ZOOM[1] else None
    width, height = np.ptp(frame, axis=1)
    inch = min(6.0 / width, 4.5 / height)
    below = 0.12 * inch * height + 0.22 * (len(looks) + 3) + 0.1
    size = 7.0, inch * height + below + 0.15
    fig = new_figure(*size, layout=None)
    ax = fig.add_axes((0.8 / 7, below / size[1], inch * width / 7, inch * height / size[1]))

    def draw(data):
        update = draw_nyquist(ax, data[0], looks, frame, data[1], zoom)
        return [lambda data: update(*data)]

    def compute(*designs):
        return _near(number, *designs)

    def say(data, *designs):
        return words.OF_FIGURE[number](data[0], *designs)

    return live(fig, draw, compute, say, *designs)


@styled()
def sigma_figure(number, design=None):
    """Fig 14: smallest singular value of I + P G in dB over Hz, without and with filters."""
    design = _given(number, design)
    fig, frame = new_figure(7, 4.2), published("fig14.frame").values

    def compute(design):
        return [sigma_min(_loop(number, design, filters)) for filters in (False, True)]

    if not words.is_papers(design, "triple"):
        lowest = min(decibels(curve.lowest) for curve in compute(design))
        frame = frame[0], (5 * np.floor(lowest / 5) - 5, frame[1][1])

    def draw(data):
        return [draw_sigma_min(fig.subplots(), data, LOOKS, frame)]

    return live(fig, draw, compute, words.of_sigma, design)


# What the figures share


def _given(number, design, argument="design"):
    """The paper's design, or one that has what the figure takes."""
    name = "double" if number in (7, 8) else "triple"
    if design is None:
        return paper_design(name)
    instance(argument, design, Design, f'pl.paper_design("{name}")')
    if number >= 10 and design.rig.n_motors < 2:
        raise ValueError(
            f"design: Fig {number} takes a rig with two motors or more, found {design.rig.n_motors}; "
            'try pl.paper_design("triple").'
        )
    return design


def _loop(number, design, filters):
    """The loop that a figure shows."""
    if number in BROKEN_AT:
        return design.loop(BROKEN_AT[number], filters)
    return design.filtered_loop if filters else design.nominal_loop


def _near(number, *designs):
    """Curves without filters and with them for each design; the printed frequencies, if any."""
    loops = [_loop(number, designs[0], False), *(_loop(number, one, True) for one in designs)]
    name = "double" if number == 8 else "triple"
    known = all(words.is_papers(design, name, i) for i, design in enumerate(designs, 1))
    return [nyquist(loop) for loop in loops], _printed(number, len(loops)) if known else None


def _printed(number, count):
    """The frequencies printed beside a figure's curves: (real axis, unit circle) in Hz for each."""
    head = f"fig{number}.frequencies."
    known = {e.key: float(e.values) for e in published() if e.key.startswith(head)}
    curves = ("nominal", "observer1", "observer2") if number == 8 else ("nominal", "filters")
    return [
        [known.get(f"{head}{curve}.{end}") for end in ("lower", "upper")]
        for curve in curves[:count]
    ]


def fitted(curves, reach=2.0):
    """A frame round what of the Nyquist curves lies near the critical point: the paper's frames
    are made for its own curves. Panels keep the frame with which they began."""
    near = max(reach, *(1.5 * data.distance for data in curves))
    shown = [data.curve[np.abs(data.curve - data.critical) < near] for data in curves]
    marked = np.concatenate([data.marked for data in curves])
    marked = marked[np.abs(marked - curves[0].critical) < 2 * near]
    points = np.concatenate([*shown, marked, [curves[0].critical, 0.0]])
    frame = np.array([[np.min(x), np.max(x)] for x in (points.real, points.imag)])
    sizes = np.ptp(frame, axis=1)
    wider = 0.08 * sizes.max() + np.maximum(0, 0.8 * sizes.max() - sizes) / 2
    return frame + np.outer(wider, [-1, 1])
