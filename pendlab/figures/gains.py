"""The controller's gain over frequency, from each reading to the voltage of motor 1."""

from dataclasses import dataclass

import numpy as np

from ..loop import frequency_response
from .frequency import HZ
from .style import angle_name, look


@dataclass(frozen=True)
class ControllerGains:
    """|P| from each reading to u1.

    Attributes
    ----------
    hz : (N,)
    gains : (N, n + 1), V/rad from the n relative angles and V/(rad/s) from the lowest link's rate
    """

    hz: np.ndarray
    gains: np.ndarray

    @property
    def fastest(self):
        """Largest gain from an angle at half the sampling rate, V/rad."""
        return float(self.gains[-1, :-1].max())


def controller_gains(controller, points=200):
    """`ControllerGains` from 0.05 Hz to half the sampling rate."""
    hz = np.geomspace(0.05, 0.5 / controller.dt, points)
    return ControllerGains(hz, np.abs(frequency_response(controller.system, HZ * hz)[:, 0]))


def draw_gains(ax, data, frame):
    """Gains over frequency, both logarithmic; returns update(data) -> moved artists."""
    names = [angle_name(i + 1) for i in range(data.gains.shape[1] - 1)] + ["rate"]
    lines = [ax.plot([], [], **look(name))[0] for name in names]
    ax.set(xscale="log", yscale="log", xlim=data.hz[[0, -1]], ylim=frame)
    ax.set(xlabel="frequency, Hz", ylabel="gain, V/rad and V/(rad/s)")

    def update(data):
        for line, gain in zip(lines, data.gains.T, strict=True):
            line.set_data(data.hz, gain)
        return lines

    update(data)
    return update
