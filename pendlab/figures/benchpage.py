"""A run on the bench for sliders: the traces of Figs 15 to 17 in frames that fit, and in words."""

import numpy as np

from .outcomes import run_in_words, run_table, run_verdict
from .style import look, new_figure, styled
from .traces import draw_traces, signals
from .updates import live

STEPS = (1, 2, 5)  # frames end at these times a power of ten, so that they seldom change


@styled()
def bench_page(run, window):
    """Traces of a run within `window` (s); ``fig.update(run, window)``, artists in ``fig.moving``."""
    fig = new_figure(6.2, 3.9, layout=None)
    panels = list(signals(run))
    grid = fig.add_gridspec(
        2, 2, left=0.085, right=0.985, top=0.93, bottom=0.19, wspace=0.24, hspace=0.45
    )
    axes = [fig.add_subplot(place) for place in (grid[0, 0], grid[0, 1], grid[1, 0], grid[1, 1])]
    if len(panels) == 3:
        axes.pop().remove()
        axes[2].set_subplotspec(grid[1, :])

    def compute(run, window):
        return run, window

    def draw(data):
        moves = [draw_traces(ax, run, panel, window) for ax, panel in zip(axes, panels)]
        axes[0].get_legend().remove()
        (wanted,) = axes[0].plot([], [], **look("reference"))
        _tidy(fig, axes)

        def update(data):
            run, window = data
            wanted.set_data(run.t, run.y_ref[:, 0])
            moved = [wanted]
            for ax, panel, move in zip(axes, panels, moves):
                moved += move(run)
                ax.set(xlim=window, ylim=frame(signals(run)[panel].values(), run.t, window))
            return moved

        return [update]

    def say(data, run, window):
        words = run_in_words(run, window[0])
        limit = run.saturated.max()
        at_limit = f" At the voltage limit for {limit:.1%} of the samples." if limit else ""
        apart = {
            "lead": f"{run_verdict(run)[0].capitalize()}.{at_limit}",
            "table": run_table(run, window[0]),
            "verdict": run_verdict(run),
        }
        return words, f"Angles, rate and voltages over time. {words}", apart

    return live(fig, draw, compute, say, run, window, ghosts=True)


def _tidy(fig, axes):
    """Names of the axes as titles, time below the lowest, one legend."""
    for ax in axes:
        ax.set_title(ax.get_ylabel(), fontsize=10, loc="left")
        ax.set_ylabel("")
        ax.tick_params(labelsize=9)
    for ax in axes[-2 if len(axes) == 4 else -1 :]:
        ax.set_xlabel("time, s", fontsize=10)
    for ax in axes[:2]:
        ax.set_xlabel("")
    fig.legend(
        *axes[0].get_legend_handles_labels(), loc="lower center", borderpad=0, ncols=6, fontsize=9
    )


def frame(traces, t, window):
    """Symmetric ends of a value axis: the least 1, 2 or 5 times a power of ten that holds all."""
    inside = (t >= window[0]) & (t <= window[1])
    largest = max((np.abs(trace[inside]).max(initial=0.0) for trace in traces), default=0.0)
    power = 10.0 ** np.floor(np.log10(max(largest, 1e-3)))
    end = next(step * power for step in (*STEPS, 10) if step * power >= largest * (1 - 1e-9))
    return -end, end
