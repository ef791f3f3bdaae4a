"""The paper's computed figures: 6 to 8 and 10 to 14, from a design that can be changed.

Every function returns a `CaptionedFigure` with ``fig.update(design)``, which recomputes curves,
caption and description for another design and only changes the artists' data.
"""

import numpy as np

from .._arguments import found
from ..design import Design
from ..paper.designs import paper_design
from ..paper.ledger import published
from . import words
from .frequency import draw_nyquist, draw_sigma_min, nyquist, sigma_min
from .rootlocus import draw_root_locus, root_locus
from .style import describe, freeze_layout, look, new_figure, styled
from .turns import draw_contour, draw_turns, full_nyquist

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
    draw = lambda data: draw_root_locus(fig.subplots(), data, frame)  # noqa: E731
    return _live(fig, draw, lambda d: root_locus(d.model, kps, d.kp), words.words6, design)


@styled()
def fig7(design=None):
    """Fig 7: the full Nyquist curve of F (zI - A)^-1 B, turns counted."""
    design = _given(design, "double")
    return _turns(design, lambda d: d.state_feedback_loop, "Fig 7. F (zI - A)^-1 B")


@styled()
def fig13(design=None):
    """Fig 13: the full curve of det(I + P G), turns counted."""
    design = _several(_given(design, "triple"), 13)
    return _turns(design, lambda d: d.nominal_loop, "Fig 13. det(I + P G)")


@styled()
def turns_figure(loop, name="The loop"):
    """The whole Nyquist curve of any sampled loop with its contour, turns counted (Figs 7, 13).

    The figure's ``update`` takes another loop; `name` begins the caption.
    """
    return _turns(loop, lambda loop: loop, name)


def _turns(subject, loop_of, name):
    fig = new_figure(9, 5.95, layout=None)
    left, right = (fig.add_axes((x / 9, 1.3 / 5.95, 4.3 / 9, 4.3 / 5.95)) for x in (0.1, 4.6))

    def draw(data):
        updates = draw_contour(left, data), draw_turns(right, data)
        return lambda data: [update(data) for update in updates]

    say = lambda data, _: words.words_turns(data, name)  # noqa: E731
    return _live(fig, draw, lambda s: full_nyquist(loop_of(s)), say, subject)


@styled()
def fig8(design=None, other=None):
    """Fig 8: loop gain at the input, nominal and with filters, near the critical point.

    `other` is a second design whose filtered loop is drawn dotted; without arguments the two
    observers of the paper are compared. ``fig.update(design, other)`` takes as many designs.
    """
    if design is None and other is None:
        other = paper_design("double", 2)
    designs = [_given(d, "double") for d in ((design,) if other is None else (design, other))]
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
    design = _several(_given(design, "triple"), 10)
    return _pair("10", design, lambda d, filters: d.loop(0, filters), words.words10)


@styled()
def fig11(design=None):
    """Fig 11: rd2 - 1, equation (34), the loop broken at input 2, without and with filters."""
    design = _several(_given(design, "triple"), 11)
    return _pair("11", design, lambda d, filters: d.loop(1, filters), words.words11, ZOOM)


@styled()
def fig12(design=None):
    """Fig 12: det(I + P G), both loops broken, without and with filters."""
    design = _several(_given(design, "triple"), 12)
    loop = lambda d, filters: d.filtered_loop if filters else d.nominal_loop  # noqa: E731
    return _pair("12", design, loop, words.words12)


@styled()
def fig14(design=None):
    """Fig 14: smallest singular value of I + P G in dB over Hz, without and with filters."""
    design = _several(_given(design, "triple"), 14)
    fig, frame = new_figure(7, 4.2), published("fig14.frame").values
    draw = lambda data: draw_sigma_min(fig.subplots(), data, _two_looks(), frame)  # noqa: E731
    compute = lambda d: [sigma_min(loop) for loop in (d.nominal_loop, d.filtered_loop)]  # noqa: E731
    return _live(fig, draw, compute, words.words14, design)


# What the figures share


def _live(fig, draw, compute, say, *designs):
    """Draw once, and give the figure its ``update(*designs)``."""
    data = compute(*designs)
    redraw = draw(data)
    freeze_layout(fig)

    def update(*designs, data=None):
        data = compute(*designs) if data is None else data
        redraw(data)
        return describe(fig, *say(data, *designs))

    fig.update = lambda *designs: update(*designs)
    return update(*designs, data=data)


def _near(number, compute, say, looks, paper, *designs, zoom=None):
    """A figure of Nyquist curves near the critical point, in the paper's frame, legend below."""
    frame = published(f"fig{number}.frame").values
    width, height = np.ptp(frame, axis=1)
    inch = min(6.0 / width, 4.5 / height)
    below = 0.12 * inch * height + 0.22 * (len(looks) + 3) + 0.1
    size = 7.0, inch * height + below + 0.15
    fig = new_figure(*size, layout=None)
    ax = fig.add_axes((0.8 / 7, below / size[1], inch * width / 7, inch * height / size[1]))

    def draw(pair):
        redraw = draw_nyquist(ax, pair[0], looks, frame, pair[1], zoom)
        return lambda pair: redraw(*pair)

    return _live(
        fig,
        draw,
        lambda *designs: (compute(*designs), paper(*designs)),
        lambda pair, *designs: say(pair[0], *designs),
        *designs,
    )


def _pair(number, design, loop_of, say, zoom=None):
    """Figs 10 to 12: one loop without and with filters."""
    compute = lambda d: [nyquist(loop_of(d, filters)) for filters in (False, True)]  # noqa: E731

    def paper(design):
        known = words.is_papers(design, "triple")
        return _printed(number, ("nominal", "filters")) if known else None

    return _near(number, compute, say, _two_looks(), paper, design, zoom=zoom)


def _two_looks():
    return [look("nominal", label=WITHOUT), look("filters")]


def _printed(number, curves):
    """The frequencies printed beside a figure's curves: (real axis, unit circle) in Hz for each."""
    known = {
        entry.key: float(entry.values) for entry in published() if ".frequencies." in entry.key
    }
    names = [f"fig{number}.frequencies.{curve}" for curve in curves]
    return [(known.get(f"{name}.lower"), known.get(f"{name}.upper")) for name in names]


def _given(design, name):
    if design is None:
        return paper_design(name)
    if not isinstance(design, Design):
        raise TypeError(
            f'design: expected a pl.Design, {found(design)}; try pl.paper_design("{name}").'
        )
    return design


def _several(design, number):
    if design.rig.n_motors < 2:
        raise ValueError(
            f"design: Fig {number} takes a rig with two motors or more, found {design.rig.n_motors}; "
            'try pl.paper_design("triple").'
        )
    return design
