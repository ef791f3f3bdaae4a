"""Traces of a simulated run over time, and the pushes that it survives."""

import numpy as np
from matplotlib.axes import Axes

from .._arguments import flag, instance
from ..bench.arguments import interval, mapping, one_of
from ..bench.simulation import Run
from ..paper.experiment import signals
from ..studies.pushes import Admissible
from .outcomes import limit_in_words, run_in_words, run_table, run_verdict
from .picture import follow, live
from .style import angle_name, describe, look, new_figure, styled

# Panel -> what it shows; the letters of the paper's figures in this order.
LABELS = {
    "a": "measured angles, rad",
    "b": "measured rate of link 1, rad/s",
    "c": "voltage of motor 1, V",
    "d": "voltage of motor 2, V",
}


def draw_traces(ax, run, panel, window=None, frame=None):
    """One panel of traces over time; ``update(run)`` moves them.

    Parameters
    ----------
    window, frame : (2,) ends of the time axis (s) and of the value axis; the run's own where None
    """
    instance("ax", ax, Axes, "pl.new_figure().subplots()")
    one_of("panel", panel, signals(run))
    names = list(signals(run)[panel])
    ax.set(xlabel="time, s", ylabel=LABELS[panel])
    if frame is not None:
        ax.set_ylim(interval("frame", frame))
    if window is not None:
        ax.set_xlim(interval("window", window))

    def traces(run):
        return [(run.t, trace) for trace in signals(run)[panel].values()]

    move = follow(ax, [look(name) for name in names], run, traces)
    ax.axhline(0, color="0.7", linewidth=0.8, zorder=0)

    def update(run):
        lines = move(run)
        ax.relim()
        ax.autoscale_view()  # of the axes that have no given ends
        return lines

    update(run)
    if len(names) > 1:
        # Above the frame, beside a title at the left, where it hides no trace.
        ax.legend(loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.1, ncols=len(names),
                  handlelength=1.6, columnspacing=1.0, frameon=False)  # fmt: skip
    return update


@styled()
def compare(runs, panel="a", window=None, frame=None, own_axes=False):
    """One row for each run, the same panel in all: what each imperfection does.

    Parameters
    ----------
    runs : dict, name -> Run
    panel : "a" angles, "b" rate of link 1, "c" and "d" voltages of the motors
    window, frame : (2,) ends of the axes; everything where None
    own_axes : each row fits its own values, so that a small motion is seen beside a large one
    """
    for name, run in mapping("runs", runs, '{"ideal": pl.simulate(...)}').items():
        instance(f"runs[{name!r}]", run, Run, "pl.simulate(...)")
    flag("own_axes", own_axes)
    fig = new_figure(9, max(2.4, 0.7 + 1.15 * len(runs)))
    axes = np.atleast_1d(fig.subplots(len(runs), 1, sharex=True, sharey=not own_axes))
    for ax, (name, run) in zip(axes, runs.items()):
        draw_traces(ax, run, panel, window, frame)
        ax.set(xlabel="", ylabel="")
        ax.set_title(name + (f": falls at {run.fell_at:.2f} s" if run.fell else ""), loc="left")
    most = max(axes, key=lambda ax: len(ax.lines))
    for ax in axes:
        if ax is not most and ax.get_legend():
            ax.get_legend().remove()
    axes[-1].set_xlabel("time, s")
    fig.supylabel(LABELS[panel])
    sizes = {name: _largest(run, panel, window, own_axes) for name, run in runs.items()}
    words = "; ".join(f"{name} {size}".strip() for name, size in sizes.items())
    caption = f"Largest value in each row, to one digit ({LABELS[panel]}): {words}."
    if own_axes:
        caption = f"Each row has its own axis ({LABELS[panel]})."
    alt = (
        f"{len(runs)} rows of traces over time with {'axes of their own' if own_axes else 'equal axes'}, "
        f"{LABELS[panel]}: {words}."
    )
    return describe(fig, caption, alt)


def _largest(run, panel, window, own_axes):
    """That it falls, or its largest value within a window; in a gap the motion is chaotic."""
    if run.fell or own_axes:
        return "falls" if run.fell else ""
    start, stop = (0, np.inf) if window is None else window
    within = (run.t >= start) & (run.t <= stop)
    traces = signals(run)[panel].values()
    return f"{max(np.abs(trace[within]).max(initial=0) for trace in traces):.1g}"


