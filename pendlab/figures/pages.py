"""Pages for sliders: several views of one design side by side, which move together.

Every function returns a figure as `live` makes it; frames stay as they were for the first design.
"""

import numpy as np

from ..loop import closed_loop_eigenvalues, sorted_eigenvalues
from ..paper.alignment import alignment_interval
from ..sampled import align
from ..studies.transmission import time_constant
from .frequency import LOOKS, decibels, draw_loops, draw_sigma_min, nyquist, sigma_min
from .outcomes import (
    gain_in_words,
    loops_in_words,
    loops_table,
    loops_verdict,
    rows_in_words,
    run_in_words,
    run_verdict,
    short,
)
from .picture import live
from .response import controller_gains, draw_gains, draw_step, step_response, step_words
from .rootlocus import draw_branches, draw_eigenvalues, root_locus
from .style import COLORS, new_figure, styled
from .traces import draw_traces

PAGE = 9.1  # inch: sharp beside the file browser on a screen of 1366 px
POINTS = 1500  # on each Nyquist curve
UNIT_DISK = (-0.2, 1.2), (-0.7, 0.7)  # frame of eigenvalues
# Titles, and square frames that hold those of Figs 8, 10, 11 and 12 near the critical point.
ONE_LOOP = [("$PG$", ((-2.5, 0.5), (-1.5, 1.5)))]
TWO_LOOPS = [
    ("loop 1: $rd_1-1$", ((-3.0, 0.5), (-1.75, 1.75))),
    ("loop 2: $rd_2-1$", ((-4.0, 0.5), (-2.25, 2.25))),
]
BOTH_LOOPS = r"both: $\det(I+PG)$, from 0", ((-2.0, 1.0), (-1.2, 1.8))


@styled()
def kp_page(design):
    """Fig 6 with moving eigenvalues, and what k_p makes of loop 2.

    Only k_p may change from design to design; branches and interval are computed once.
    """
    locus = root_locus(design.model, np.linspace(0, 100, 401), design.kp)
    low, high = alignment_interval(design.model)
    title, frame = TWO_LOOPS[1]

    def draw_locus(ax, eigenvalues, frame):
        draw_branches(ax, locus, COLORS["sky"])
        return draw_eigenvalues(ax, eigenvalues, frame)

    views = [
        ("eigenvalues with $k_p$ alone", draw_locus, ((0.84, 1.08), (-0.6, 0.6))),
        (title, draw_loops, LOOKS, frame),
        ("the same near $-1$", draw_loops, LOOKS, ((-1.25, -0.75), (-0.25, 0.25))),
    ]

    def compute(design):
        curves = loop_curves(design, 1)
        return sorted_eigenvalues(align(design.model, design.kp).A), curves, curves

    def say(data, design):
        eigenvalues, curves, _ = data
        lead = (
            f"k_p = {design.kp:.4g} V/rad alone leaves {np.sum(np.abs(eigenvalues) > 1)} of "
            f"{len(eigenvalues)} eigenvalues outside the unit circle; the fewest are left for {low:.2f} < k_p < "
            f"{high:.2f}. With {gain_in_words(design.F)}"
        )
        alt = (
            f"Eigenvalues in the z-plane on their root locus at k_p = {design.kp:.4g}, and two views "
            "of the loop gain at input 2, without and with filters."
        )
        return tell(design, lead, {2: curves}, alt)

    return page(views, compute, say, design, legend=(0, 1))


@styled()
def weights_page(design):
    """What Q and R make of a rig: every loop, eigenvalues, answer to a step."""
    views = [
        *_loop_views(design),
        ("eigenvalues, with filters", draw_eigenvalues, UNIT_DISK),
        ("step in the reference", draw_step, (-2.0, 2.0)),
    ]

    def compute(design):
        eigenvalues = closed_loop_eigenvalues(design.filtered_loop)
        return *_each_loop(design), eigenvalues, step_response(design)

    def say(data, design):
        *curves, _, response = data
        slowest = time_constant(design.nominal_loop)
        pace = f"Slowest time constant {slowest:.3g} s. " if slowest < np.inf else ""
        lead = f"{gain_in_words(design.F)} {pace}{step_words(response)}"
        alt = (
            "Nyquist curves without and with filters, closed-loop eigenvalues in the z-plane, and "
            "relative angles over logarithmic time after a step in the reference."
        )
        return tell(design, lead, dict(enumerate(curves, 1)), alt)

    return page(views, compute, say, design, legend=(-2, 0, -1))


@styled()
def observer_page(design):
    """What E and the choice in the null space make of a rig: loops, and the controller's gain."""
    view = "controller: readings to $u_1$", draw_gains, (0.1, 1e5)

    def compute(design):
        return *_each_loop(design), controller_gains(design.controller)

    def say(data, design):
        *curves, (hz, gains) = data
        o, q = design.observer, design.model.noutputs
        rows = rows_in_words(np.hstack([o.L1, o.L2])[q:])
        noise = o.noise_gain(design.F[:1, : design.model.nstates])
        lead = (
            f"Noise gain: white noise of 1 rad and 1 rad/s in the readings becomes {short(noise)} V at "
            f"motor 1. Estimating rows of [L1 L2]: {rows}. At {hz[-1]:g} Hz the controller "
            f"makes up to {short(gains[-1, :-1].max())} V of an angle of 1 rad."
        )
        alt = (
            "Nyquist curves without and with filters, and the controller's gain from each reading "
            "to the voltage of motor 1 over frequency."
        )
        return tell(design, lead, dict(enumerate(curves, 1)), alt)

    return page([*_loop_views(design), view], compute, say, design, legend=(0, -1))


