"""A run on the bench for sliders: the traces of Figs 15 to 17 in frames that fit, and in words."""

import numpy as np

from .outcomes import limit_in_words, run_in_words, run_table, run_verdict
from .style import look, new_figure, styled
from .traces import draw_traces, signals
from .updates import live


@styled()
def bench_page(run, window):
    """Traces of a run within `window` (s); ``fig.update(run, window)``, artists in ``fig.moving``."""
    fig = new_figure(6.2, 3.9, layout=None)
    place = dict(left=0.085, right=0.985, top=0.93, bottom=0.19, wspace=0.24, hspace=0.45)
    axes = fig.subplot_mosaic("ab;cd" if "d" in signals(run) else "ab;cc", gridspec_kw=place)

    def compute(run, window):
        return run, window

    def draw(data):
        moves = {panel: draw_traces(ax, run, panel, window) for panel, ax in axes.items()}
        axes["a"].get_legend().remove()
        (wanted,) = axes["a"].plot([], [], **look("reference"))
        _tidy(fig, axes)

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


def _tidy(fig, axes):
    """Names of the axes as titles, time below the lowest, one legend."""
    for panel, ax in axes.items():
        ax.set_title(ax.get_ylabel(), fontsize=10, loc="left")
        ax.set_ylabel("")
        ax.set_xlabel("" if panel in "ab" else "time, s", fontsize=10)
        ax.tick_params(labelsize=9)
    handles = axes["a"].get_legend_handles_labels()
    fig.legend(*handles, loc="lower center", borderpad=0, ncols=6, fontsize=9)


def frame(traces, t, window):
    """Symmetric ends of a value axis: the least 1, 2 or 5 times a power of ten that holds all."""
    inside = (t >= window[0]) & (t <= window[1])
    largest = max((np.abs(trace[inside]).max(initial=0.0) for trace in traces), default=0.0)
    power = 10.0 ** np.floor(np.log10(max(largest, 1e-3)))
    # So few ends that they seldom change.
    end = next(step * power for step in (1, 2, 5, 10) if step * power >= largest * (1 - 1e-9))
    return -end, end
