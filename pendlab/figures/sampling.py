"""What sampling and filters do: eigenvalues in z, phase lag, and the loop that has to live with it."""

import numpy as np

from ..loop import sorted_eigenvalues
from .frequency import HZ, LOOKS, draw_loops, filter_lag
from .pages import ONE_LOOP, UNIT_DISK, loop_curves, page, tell
from .picture import follow
from .rootlocus import draw_eigenvalues
from .style import COLORS, styled


def lag(design, hz):
    """Phase lags in degrees at `hz`: of an input and an output filter in a row, of the hold."""
    return filter_lag(design.rig.filters, hz), 180 * hz * design.dt


@styled()
def sampling_page(design):
    """Eigenvalues of the sampled plant with filters, lags, and the loop of the redesigned double."""
    views = [
        ("plant with filters, $z$-plane", draw_eigenvalues, UNIT_DISK),
        ("what they cost in phase", draw_lag, ((0, 10), (0, 180))),
        ("loop designed without filters", draw_loops, LOOKS, ONE_LOOP[0][1]),
    ]

    def compute(design):
        curves = loop_curves(design, 0)
        crossover = max(curves[0].margins.crossover, default=np.nan) / HZ
        hz = np.linspace(0, 0.5 / design.dt, 400)
        lags = hz, *lag(design, hz), crossover
        return sorted_eigenvalues(design.filtered.A), lags, curves

    def say(data, design):
        _, (*_, crossover), curves = data
        unstable = sorted_eigenvalues(design.model.A)
        unstable = ", ".join(f"{z.real:.4f}" for z in unstable[np.abs(unstable) > 1])
        filters, hold = lag(design, crossover)
        lead = (
            f"Sampled every {1e3 * design.dt:.3g} ms the unstable eigenvalues are z = {unstable}. At "
            f"the crossover, {crossover:.3g} Hz, the filters lag by {filters:.1f}° and the hold "
            f"by {hold:.1f}°."
        )
        alt = (
            "Eigenvalues of the sampled plant with filters, phase lag of filters and hold over "
            "frequency with the crossover marked, and the loop gain without and with filters."
        )
        return tell(design, lead, {1: curves}, alt)

    return page(views, compute, say, design, legend=(0, 1, 2))


def draw_lag(ax, data, frame):
    """Lags of filters and of the hold over frequency with the crossover, Hz; as `follow`."""
    ax.set(xlim=frame[0], ylim=frame[1], xlabel="frequency, Hz", ylabel="lag, degrees")
    looks = [
        dict(color=COLORS["vermillion"], linestyle="--", label="lag of filters"),
        dict(color=COLORS["blue"], linestyle=":", label="lag of hold"),
        dict(color=COLORS["green"], label="lag of both"),
        dict(color=COLORS["grey"], linewidth=1.2, label="crossover"),
    ]

    def curves(data):
        hz, filters, hold, crossover = data
        return (hz, filters), (hz, hold), (hz, filters + hold), ([crossover] * 2, [0, 360])

    return follow(ax, looks, data, curves)
