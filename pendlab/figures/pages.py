"""Pages for sliders: several views of one design side by side, which move together.

Every function returns a `CaptionedFigure`. Its ``update(design)`` computes before it draws, so that
a ValueError leaves the picture as it was; then it moves the artists listed in ``fig.moving`` inside
frames that stay, and renews caption and description.
"""

import numpy as np

from ..loop import closed_loop_eigenvalues, time_constant
from ..paper.alignment import alignment_interval
from ..paper.designs import paper_design
from .frequency import draw_loops, draw_sigma_min, nyquist, sigma_min
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
from .response import (
    controller_gains,
    draw_gains,
    draw_step,
    step_response,
    step_words,
)
from .rootlocus import draw_eigenvalues, draw_marked_locus, remarked, root_locus
from .style import look, new_figure, styled
from .traces import draw_traces
from .updates import live, part

PAGE = 9.1  # inch: sharp beside the file browser on a screen of 1366 px
POINTS = 1500  # on each Nyquist curve
LOOKS = [look("nominal", label="without filters"), look("filters")]
UNIT_DISK = (-0.2, 1.2), (-0.7, 0.7)  # frame of eigenvalues
# Square frames that hold those of Figs 8, 10, 11 and 12 near the critical point.
ONE_LOOP = [("$PG$", (-2.5, 0.5), (-1.5, 1.5))]
TWO_LOOPS = [
    ("loop 1: $rd_1-1$", (-3.0, 0.5), (-1.75, 1.75)),
    ("loop 2: $rd_2-1$", (-4.0, 0.5), (-2.25, 2.25)),
]
BOTH_LOOPS = (r"both: $\det(I+PG)$, from 0", (-2.0, 1.0), (-1.2, 1.8))


@styled()
def kp_page(design=None):
    """Fig 6 with moving eigenvalues, and what k_p makes of loop 2.

    Only k_p may change from design to design; branches and interval are computed once.
    """
    design = paper_design("triple") if design is None else design
    locus = root_locus(design.model, np.linspace(0, 100, 401), design.kp)
    low, high = alignment_interval(design.model)
    fig, (left, middle, right) = page(3)

    def compute(design):
        return remarked(locus, design.model, design.kp), loop_curves(design, 1)

    def draw(data):
        moves = [
            part(draw_marked_locus(left, data[0], ((0.84, 1.08), (-0.6, 0.6))), 0),
            part(_draw_loop(middle, data[1], *TWO_LOOPS[1]), 1),
            part(
                _draw_loop(right, data[1], "the same near $-1$", (-1.25, -0.75), (-0.25, 0.25)), 1
            ),
        ]
        left.set_title("eigenvalues with $k_p$ alone")
        legend_below(fig, left, middle)
        return moves

    def say(data, design):
        locus, curves = data
        lead = (
            f"k_p = {design.kp:.4g} V/rad alone leaves {locus.unstable} of {len(locus.marked)} "
            f"eigenvalues outside the unit circle; the fewest are left for {low:.2f} < k_p < "
            f"{high:.2f}. With {gain_in_words(design.F)}"
        )
        return (
            f"{lead}\n{loops_in_words('Loop 2', curves)}",
            f"Eigenvalues in the z-plane on their root locus at k_p = {design.kp:.4g}, and two views "
            "of the loop gain at input 2, without and with filters.",
            told_apart(lead, {"2": curves}),
        )

    return live(fig, draw, compute, say, design, ghosts=True)


@styled()
def weights_page(design):
    """What Q and R make of a rig: every loop, eigenvalues, answer to a step."""
    fig, (*near, plane, answer) = page(design.rig.n_motors + 2)

    def compute(design):
        eigenvalues = closed_loop_eigenvalues(design.filtered_loop)
        return *_each_loop(design), eigenvalues, step_response(design)

    def draw(data):
        moves = [
            *_draw_each_loop(near, data),
            part(draw_eigenvalues(plane, data[-2], UNIT_DISK), -2),
            part(draw_step(answer, data[-1], (-2.0, 2.0)), -1),
        ]
        plane.set_title("eigenvalues, with filters")
        answer.set_title("step in the reference")
        legend_below(fig, plane, near[0], answer)
        return moves

    def say(data, design):
        slowest = time_constant(design.nominal_loop)
        pace = f"Slowest time constant {slowest:.3g} s. " if slowest < np.inf else ""
        first = f"{gain_in_words(design.F)} {pace}{step_words(data[-1])}"
        return (
            "\n".join([first, *_loops_in_words(data, design)]),
            "Nyquist curves without and with filters, closed-loop eigenvalues in the z-plane, and "
            "relative angles over logarithmic time after a step in the reference.",
            told_apart(first, _named_loops(data, design)),
        )

    return live(fig, draw, compute, say, design, ghosts=True)


@styled()
def observer_page(design):
    """What E and the choice in the null space make of a rig: loops, and the controller's gain."""
    fig, (*near, gains) = page(design.rig.n_motors + 1)

    def compute(design):
        return *_each_loop(design), controller_gains(design.controller)

    def draw(data):
        moves = [*_draw_each_loop(near, data), part(draw_gains(gains, data[-1], (0.1, 1e5)), -1)]
        gains.set_title("controller: readings to $u_1$")
        legend_below(fig, near[0], gains)
        return moves

    def say(data, design):
        o, q = design.observer, design.model.noutputs
        rows = rows_in_words(np.hstack([o.L1, o.L2])[q:])
        noise = o.noise_gain(design.F[:1, : design.model.nstates])
        first = (
            f"Noise gain: white noise of 1 rad and 1 rad/s in the readings becomes {short(noise)} V at "
            f"motor 1. Estimating rows of [L1 L2]: {rows}. At {0.5 / design.dt:g} Hz the controller "
            f"makes {short(data[-1].fastest)} V of an angle of 1 rad."
        )
        return (
            "\n".join([first, *_loops_in_words(data, design)]),
            "Nyquist curves without and with filters, and the controller's gain from each reading "
            "to the voltage of motor 1 over frequency.",
            told_apart(first, _named_loops(data, design)),
        )

    return live(fig, draw, compute, say, design, ghosts=True)


