"""The paper's Figs 15 to 17 from the bench: bands of an ensemble, one run, and the printed ticks."""

import numpy as np
from matplotlib.ticker import MultipleLocator

from ..paper.experiment import FIGURES, bench_ensemble, signals, tick_hits, tick_intervals, window
from ..paper.ledger import published
from .style import COLORS, describe, look, new_figure, styled
from .traces import LABELS, draw_traces

PERCENTILES = (5, 95)
SHOWS = {
    "15": "the first seconds of the triple on the bench",
    "16": "the triple half a minute after its start",
    "17": "the double after ten seconds",
}


@styled()
def experiment(number, run=None):
    """All panels of Fig 15, 16 or 17: a given run, or the bench's ensemble and its first run."""
    number = str(number)
    name = next(name for name, (figures, _) in FIGURES.items() if number in figures)
    ticks = {key: ends for key, ends in tick_intervals(name).items() if key.startswith(number)}
    runs = bench_ensemble(name) if run is None else (run,)
    panels, expected = list(signals(runs[0])), [key[2] for key in ticks][::2]
    if panels != expected:
        raise ValueError(
            f"run: Fig {number} has panels {', '.join(expected)}, found a rig with "
            f"{runs[0].rig.n_motors} motors; simulate the paper's {name} pendulum."
        )
    fig = new_figure(9.5, 5.6)
    axes = fig.subplots(2, 2).ravel()
    hits = tick_hits(name, runs)
    for ax in axes[len(panels) :]:
        ax.set_visible(False)
    for ax, panel in zip(axes, panels):
        _draw_ticks(ax, panel, ticks, hits)
        if len(runs) > 1:
            _draw_band(ax, runs, number, panel)
        _draw_run(ax, runs[0], number, panel)
    if len(runs) == 1 and runs[0].fell:
        text = f"Fig {number}. It falls at {runs[0].fell_at:.2f} s."
        return describe(fig, text, text)
    missed = [key for key in ticks if hits[key] < 0.5]
    which = f"all but {', '.join(missed)}" if missed else "every one of them"
    many = len(runs) > 1
    shown = "5 to 95 % of the runs as bands, one of them as lines. " if many else ""
    return describe(
        fig,
        f"Fig {number}. In simulation, {SHOWS[number]}: {len(ticks) - len(missed)} of the "
        f"{len(ticks)} extremes lie within the tick that the printed axes allow"
        f"{' in at least half of the runs' if many else ''}: {which}.",
        f"Panels over time in the paper's axes: {'; '.join(map(LABELS.get, panels))}. {shown}"
        "Shaded at the edges is where each extreme must lie; hatched, where it does not.",
    )


def _draw_run(ax, run, number, panel):
    """One run in the paper's axes and ticks."""
    ends = [published(f"fig{number}{panel}.{axis}_axis").values for axis in "ty"]
    for name, axis in (("t", ax.xaxis), ("y", ax.yaxis)):
        step = float(published(f"fig{number}{panel}.{name}_tick").values)
        axis.set_major_locator(MultipleLocator(step))
    ax.set_title(f"{number}{panel}", loc="left")
    draw_traces(ax, run, panel, *ends)


def _draw_band(ax, runs, number, panel):
    """From 5 to 95 per cent of the runs, at each sample of the panel's time axis."""
    last = min(run.t[-1] for run in runs)
    rows = [window(run, number, panel) & (run.t <= last) for run in runs]
    for name in signals(runs[0])[panel]:
        traces = np.array([signals(run)[panel][name][row] for run, row in zip(runs, rows)])
        low, high = np.percentile(traces, PERCENTILES, axis=0)
        color = look(name)["color"]
        ax.fill_between(runs[0].t[rows[0]], low, high, color=color, alpha=0.22, linewidth=0)


def _draw_ticks(ax, panel, ticks, hits):
    """Shade the two intervals that bound a panel's extremes: hatched where most runs miss them."""
    for key, (low, high) in ticks.items():
        if key[2] == panel:
            met = hits[key] >= 0.5
            ax.axhspan(low, high, color=COLORS["green" if met else "vermillion"], alpha=0.10,
                       hatch=None if met else "//", zorder=0)  # fmt: skip