@styled()
def triple_page(design, simulate):
    """Figs 10, 11, 12, 14 and a simulated run of the triple in one view.

    ``simulate(design)`` gives the `Run` that is shown.
    """
    fig = new_figure(PAGE, 4.1)
    grid = fig.add_gridspec(2, 4, height_ratios=(1.25, 1))
    near = [fig.add_subplot(grid[0, k]) for k in range(4)]
    angles, volts = fig.add_subplot(grid[1, :2]), fig.add_subplot(grid[1, 2:])
    title, frame = BOTH_LOOPS
    views = [
        *_loop_views(design),
        (title, draw_loops, LOOKS, frame),
        ("smallest singular value", draw_sigma_min, LOOKS, ((1e-2, 1e2), (-40, 10))),
        ("", draw_traces, "a", None, (-0.3, 0.3)),
        ("", draw_traces, "c", None, (-12, 12)),
        ("", draw_traces, "d", None, (-12, 12)),
    ]

    def compute(design):
        whole, run = (design.nominal_loop, design.filtered_loop), simulate(design)
        determinant = [nyquist(loop, POINTS) for loop in whole]
        sigma = [sigma_min(loop, 500) for loop in whole]
        return *_each_loop(design), determinant, sigma, run, run, run

    def draw(data):
        moves = draw_views([*near, angles, volts, volts], views, data)
        for ax in (angles, volts):
            ax.set_xlim(data[-1].t[[0, -1]])
        near[3].set_ylabel("dB")
        near[3].set_box_aspect(1)
        volts.set_ylabel("voltages, V")
        volts.legend(loc="upper right", ncols=2, handlelength=1.4)
        angles.set_title("on the bench", loc="left")
        near[0].lines[-1].set_label("critical point: −1, of the determinant 0")
        legend_below(fig, near[0])
        return moves

    def say(data, design):
        one, two, _, sigma, run, *_ = data
        lowest = [decibels(curve.lowest) for curve in sigma]
        last = (
            f"Both loops: smallest singular value {lowest[0]:.1f} dB without filters, "
            f"{lowest[1]:.1f} dB with. On the bench: {run_in_words(run)}"
        )
        alt = (
            "Six axes: Figs 10, 11, 12 and 14 without and with filters, and angles and voltages of "
            "a simulated run on the bench."
        )
        caption, alt, apart = tell(design, gain_in_words(design.F), {1: one, 2: two}, alt, last)
        (word, good), (on_bench, up) = apart["verdict"], run_verdict(run)
        return caption, alt, {**apart, "verdict": (f"{word}; on the bench {on_bench}", good and up)}

    return live(fig, draw, compute, say, design, ghosts=True)


# What the pages share


def page(views, compute, say, design, legend):
    """A live figure of square views side by side, each (title, draw, its arguments).

    `compute` gives the data of each view, `legend` are the views whose curves the legend names.
    """
    count = len(views)
    fig = new_figure(PAGE if count > 2 else 8.0, 2.95 if count == 4 else 3.5)
    axes = fig.subplots(1, count)
    for ax in axes:
        ax.set_box_aspect(1)

    def draw(data):
        moves = draw_views(axes, views, data)
        legend_below(fig, *(axes[k] for k in legend))
        return moves

    return live(fig, draw, compute, say, design, ghosts=True)


def draw_views(axes, views, data):
    """Each view in its axes, with its title; the moves of all."""
    moves = []
    for ax, part, (title, draw, *arguments) in zip(axes, data, views, strict=True):
        moves.append(draw(ax, part, *arguments))
        ax.set_title(title)
    return moves


def loop_curves(design, index):
    """One loop without and with filters."""
    return [nyquist(design.loop(index, filters), POINTS) for filters in (False, True)]


def _each_loop(design):
    """All loops that are broken at one input, without and with filters."""
    return [loop_curves(design, index) for index in range(design.rig.n_motors)]


def _loop_views(design):
    """A view of each loop."""
    frames = ONE_LOOP if design.rig.n_motors == 1 else TWO_LOOPS
    return [(title, draw_loops, LOOKS, frame) for title, frame in frames]


def tell(design, lead, loops, alt, last=""):
    """Caption, description, and what a panel tells apart: sentences, table of loops, verdict.

    `loops` are curves without and with filters by the number of their input. All of one design have
    the same closed loop, so the first one tells of it.
    """
    name = "Loop {}" if design.rig.n_motors > 1 else "The loop"
    lines = [loops_in_words(name.format(k), curves) for k, curves in loops.items()]
    around = [*filter(None, (lead, last))]
    apart = {
        "lead": "\n".join(around),
        "table": loops_table({str(k): curves for k, curves in loops.items()}),
        "verdict": loops_verdict(next(iter(loops.values()))),
    }
    return "\n".join([lead, *lines, *around[1:]]), alt, apart


def legend_below(fig, *axes):
    """One legend below the page in one row or two, each entry once; smaller labels."""
    for ax in fig.axes:
        ax.title.set_size(11)
        ax.tick_params(labelsize=9)
        ax.xaxis.label.set_size(10)
        ax.yaxis.label.set_size(10)
    entries = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            if label != "unit circle":
                entries.setdefault(label, handle)
    columns = len(entries) if len(entries) <= 8 else (len(entries) + 1) // 2
    fig.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns,
               handlelength=2.4, columnspacing=1.2, fontsize=9)  # fmt: skip
