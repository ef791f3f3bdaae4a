"""The controller's gain over frequency, and the loop's linear answer to a step in the reference."""

from dataclasses import dataclass

import numpy as np

from ..loop import frequency_response
from .frequency import HZ
from .outcomes import angle_in_words, short
from .picture import follow
from .sketch import zero_lines
from .style import angle_name, look


@dataclass(frozen=True)
class ControllerGains:
    """|P| from each reading to u1."""

    hz: np.ndarray  # (N,)
    gains: np.ndarray  # (N, n + 1): V/rad from the n angles, V/(rad/s) from the lowest link's rate

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
    ax.set(xscale="log", yscale="log", xlim=data.hz[[0, -1]], ylim=frame)
    ax.set(xlabel="frequency, Hz", ylabel="gain, V/rad and V/(rad/s)")

    def curves(data):
        return [(data.hz, gain) for gain in data.gains.T]

    return follow(ax, [look(name) for name in names], data, curves)


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

    @property
    def peak(self):
        """Largest voltage of each motor, V per rad of reference."""
        return np.abs(self.u).max(axis=0)


def step_response(design, filters=True, decades=6):
    """`StepResponse` of a design over 10^decades samples, with or without the rig's filters.

    x(n+1) = A x + B u, u and the controller's states from `Controller.system`, w with the reference
    of (15). Each decade advances with the tenth power of the last decade's matrix.
    """
    plant, c = design.filtered if filters else design.model, design.controller
    system = c.system
    state = np.append(np.zeros(plant.nstates + system.nstates), 1.0)  # [x; v; w; 1]
    to_u = np.hstack([system.D @ plant.C, system.C])
    first_w = len(state) - 1 - len(c.tracked)
    step = np.zeros((len(state), len(state)))
    step[: plant.nstates, :-1] = plant.B @ to_u
    step[: plant.nstates, : plant.nstates] += plant.A
    step[plant.nstates : -1, :-1] = np.hstack([system.B @ plant.C, system.A])
    step[first_w, -1], step[-1, -1] = c.dt, 1.0
    states, samples = [state], [0]
    with np.errstate(over="ignore", invalid="ignore"):  # of unstable loops
        for decade in range(1, decades):
            for _ in range(100 if decade == 1 else 90):
                states.append(step @ states[-1])
                samples.append(samples[-1] + 10 ** (decade - 1))
            step = np.linalg.matrix_power(step, 10)
    X = np.clip(np.nan_to_num(np.array(states)[:, :-1]), -1e6, 1e6)
    angles = X[:, : design.rig.n_links]  # the true ones: plant.C would read them through filters
    return StepResponse(c.dt * np.array(samples), angles, X @ to_u.T, c.tracked[0])


def draw_step(ax, data, frame):
    """Relative angles per reference over logarithmic time; returns update(data) -> moved artists."""
    ax.set(xscale="log", xlim=(data.t[1], data.t[-1]), ylim=frame)
    ax.set(xlabel="time after the step, s", ylabel="angle / reference")

    def curves(data):
        return [(data.t[1:], angle[1:]) for angle in data.angles.T]

    looks = [look(angle_name(i + 1)) for i in range(data.angles.shape[1])]
    update = follow(ax, looks, data, curves)
    ax.axhline(1, **look("reference"))
    zero_lines(ax, "x")
    return update


def step_words(data, step=0.1):
    """What a step of `step` rad does, as a sentence."""
    name = angle_in_words(data.tracked + 1)
    reached = f"reaches 90 % after {short(data.rise)} s" if data.rise else (
        f"is at {data.angles[-1, data.tracked]:.0%} after {data.t[-1]:.0f} s"
    )  # fmt: skip
    volts = ", ".join(f"{short(step * peak)} V" for peak in data.peak)
    return (
        f"Step of {step:g} rad: {name} {reached}, overshoot {data.overshoot:.0%}, "
        f"voltage up to {volts}."
    )
