"""What sampling and filters do: eigenvalues in z, phase lag, and the loop that has to live with it."""

from dataclasses import dataclass

import numpy as np

from ..loop import sorted_eigenvalues
from .frequency import HZ, draw_loops
from .pages import LOOKS, ONE_LOOP, UNIT_DISK, loop_curves, page, tell
from .picture import follow
from .rootlocus import draw_eigenvalues
from .style import COLORS, styled


@dataclass(frozen=True)
class Lag:
    """Phase lag in degrees over frequency, up to half the sampling rate."""

    hz: np.ndarray  # (N,)
    filters: np.ndarray  # of one input and one output filter in a row
    hold: np.ndarray  # of the zero-order hold, half a sampling time
    crossover: float  # where the loop without filters has gain one, Hz

    def at(self, hz):
        """(filters, hold) at a frequency."""
        return np.interp(hz, self.hz, self.filters), np.interp(hz, self.hz, self.hold)


def lag(design, crossover):
    """`Lag` of a design's filters and sampling."""
    hz = np.linspace(0, 0.5 / design.dt, 400)
    cuts = design.rig.filters.input_hz[0], design.rig.filters.output_hz[0]
    filters = sum(np.degrees(np.arctan(hz / cut)) for cut in cuts)
    return Lag(hz, filters, 180 * hz * design.dt, crossover)


@styled()
def sampling_page(design):
    """Eigenvalues of the sampled plant with filters, lags, and the loop of the redesigned double."""
    views = [
        ("plant with filters, $z$-plane", 0, draw_eigenvalues, UNIT_DISK),
        ("what they cost in phase", 1, draw_lag, ((0, 10), (0, 180))),
        ("loop designed without filters", 2, draw_loops, LOOKS, ONE_LOOP[0][1]),
    ]

    def compute(design):
        curves = loop_curves(design, 0)
        crossover = max(curves[0].margins.crossover, default=np.nan) / HZ
        return sorted_eigenvalues(design.filtered.A), lag(design, crossover), curves

    def say(data, design):
        _, lag, curves = data
        unstable = sorted_eigenvalues(design.model.A)
        unstable = ", ".join(f"{z.real:.4f}" for z in unstable[np.abs(unstable) > 1])
        filters, hold = lag.at(lag.crossover)
        lead = (
            f"Sampled every {1e3 * design.dt:.3g} ms the unstable eigenvalues are z = {unstable}. At "
            f"the crossover, {lag.crossover:.3g} Hz, the filters lag by {filters:.1f}° and the hold "
            f"by {hold:.1f}°."
        )
        alt = (
            "Eigenvalues of the sampled plant with filters, phase lag of filters and hold over "
            "frequency with the crossover marked, and the loop gain without and with filters."
        )
        return tell(design, lead, {"1": curves}, alt)

    return page(views, compute, say, design, legend=(0, 1, 2))


def draw_lag(ax, data, frame):
    """Lags over frequency with the crossover; returns update(data) -> moved artists."""
    ax.set(xlim=frame[0], ylim=frame[1], xlabel="frequency, Hz", ylabel="lag, degrees")
    looks = [
        dict(color=COLORS["vermillion"], linestyle="--", label="lag of filters"),
        dict(color=COLORS["blue"], linestyle=":", label="lag of hold"),
        dict(color=COLORS["green"], label="lag of both"),
        dict(color=COLORS["grey"], linewidth=1.2, label="crossover"),
    ]

    def curves(data):
        lags = data.filters, data.hold, data.filters + data.hold
        return [*((data.hz, one) for one in lags), ([data.crossover] * 2, [0, 360])]

    return follow(ax, looks, data, curves)
