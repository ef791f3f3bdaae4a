"""What sampling and filters do: eigenvalues in z, phase lag, and the loop that has to live with it."""

from dataclasses import dataclass

import numpy as np

from ..loop import sorted_eigenvalues
from .frequency import HZ, draw_loops
from .outcomes import loops_in_words
from .pages import LOOKS, ONE_LOOP, UNIT_DISK, legend_below, loop_curves, page, told_apart
from .rootlocus import draw_eigenvalues
from .style import COLORS, styled
from .updates import live, part


@dataclass(frozen=True)
class Lag:
    """Phase lag in degrees over frequency, up to half the sampling rate.

    Attributes
    ----------
    hz : (N,)
    filters : of one input and one output filter in a row
    hold : of the zero-order hold, half a sampling time
    crossover : where the loop without filters has gain one, Hz
    """

    hz: np.ndarray
    filters: np.ndarray
    hold: np.ndarray
    crossover: float

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

    fig, (plane, middle, near) = page(3)

    def compute(design):
        curves = loop_curves(design, 0)
        crossover = max(curves[0].margins.crossover, default=np.nan) / HZ
        return sorted_eigenvalues(design.filtered.A), lag(design, crossover), curves

    def draw(data):
        moves = [
            part(draw_eigenvalues(plane, data[0], UNIT_DISK), 0),
            part(draw_lag(middle, data[1], ((0, 10), (0, 180))), 1),
            part(draw_loops(near, data[2], LOOKS, ONE_LOOP[0][1:]), 2),
        ]
        plane.set_title("plant with filters, $z$-plane")
        middle.set_title("what they cost in phase")
        near.set_title("loop designed without filters")
        legend_below(fig, plane, middle, near)
        return moves

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
        return (
            f"{lead}\n{loops_in_words('The loop', curves)}",
            "Eigenvalues of the sampled plant with filters, phase lag of filters and hold over "
            "frequency with the crossover marked, and the loop gain without and with filters.",
            told_apart(lead, {"1": curves}),
        )

    return live(fig, draw, compute, say, design, ghosts=True)


def draw_lag(ax, data, frame):
    """Lags over frequency with the crossover; returns update(data) -> moved artists."""
    lines = [
        ax.plot([], [], color=COLORS[color], linestyle=line, label=label)[0]
        for color, line, label in (
            ("vermillion", "--", "lag of filters"),
            ("blue", ":", "lag of hold"),
            ("green", "-", "lag of both"),
        )
    ]
    (mark,) = ax.plot([], [], color=COLORS["grey"], linewidth=1.2, label="crossover")
    ax.set(xlim=frame[0], ylim=frame[1], xlabel="frequency, Hz", ylabel="lag, degrees")

    def update(data):
        both = data.filters + data.hold
        for line, values in zip(lines, (data.filters, data.hold, both), strict=True):
            line.set_data(data.hz, values)
        mark.set_data([data.crossover, data.crossover], [0, 360])
        return [*lines, mark]

    update(data)
    return update
