"""The paper's computed figures: 6 to 8 and 10 to 14, from a design that can be changed."""

import numpy as np

from .._arguments import instance
from ..design import Design
from ..paper.designs import paper_design
from ..paper.ledger import published
from . import words
from .frequency import HZ, LOOKS, decibels, draw_loops, draw_sigma_min, nyquist, sigma_min
from .rootlocus import draw_root_locus, root_locus
from .style import COLORS, describe, look, new_figure, styled
from .turns import draw_contour, draw_turns, full_nyquist

# The curves of Figs 8 and 10 to 12 as the ledger names them, and their looks.
CURVES_8 = {
    "nominal": look("nominal"),
    "observer1": look("filters", label="observer 1, with filters"),
    "observer2": look("observer2"),
}
CURVES = dict(zip(("nominal", "filters"), LOOKS))
BROKEN_AT = {8: 0, 10: 0, 11: 1}  # Fig -> input at which its loop is broken; in the others at all
INSET = (0.42, 0.6, 0.28, 0.36), ((-1.12, -0.88), (-0.12, 0.12))  # of Fig 11: place, frame


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
    data = root_locus(design.model, kps, design.kp)
    fig = new_figure(7, 4.6)
    draw_root_locus(fig.subplots(), data, published("fig6.frame").values)
    return describe(fig, *words.of_locus(data, design))


def whole_figure(number, design=None):
    """Figs 7 and 13: F (zI - A)^-1 B or det(I + P G) on the whole contour, turns counted."""
    design = _given(number, design)
    if number == 7:
        return turns_figure(design.state_feedback_loop, "Fig 7. F (zI - A)^-1 B")
    return turns_figure(design.nominal_loop, "Fig 13. det(I + P G)")


@styled()
def turns_figure(loop, name="The loop"):
    """The whole Nyquist curve of a sampled loop with its contour; `name` begins the caption."""
    fig, data = new_figure(9, 5.95, layout=None), full_nyquist(loop)
    left, right = (fig.add_axes((x / 9, 1.3 / 5.95, 4.3 / 9, 4.3 / 5.95)) for x in (0.1, 4.6))
    draw_contour(left, data)
    draw_turns(right, data)
    return describe(fig, *words.of_turns(data, name))


@styled()
def near_figure(number, design=None, other=None):
    """Figs 8 and 10 to 12 near the critical point, without filters and with them.

    The paper's frame and its printed frequencies are for its own designs, the legend is below. In
    Fig 8 `other` is a second design whose filtered loop is drawn dotted; without arguments the two
    observers of the paper are compared.
    """
    if number == 8 and design is None and other is None:
        other = paper_design("double", 2)
    designs = [_given(number, design)]
    if other is not None:
        designs.append(_given(number, other, "other"))
        if number != 8:
            raise TypeError(f"other: Fig {number} shows one design; try pl.figure(8, other=...).")
    loops = [_loop(number, designs[0], False), *(_loop(number, one, True) for one in designs)]
    curves = [nyquist(loop) for loop in loops]
    rig = "double" if number == 8 else "triple"
    papers = all(words.is_papers(design, rig, i) for i, design in enumerate(designs, 1))
    looks = [
        _told(style, _crossings(data, number, name if papers else None))
        for data, (name, style) in zip(curves, (CURVES_8 if number == 8 else CURVES).items())
    ]
    frame = published(f"fig{number}.frame").values if papers else fitted(curves)
    width, height = np.ptp(frame, axis=1)
    inch = min(6.0 / width, 4.5 / height)
    below = 0.12 * inch * height + 0.22 * (len(looks) + 3) + 0.1
    size = 7.0, inch * height + below + 0.15
    fig = new_figure(*size, layout=None)
    ax = fig.add_axes((0.8 / 7, below / size[1], inch * width / 7, inch * height / size[1]))
    draw_loops(ax, curves, looks, frame)
    if number == 11 and min(curve.distance for curve in curves) <= 0.12:  # something is to be seen
        inset = ax.inset_axes(INSET[0])
        draw_loops(inset, curves, looks, INSET[1])
        inset.set(xlabel="", ylabel="")
        inset.tick_params(labelsize=8)
        inset.set_title("near $-1$", fontsize=9, pad=3)
        ax.indicate_inset_zoom(inset, edgecolor=COLORS["grey"])
    meets = "▼ meets the real axis" + "   ● meets the unit circle" * (curves[0].critical == -1.0)
    ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.12), title=meets, frameon=False,
              title_fontsize=10, alignment="left")  # fmt: skip
    return describe(fig, *words.OF_FIGURE[number](curves, *designs))


@styled()
def sigma_figure(number, design=None):
    """Fig 14: smallest singular value of I + P G in dB over Hz, without and with filters."""
    design, frame = _given(number, design), published("fig14.frame").values
    curves = [sigma_min(_loop(number, design, filters)) for filters in (False, True)]
    lowest = [decibels(curve.lowest) for curve in curves]
    if not words.is_papers(design, "triple"):
        frame = frame[0], (5 * np.floor(min(lowest) / 5) - 5, frame[1][1])
    looks = [
        _told(style, f"lowest {low:.1f} dB at {data.lowest_omega / HZ:.2f} Hz")
        for style, low, data in zip(LOOKS, lowest, curves)
    ]
    fig = new_figure(7, 4.2)
    ax = fig.subplots()
    draw_sigma_min(ax, curves, looks, frame)
    ax.legend(loc="lower left")
    top = 0.5 / design.dt
    ax.text(0.96 * top, frame[1][0], f" Nyquist frequency {top:g} Hz", ha="right", va="bottom",
            rotation=90, fontsize=10, color=COLORS["grey"])  # fmt: skip
    return describe(fig, *words.of_sigma(curves, design))


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


def _told(style, words):
    return {**style, "label": f"{style['label']}: {words}"}


def _crossings(data, number, curve):
    """Where a curve is marked, beside what is printed for the paper's `curve` of that name."""
    head = f"fig{number}.frequencies.{curve}."
    printed = {e.key: float(e.values) for e in published() if e.key.startswith(head)}
    beside = [printed.get(head + end) for end in ("lower", "upper")]
    marks = [
        f"{sign} {omega / HZ:.2f} Hz" + ("" if paper is None else f" (paper {paper:.2f})")
        for sign, omega, paper in zip("▼●", data.marked_omega, beside)
        if np.isfinite(omega)
    ]
    return "   ".join(marks) or "no crossing"


def fitted(curves, reach=2.0):
    """A frame round what lies near the critical point, for curves that are not the paper's."""
    near = max(reach, *(1.5 * data.distance for data in curves))
    shown = [data.curve[np.abs(data.curve - data.critical) < near] for data in curves]
    marked = np.concatenate([data.marked for data in curves])
    marked = marked[np.abs(marked - curves[0].critical) < 2 * near]
    points = np.concatenate([*shown, marked, [curves[0].critical, 0.0]])
    frame = np.array([[np.min(x), np.max(x)] for x in (points.real, points.imag)])
    sizes = np.ptp(frame, axis=1)
    wider = 0.08 * sizes.max() + np.maximum(0, 0.8 * sizes.max() - sizes) / 2
    return frame + np.outer(wider, [-1, 1])
