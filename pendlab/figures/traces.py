"""Traces of a simulated run, and the paper's Figs 15 to 17 from the explained bench.

Every panel can be moved: ``draw_...`` creates the artists once and returns ``update(run)``.
"""

import numpy as np

from .._arguments import found
from ..bench.simulation import Run
from ..paper.experiment import bench_run, fill, signals
from ..paper.ledger import published
from .style import angle_name, describe, freeze_layout, look, new_figure, styled

# Panel -> what it shows; the letters of the paper's figures in this order.
LABELS = {
    "a": "measured angles, rad",
    "b": "measured rate of link 1, rad/s",
    "c": "voltage of motor 1, V",
    "d": "voltage of motor 2, V",
}


@styled()
def fig15(run=None):
    """Fig 15: the triple's transient, 0 to 7 s."""
    return _experiment("15", "triple", run, "the first seconds of the triple on the bench")


@styled()
def fig16(run=None):
    """Fig 16: the triple's steady operation, 30 to 37 s."""
    return _experiment("16", "triple", run, "the triple half a minute after its start")


@styled()
def fig17(run=None):
    """Fig 17: the double's steady operation, 10 to 18 s."""
    return _experiment("17", "double", run, "the double after ten seconds")


def draw_traces(ax, run, panel, window=None, frame=None):
    """One panel of traces over time; ``update(run)`` moves them.

    Parameters
    ----------
    window, frame : (2,) ends of the time axis (s) and of the value axis; the run's own where None
    """
    lines = {name: ax.plot([], [], **look(name))[0] for name in signals(run)[panel]}
    ax.set(xlabel="time, s", ylabel=LABELS[panel])
    if frame is not None:
        ax.set_ylim(frame)
    if window is not None:
        ax.set_xlim(window)
    ax.axhline(0, color="0.7", linewidth=0.8, zorder=0)

    def update(run):
        for name, trace in signals(run)[panel].items():
            lines[name].set_data(run.t, trace)
        if frame is None or window is None:
            ax.relim()
            ax.autoscale_view(scalex=window is None, scaley=frame is None)
        return tuple(lines.values())

    update(run)
    if len(lines) > 1:
        # Above the frame, beside a title at the left, where it hides no trace.
        ax.legend(loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.1, ncols=len(lines),
                  handlelength=1.6, columnspacing=1.0, frameon=False)  # fmt: skip
    return update


@styled()
def compare(runs, panel="a", window=None, frame=None):
    """One row for each run, the same panel and axes in all: what each imperfection does.

    Parameters
    ----------
    runs : dict, name -> Run
    panel : "a" angles, "b" rate of link 1, "c" and "d" voltages of the motors
    window, frame : (2,) ends of the axes; everything where None
    """
    if not runs or not all(isinstance(run, Run) for run in runs.values()):
        raise TypeError(f"runs: expected a dict of names and runs of pl.simulate, {found(runs)}.")
    fig = new_figure(9, max(2.4, 0.7 + 1.15 * len(runs)))
    axes = np.atleast_1d(fig.subplots(len(runs), 1, sharex=True, sharey=True))
    for ax, (name, run) in zip(axes, runs.items()):
        draw_traces(ax, run, panel, window, frame)
        ax.set(xlabel="", ylabel="")
        ax.set_title(name + (f": falls at {run.fell_at:.2f} s" if run.fell else ""), loc="left")
        if ax is not axes[0] and ax.get_legend():
            ax.get_legend().remove()
    axes[-1].set_xlabel("time, s")
    fig.supylabel(LABELS[panel])
    start, stop = (0, np.inf) if window is None else window
    sizes = {}
    for name, run in runs.items():
        within = (run.t >= start) & (run.t <= stop)
        sizes[name] = max(np.abs(s[within]).max(initial=0) for s in signals(run)[panel].values())
    words = "; ".join(
        f"{name} {'falls' if runs[name].fell else format(size, '.3f')}"
        for name, size in sizes.items()
    )
    return describe(
        fig,
        f"Largest value in each row ({LABELS[panel]}): {words}.",
        f"{len(runs)} rows of traces over time with equal axes, {LABELS[panel]}: {words}.",
    )


