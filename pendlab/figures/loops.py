"""The paper's computed figures: 6 to 8 and 10 to 14, from a design that can be changed.

Every function returns a `CaptionedFigure` with ``fig.update(design)``, which recomputes curves,
caption and description for another design and only changes the artists' data.
"""

from operator import attrgetter

import numpy as np

from .._arguments import found
from ..design import Design
from ..paper.designs import paper_design
from ..paper.ledger import published
from . import words
from .frequency import decibels, draw_nyquist, draw_sigma_min, nyquist, sigma_min
from .rootlocus import draw_root_locus, root_locus
from .style import look, new_figure, styled
from .turns import draw_contour, draw_turns, full_nyquist
from .updates import live

__all__ = ["fig6", "fig7", "fig8", "fig10", "fig11", "fig12", "fig13", "fig14", "turns_figure"]

WITHOUT = "without filters"
ZOOM = (0.42, 0.6, 0.28, 0.36), 0.12  # the inset of Fig 11


@styled()
def fig6(design=None, kps=None):
    """Fig 6: eigenvalues of A - B2 k_p C_p C, equation (19), over the gains `kps` (V/rad)."""
    design = _given(design, "triple")
    if design.kp is None:
        raise ValueError(
            "design: expected one with k_p to mark in Fig 6, found kp=None; "
            "use dataclasses.replace(design, kp=10.0)."
        )
    kps = np.linspace(*published("fig6.k_p_range").values, 201) if kps is None else kps
    frame = published("fig6.frame").values
    fig = new_figure(7, 4.6)

    def draw(data):
        return [draw_root_locus(fig.subplots(), data, frame)]

    def compute(design):
        return root_locus(design.model, kps, design.kp)

    return live(fig, draw, compute, words.words6, design)


@styled()
def fig7(design=None):
    """Fig 7: the full Nyquist curve of F (zI - A)^-1 B, turns counted."""
    design = _given(design, "double")
    return _turns(design, attrgetter("state_feedback_loop"), "Fig 7. F (zI - A)^-1 B")


@styled()
def fig13(design=None):
    """Fig 13: the full curve of det(I + P G), turns counted."""
    design = _two_motors(_given(design, "triple"), 13)
    return _turns(design, attrgetter("nominal_loop"), "Fig 13. det(I + P G)")


@styled()
def turns_figure(loop, name="The loop"):
    """The whole Nyquist curve of any sampled loop with its contour, turns counted (Figs 7, 13).

    The figure's ``update`` takes another loop; `name` begins the caption.
    """
    return _turns(loop, _itself, name)


def _turns(subject, loop_of, name):
    fig = new_figure(9, 5.95, layout=None)
    left, right = (fig.add_axes((x / 9, 1.3 / 5.95, 4.3 / 9, 4.3 / 5.95)) for x in (0.1, 4.6))

    def draw(data):
        return [draw_contour(left, data), draw_turns(right, data)]

    def compute(subject):
        return full_nyquist(loop_of(subject))

    def say(data, _):
        return words.words_turns(data, name)

    return live(fig, draw, compute, say, subject)


@styled()
def fig8(design=None, other=None):
    """Fig 8: loop gain at the input, nominal and with filters, near the critical point.

    `other` is a second design whose filtered loop is drawn dotted; without arguments the two
    observers of the paper are compared. ``fig.update(design, other)`` takes as many designs.
    """
    if design is None and other is None:
        other = paper_design("double", 2)
    designs = [_given(design, "double")]
    if other is not None:
        designs.append(_given(other, "double", "other"))
    looks = [look("nominal"), look("filters", label="observer 1, with filters"), look("observer2")]
    looks = looks[: 1 + len(designs)]

    def compute(*designs):
        loops = [design.loop(0, filters=True) for design in designs]
        return [nyquist(loop) for loop in (designs[0].loop(0), *loops)]

    def paper(*designs):
        known = all(words.is_papers(design, "double", i) for i, design in enumerate(designs, 1))
        return _printed(8, ("nominal", "observer1", "observer2")[: len(looks)]) if known else None

    return _near("8", compute, words.words8, looks, paper, *designs)