@styled()
def triple_page(design, simulate):
    """Figs 10, 11, 12, 14 and a simulated run of the triple in one view.

    ``simulate(design)`` gives the `Run` that is shown.
    """
    fig = new_figure(PAGE, 4.1)
    grid = fig.add_gridspec(2, 4, height_ratios=(1.25, 1))
    near = [fig.add_subplot(grid[0, k]) for k in range(4)]
    angles, volts = fig.add_subplot(grid[1, :2]), fig.add_subplot(grid[1, 2:])

    def compute(design):
        whole = design.nominal_loop, design.filtered_loop
        return (
            *_each_loop(design),
            [nyquist(loop, POINTS) for loop in whole],
            [sigma_min(loop, 500) for loop in whole],
            simulate(design),
        )

    def draw(data):
        run, window = data[-1], data[-1].t[[0, -1]]
        moves = [
            *_draw_each_loop(near, data),
            part(_draw_loop(near[2], data[2], *BOTH_LOOPS), 2),
            part(
                draw_sigma_min(near[3], data[3], LOOKS, ((1e-2, 1e2), (-40, 10)), listed=False), 3
            ),
            part(draw_traces(angles, run, "a", window, (-0.3, 0.3)), 4),
            part(draw_traces(volts, run, "c", window, (-12, 12)), 4),
            part(draw_traces(volts, run, "d", window, (-12, 12)), 4),
        ]
        near[3].set(title="smallest singular value", ylabel="dB")
        near[3].set_box_aspect(1)
        volts.set_ylabel("voltages, V")
        volts.legend(loc="upper right", ncols=2, handlelength=1.4)
        angles.set_title("on the bench", loc="left")
        near[0].lines[-1].set_label("critical point: −1, of the determinant 0")
        legend_below(fig, near[0])
        return moves

    def say(data, design):
        lowest = [20 * np.log10(curve.lowest) for curve in data[3]]
        last = (
            f"Both loops: smallest singular value {lowest[0]:.1f} dB without filters, "
            f"{lowest[1]:.1f} dB with. On the bench: {run_in_words(data[4])}"
        )
        apart = told_apart(f"{gain_in_words(design.F)}\n{last}", _named_loops(data, design))
        word, good = apart["verdict"]
        on_bench, up = run_verdict(data[4])
        return (
            "\n".join([gain_in_words(design.F), *_loops_in_words(data, design), last]),
            "Six axes: Figs 10, 11, 12 and 14 without and with filters, and angles and voltages of "
            "a simulated run on the bench.",
            {**apart, "verdict": (f"{word}; on the bench {on_bench}", good and up)},
        )

    return live(fig, draw, compute, say, design, ghosts=True)


# What the pages share


def loop_curves(design, index):
    """One loop without and with filters."""
    return [nyquist(design.loop(index, filters), POINTS) for filters in (False, True)]


def _each_loop(design):
    """All loops that are broken at one input, without and with filters."""
    return [loop_curves(design, index) for index in range(design.rig.n_motors)]


def page(count):
    fig = new_figure(PAGE if count > 2 else 8.0, 2.95 if count == 4 else 3.5)
    axes = fig.subplots(1, count)
    for ax in axes:
        ax.set_box_aspect(1)
    return fig, axes


def _draw_loop(ax, curves, title, x, y):
    ax.set_title(title)
    return draw_loops(ax, curves, LOOKS, (x, y))


def _draw_each_loop(axes, data):
    frames = ONE_LOOP if len(axes) == 1 else TWO_LOOPS
    return [
        part(_draw_loop(ax, data[k], *frame), k) for k, (ax, frame) in enumerate(zip(axes, frames))
    ]


def _loops_in_words(data, design):
    several = design.rig.n_motors > 1
    return [
        loops_in_words(f"Loop {k + 1}" if several else "The loop", data[k])
        for k in range(design.rig.n_motors)
    ]


def _named_loops(data, design):
    return {str(k + 1): data[k] for k in range(design.rig.n_motors)}


def told_apart(lead, loops):
    """What a panel tells apart: sentences, table of the loops, verdict of the closed loop.

    All loops of one design have the same closed loop, so the first one tells of it.
    """
    first = next(iter(loops.values()))
    return {"lead": lead, "table": loops_table(loops), "verdict": loops_verdict(first)}


def _small(fig):
    for ax in fig.axes:
        ax.title.set_size(11)
        ax.tick_params(labelsize=9)
        ax.xaxis.label.set_size(10)
        ax.yaxis.label.set_size(10)


def legend_below(fig, *axes):
    """One legend below the page in one row or two, each entry once; smaller labels."""
    _small(fig)
    entries = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            if label != "unit circle":
                entries.setdefault(label, handle)
    columns = len(entries) if len(entries) <= 8 else (len(entries) + 1) // 2
    fig.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns,
               handlelength=1.5, columnspacing=1.4, fontsize=9)  # fmt: skip