@styled()
def pushes_figure(maps):
    """Admissible pulses over their length: one curve for each kind of push, one style for each map.

    Parameters
    ----------
    maps : dict, name -> `pendlab.pushes.Admissible`, all with the same lengths
    """
    fig = new_figure(8, 4.4)
    ax = fig.subplots()
    styles = ("-", "--", ":", "-.")
    for style, (name, found_) in zip(styles, maps.items()):
        for i, heights in enumerate(found_.heights):
            ax.loglog(
                1000 * found_.lengths,
                heights,
                style,
                marker="o",
                markersize=4,
                color=look(angle_name(i + 1))["color"],
                label=f"link {i + 1}, {name}",
            )
    ax.set(xlabel="length of the pulse, ms", ylabel="largest height recovered, N m (forces: N)")
    ax.legend(ncols=len(maps))
    short = "; ".join(
        f"{name}: " + ", ".join(f"{1000 * i:.0f}" for i in found_.impulses[:, 0])
        for name, found_ in maps.items()
    )
    return describe(
        fig,
        f"Impulse (height times length, mN m s, for forces mN s) of the shortest pulse on links 1 to "
        f"{len(found_.heights)} that is recovered: {short}.",
        "Largest recovered pulse height over pulse length on logarithmic axes; short pulses fall "
        f"on lines of equal impulse. {short}.",
    )


def _experiment(number, name, run, what):
    run = bench_run(name) if run is None else run
    if not isinstance(run, Run):
        raise TypeError(f"run: expected what pl.simulate returns, {found(run)}.")
    panels = list(signals(run))
    expected = [
        e.key[5] for e in published() if e.key.startswith(f"fig{number}") and "y_axis" in e.key
    ]
    if panels != expected:
        raise ValueError(
            f"run: Fig {number} has panels {', '.join(expected)}, found a rig with "
            f"{run.rig.n_motors} motors; simulate the paper's {name} pendulum."
        )
    fig = new_figure(9.5, 5.6)
    axes = fig.subplots(2, 2).ravel()
    for ax in axes[len(panels) :]:
        ax.set_visible(False)
    updates = [
        draw_traces(
            ax,
            run,
            panel,
            published(f"fig{number}{panel}.t_axis").values,
            published(f"fig{number}{panel}.y_axis").values,
        )
        for ax, panel in zip(axes, panels)
    ]
    for ax, panel in zip(axes, panels):
        ax.set_title(f"{number}{panel}", loc="left")
    freeze_layout(fig)

    def update(run):
        for move in updates:
            move(run)
        return describe(fig, *_words(number, what, run))

    fig.update = update
    return update(run)


def _words(number, what, run):
    if run.fell and run.fell_at < published(f"fig{number}a.t_axis").values[0]:
        text = f"Fig {number}. It falls at {run.fell_at:.2f} s, before these axes begin."
        return text, text
    filled = fill(run, number)
    outside = [p for p, (least, most, low, high, _) in filled.items() if least < low or most > high]
    amounts = "; ".join(
        f"{number}{p} {least:+.2f} to {most:+.2f} ({share:.0%} of the axis)"
        for p, (least, most, _, _, share) in filled.items()
    )
    verdict = (
        f"panels {', '.join(outside)} leave the paper's axes"
        if outside
        else "every panel stays inside the paper's axes"
    )
    fall = f" It falls at {run.fell_at:.2f} s." if run.fell else ""
    return (
        f"Fig {number}. In simulation, {what}: {verdict}.{fall} Ranges: {amounts}.",
        f"Panels over time in the paper's axes: {'; '.join(LABELS[p] for p in filled)}. {amounts}.",
    )