def _short(map_, ideal):
    """Impulses of the shortest pulse; with gears, whose motion is chaotic, only against `ideal`'s."""
    on = map_.imperfections
    if on is None or not (np.any(on.gap) or np.any(on.gear_friction)):
        return ", ".join(f"{1000 * i:.0f}" for i in map_.impulses[:, 0])
    if map_ is ideal or map_.heights.shape != ideal.heights.shape:
        return "see the curves"
    less = map_.heights[:, 0] < ideal.heights[:, 0]
    return "less on every link" if less.all() else "not less on every link"


@styled()
def pushes_figure(maps):
    """Admissible pulses over their length: one curve for each kind of push, one style for each map.

    Parameters
    ----------
    maps : dict, name -> `pendlab.pushes.Admissible`, all with the same lengths
    """
    for name, one in mapping("maps", maps, '{"ideal": pl.largest_pulses(...)}').items():
        instance(f"maps[{name!r}]", one, Admissible, "pl.largest_pulses(...)")
    if len(maps) > 4:
        raise ValueError(f"maps: at most 4 fit, found {len(maps)}.")
    fig = new_figure(8, 4.4)
    ax = fig.subplots()
    for style, (name, found_) in zip(("-", "--", ":", "-."), maps.items()):
        for i, heights in enumerate(found_.heights):
            # Curves that coincide are all seen: the lower link's is the broadest, underneath.
            broad = dict(linewidth=max(1.2, 4.5 - 1.5 * i), markersize=max(3, 9 - 2.5 * i))
            color, label = look(angle_name(i + 1))["color"], f"link {i + 1}, {name}"
            ax.loglog(1000 * found_.lengths, heights, style, marker="o", color=color, label=label,
                      **broad)  # fmt: skip
    ax.set(xlabel="length of the pulse, ms", ylabel="largest height recovered, N m (forces: N)")
    ax.legend(ncols=len(maps))
    first = next(iter(maps.values()))
    short = "; ".join(f"{name}: {_short(found_, first)}" for name, found_ in maps.items())
    return describe(
        fig,
        f"Impulse (height times length, mN m s, for forces mN s) of the shortest pulse on links 1 to "
        f"{len(found_.heights)} that is recovered: {short}.",
        "Largest recovered pulse height over pulse length on logarithmic axes; short pulses fall "
        f"on lines of equal impulse. {short}.",
    )


@styled()
def bench_page(run, window):
    """Traces of a run within `window` (s); ``fig.update(run, window)``, artists in ``fig.moving``."""
    fig = new_figure(6.2, 3.9, layout=None)
    place = dict(left=0.085, right=0.985, top=0.93, bottom=0.19, wspace=0.24, hspace=0.45)
    axes = fig.subplot_mosaic("ab;cd" if "d" in signals(run) else "ab;cc", gridspec_kw=place)

    def compute(run, window):
        return [(run, window)]

    def draw(data):
        moves = {panel: draw_traces(ax, run, panel, window) for panel, ax in axes.items()}
        axes["a"].get_legend().remove()
        (wanted,) = axes["a"].plot([], [], **look("reference"))
        for panel, ax in axes.items():
            ax.set_title(ax.get_ylabel(), fontsize=10, loc="left")
            ax.set_ylabel("")
            ax.set_xlabel("" if panel in "ab" else "time, s", fontsize=10)
            ax.tick_params(labelsize=9)
        handles = axes["a"].get_legend_handles_labels()
        fig.legend(*handles, loc="lower center", borderpad=0, ncols=6, fontsize=9)

        def update(data):
            run, window = data
            wanted.set_data(run.t, run.y_ref[:, 0])
            moved = [wanted]
            for panel, traces in signals(run).items():
                moved += moves[panel](run)
                axes[panel].set(xlim=window, ylim=frame(traces.values(), run.t, window))
            return moved

        return [update]

    def say(data, run, window):
        words, verdict = run_in_words(run, window[0]), run_verdict(run)
        apart = {
            "lead": f"{verdict[0].capitalize()}.{limit_in_words(run)}",
            "table": run_table(run, window[0]),
            "verdict": verdict,
        }
        return words, f"Angles, rate and voltages over time. {words}", apart

    return live(fig, draw, compute, say, run, window, ghosts=True)


def frame(traces, t, window):
    """Symmetric ends of a value axis: the least 1, 2 or 5 times a power of ten that holds all."""
    inside = (t >= window[0]) & (t <= window[1])
    largest = max((np.abs(trace[inside]).max(initial=0.0) for trace in traces), default=0.0)
    power = 10.0 ** np.floor(np.log10(max(largest, 1e-3)))
    # So few ends that they seldom change.
    end = next(step * power for step in (1, 2, 5, 10) if step * power >= largest * (1 - 1e-9))
    return -end, end