@styled()
def fig10(design=None):
    """Fig 10: rd1 - 1, equation (33), the loop broken at input 1, without and with filters."""
    design = _two_motors(_given(design, "triple"), 10)
    return _with_and_without("10", design, _broken_at_1, words.words10)


@styled()
def fig11(design=None):
    """Fig 11: rd2 - 1, equation (34), the loop broken at input 2, without and with filters."""
    design = _two_motors(_given(design, "triple"), 11)
    return _with_and_without("11", design, _broken_at_2, words.words11, ZOOM)


@styled()
def fig12(design=None):
    """Fig 12: det(I + P G), both loops broken, without and with filters."""
    design = _two_motors(_given(design, "triple"), 12)
    return _with_and_without("12", design, _whole, words.words12)


@styled()
def fig14(design=None):
    """Fig 14: smallest singular value of I + P G in dB over Hz, without and with filters."""
    design = _two_motors(_given(design, "triple"), 14)
    fig, frame = new_figure(7, 4.2), published("fig14.frame").values

    if not words.is_papers(design, "triple"):
        lowest = min(decibels(sigma_min(_whole(design, on)).lowest) for on in (False, True))
        frame = frame[0], (5 * np.floor(lowest / 5) - 5, frame[1][1])

    def draw(data):
        return [draw_sigma_min(fig.subplots(), data, _two_looks(), frame)]

    def compute(design):
        return [sigma_min(_whole(design, filters)) for filters in (False, True)]

    return live(fig, draw, compute, words.words14, design)


# What the figures share


def _near(number, compute, say, looks, paper, *designs, zoom=None):
    """A figure of Nyquist curves near the critical point, in the paper's frame, legend below."""
    data = compute(*designs)
    known = paper(*designs) is not None
    frame = published(f"fig{number}.frame").values if known else fitted(data)
    if zoom and min(curve.distance for curve in data) > zoom[1]:
        zoom = None  # an empty inset
    width, height = np.ptp(frame, axis=1)
    inch = min(6.0 / width, 4.5 / height)
    below = 0.12 * inch * height + 0.22 * (len(looks) + 3) + 0.1
    size = 7.0, inch * height + below + 0.15
    fig = new_figure(*size, layout=None)
    ax = fig.add_axes((0.8 / 7, below / size[1], inch * width / 7, inch * height / size[1]))

    def draw(data):
        redraw = draw_nyquist(ax, data[0], looks, frame, data[1], zoom)

        def move(data):
            redraw(*data)

        return [move]

    def both(*designs):
        return compute(*designs), paper(*designs)

    def speak(data, *designs):
        return say(data[0], *designs)

    return live(fig, draw, both, speak, *designs)


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


def _with_and_without(number, design, loop_of, say, zoom=None):
    """Figs 10 to 12: one loop without and with filters."""

    def compute(design):
        return [nyquist(loop_of(design, filters)) for filters in (False, True)]

    def paper(design):
        known = words.is_papers(design, "triple")
        return _printed(number, ("nominal", "filters")) if known else None

    return _near(number, compute, say, _two_looks(), paper, design, zoom=zoom)


def _itself(loop):
    return loop


def _broken_at_1(design, filters):
    return design.loop(0, filters)


def _broken_at_2(design, filters):
    return design.loop(1, filters)


def _whole(design, filters):
    return design.filtered_loop if filters else design.nominal_loop


def _two_looks():
    return [look("nominal", label=WITHOUT), look("filters")]


def _printed(number, curves):
    """The frequencies printed beside a figure's curves: (real axis, unit circle) in Hz for each."""
    known = {
        entry.key: float(entry.values) for entry in published() if ".frequencies." in entry.key
    }
    names = [f"fig{number}.frequencies.{curve}" for curve in curves]
    return [(known.get(f"{name}.lower"), known.get(f"{name}.upper")) for name in names]


def _given(design, name, argument="design"):
    if design is None:
        return paper_design(name)
    if not isinstance(design, Design):
        raise TypeError(
            f'{argument}: expected a pl.Design, {found(design)}; try pl.paper_design("{name}").'
        )
    return design


def _two_motors(design, number):
    if design.rig.n_motors < 2:
        raise ValueError(
            f"design: Fig {number} takes a rig with two motors or more, found {design.rig.n_motors}; "
            'try pl.paper_design("triple").'
        )
    return design
