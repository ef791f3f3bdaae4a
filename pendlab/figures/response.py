"""The controller's gain over frequency, and the loop's linear answer to a step in the reference."""

from dataclasses import dataclass

import numpy as np

from ..loop import frequency_response
from .frequency import HZ
from .outcomes import angle_in_words, short
from .picture import follow
from .sketch import zero_lines
from .style import angle_name, look


def controller_gains(controller, points=200):
    """Frequencies (Hz) to half the sampling rate, and |P| there from each reading to u1.

    Gains are in V/rad from the angles, last in V/(rad/s) from the lowest link's rate.
    """
    hz = np.geomspace(0.05, 0.5 / controller.dt, points)
    return hz, np.abs(frequency_response(controller.system, HZ * hz)[:, 0])


def draw_gains(ax, data, frame):
    """Gains over frequency, both logarithmic; as `follow`."""
    hz, gains = data
    ax.set(xscale="log", yscale="log", xlim=hz[[0, -1]], ylim=frame)
    ax.set(xlabel="frequency, Hz", ylabel="gain, V/rad and V/(rad/s)")
    angles = [look(angle_name(i)) for i in range(1, gains.shape[1])]

    def curves(data):
        hz, gains = data
        return [(hz, gain) for gain in gains.T]

    return follow(ax, [*angles, look("rate", linestyle=":")], data, curves)


@dataclass(frozen=True)
class StepResponse:
    """Answer of the sampled linear loop to a reference of 1 rad, starting upright."""

    t: np.ndarray  # (N,) s, in each decade ten times coarser than in the last
    angles: np.ndarray  # (N, n) relative angles, rad per rad of reference
    u: np.ndarray  # (N, m) voltages, V per rad of reference
    tracked: int  # index of the angle that follows

    @property
    def rise(self):
        """First time at 90 % of the reference, s; None if not reached."""
        there = np.flatnonzero(self.angles[:, self.tracked] >= 0.9)
        return float(self.t[there[0]]) if len(there) else None

    @property
    def overshoot(self):
        """Largest excess over the reference, as a fraction of it."""
        return max(float(self.angles[:, self.tracked].max()) - 1, 0.0)


def step_response(design, decades=6):
    """`StepResponse` of a design with the rig's filters over 10^decades samples.

    x(n+1) = (A - B C) x(n) of the loop P G, w with the reference of (15). Each decade advances with
    the tenth power of the last decade's matrix.
    """
    loop, c = design.filtered_loop, design.controller
    step = np.eye(loop.nstates + 1)  # of the plant's states, v, w and a one
    step[:-1, :-1] = loop.A - loop.B @ loop.C
    step[-1 - len(c.tracked), -1] = c.dt
    states, samples = [np.eye(len(step))[-1]], [0]
    with np.errstate(over="ignore", invalid="ignore"):  # of unstable loops
        for decade in range(1, decades):
            for _ in range(100 if decade == 1 else 90):
                states.append(step @ states[-1])
                samples.append(samples[-1] + 10 ** (decade - 1))
            step = np.linalg.matrix_power(step, 10)
    X = np.clip(np.nan_to_num(np.array(states)[:, :-1]), -1e6, 1e6)
    angles = X[:, : design.rig.n_links]  # the true ones: the plant reads them through filters
    return StepResponse(c.dt * np.array(samples), angles, -X @ loop.C.T, c.tracked[0])


def draw_step(ax, data, frame):
    """Relative angles per reference over logarithmic time; as `follow`."""
    ax.set(xscale="log", xlim=(data.t[1], data.t[-1]), ylim=frame)
    ax.set(xlabel="time after the step, s", ylabel="angle / reference")

    def curves(data):
        return [(data.t[1:], angle[1:]) for angle in data.angles.T]

    looks = [look(angle_name(i + 1)) for i in range(len(data.angles.T))]
    update = follow(ax, looks, data, curves)
    ax.axhline(1, **look("reference"))
    zero_lines(ax, "x")
    return update


def step_words(data):
    """What a step of 0.1 rad does, as a sentence."""
    reached = f"is at {data.angles[-1, data.tracked]:.0%} after {data.t[-1]:.0f} s"
    if data.rise:
        reached = f"reaches 90 % after {short(data.rise)} s"
    volts = ", ".join(f"{short(0.1 * peak)} V" for peak in np.abs(data.u).max(axis=0))
    return (
        f"Step of 0.1 rad: {angle_in_words(data.tracked + 1)} {reached}, overshoot "
        f"{data.overshoot:.0%}, voltage up to {volts}."
    )
