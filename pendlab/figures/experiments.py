"""The paper's Figs 15 to 17 from the bench: bands of an ensemble, one run, and the printed ticks."""

import numpy as np
from matplotlib.ticker import MultipleLocator

from .._arguments import found
from ..bench.simulation import Run
from ..paper.experiment import (
    FIGURES,
    bench_ensemble,
    signals,
    tick_hits,
    tick_intervals,
    window,
)
from ..paper.ledger import published
from .style import COLORS, describe, freeze_layout, look, new_figure, styled
from .traces import LABELS, draw_traces

PERCENTILES = (5, 95)


@styled()
def fig15(run=None):
    """Fig 15: the triple's transient, 0 to 7 s."""
    return _experiment("15", run, "the first seconds of the triple on the bench")


@styled()
def fig16(run=None):
    """Fig 16: the triple's steady operation, 30 to 37 s."""
    return _experiment("16", run, "the triple half a minute after its start")


@styled()
def fig17(run=None):
    """Fig 17: the double's steady operation, 10 to 18 s."""
    return _experiment("17", run, "the double after ten seconds")


def _experiment(number, run, what):
    """All panels of one figure: a given run, or the bench's ensemble and the first run of it."""
    name = next(name for name, (figures, _) in FIGURES.items() if number in figures)
    runs = bench_ensemble(name) if run is None else (run,)
    if not isinstance(runs[0], Run):
        raise TypeError(f"run: expected what pl.simulate returns, {found(run)}.")
    panels, expected = list(signals(runs[0])), [key[2] for key in _intervals(name, number)][::2]
    if panels != expected:
        raise ValueError(
            f"run: Fig {number} has panels {', '.join(expected)}, found a rig with "
            f"{runs[0].rig.n_motors} motors; simulate the paper's {name} pendulum."
        )
    fig = new_figure(9.5, 5.6)
    axes = fig.subplots(2, 2).ravel()
    for ax in axes[len(panels) :]:
        ax.set_visible(False)
    hits = tick_hits(name, runs)
    moves = [_panel(ax, runs, number, panel, hits) for ax, panel in zip(axes, panels, strict=False)]
    freeze_layout(fig)

    def update(*runs):
        for move in moves:
            move(runs[0])
        return describe(fig, *_words(number, name, what, runs))

    fig.update = update
    return update(*runs)


def _intervals(name, number):
    return {key: ends for key, ends in tick_intervals(name).items() if key.startswith(number)}


def _panel(ax, runs, number, panel, hits):
    """One panel in the paper's axes and ticks; returns what moves its run."""
    frame = {end: published(f"fig{number}{panel}.{end}_axis").values for end in "ty"}
    for end, axis in (("t", ax.xaxis), ("y", ax.yaxis)):
        step = float(published(f"fig{number}{panel}.{end}_tick").values)
        axis.set_major_locator(MultipleLocator(step))
    draw_ticks(ax, number, panel, hits)
    if len(runs) > 1:
        draw_band(ax, runs, number, panel)
    move = draw_traces(ax, runs[0], panel, frame["t"], frame["y"])
    ax.set_title(f"{number}{panel}", loc="left")
    return move


def draw_band(ax, runs, number, panel):
    """From 5 to 95 per cent of the runs, at each sample of the panel's time axis."""
    rows = [window(run, number, panel) & (run.t <= _last(runs)) for run in runs]
    for name in signals(runs[0])[panel]:
        traces = np.array([signals(run)[panel][name][row] for run, row in zip(runs, rows)])
        low, high = np.percentile(traces, PERCENTILES, axis=0)
        color = look(name)["color"]
        ax.fill_between(runs[0].t[rows[0]], low, high, color=color, alpha=0.22, linewidth=0)


def _last(runs):
    """The time up to which every run has samples, s."""
    return min(run.t[-1] for run in runs)


def draw_ticks(ax, number, panel, hits):
    """Shade the two intervals that bound a panel's extremes: hatched where most runs miss them."""
    for key, (low, high) in _intervals(_of(number), number).items():
        if key.startswith(number + panel):
            met = hits[key] >= 0.5
            ax.axhspan(low, high, color=COLORS["green" if met else "vermillion"], alpha=0.10,
                       hatch=None if met else "//", zorder=0)  # fmt: skip


def _of(number):
    return next(name for name, (figures, _) in FIGURES.items() if number in figures)


def _words(number, name, what, runs):
    if len(runs) == 1 and runs[0].fell:
        text = f"Fig {number}. It falls at {runs[0].fell_at:.2f} s."
        return text, text
    hits = tick_hits(name, runs)
    extremes = _intervals(name, number)
    missed = [key for key in extremes if hits[key] < 0.5]
    which = f"all but {', '.join(missed)}" if missed else "every one of them"
    many = len(runs) > 1
    verdict = (
        f"{len(extremes) - len(missed)} of the {len(extremes)} extremes lie within the tick that the "
        f"printed axes allow{' in at least half of the runs' if many else ''}: {which}"
    )
    shown = "5 to 95 % of the runs as bands, one of them as lines. " if many else ""
    return (
        f"Fig {number}. In simulation, {what}: {verdict}.",
        f"Panels over time in the paper's axes: {'; '.join(LABELS[p] for p in signals(runs[0]))}. "
        f"{shown}Shaded at the edges is where each extreme must lie; hatched, where it does not.",
    )
