"""What the kernel takes, from a rig and its imperfections; an inner step that fits the fastest motion."""

import math
from dataclasses import replace
from functools import lru_cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

from .._arguments import found, number
from ..lagrange import EquationsOfMotion
from .generated import load_kernel
from .tuples import Clock, Plant, Ports, State

LARGEST_STEP = 1e-3  # s
ACCURATE = 0.35  # step times fastest rate: the error of a Runge-Kutta step is then below 1e-4
STABLE = 2.0  # beyond 2.8 classical Runge-Kutta diverges
MOST_STEPS = 20_000_000  # of one run: some seconds
FAST_FILTER = 2e4  # 1/s: a filter that settles within 0.05 ms is taken as none


@lru_cache(maxsize=256)
def plant_numbers(rig, imperfections):
    """The `Plant` of `rig` as arrays, without pulses."""
    n, m, gaps = rig.n_links, rig.n_motors, imperfections.each("gap", rig.n_motors)
    for j, (gap, motor) in enumerate(zip(gaps, rig.motors), 1):
        if gap > 0 and motor.inertia <= 0:
            raise ValueError(
                f"gap: motor {j} has no rotor inertia to turn inside the gap; "
                "give Motor inertia a value above 0 or set its gap to 0."
            )
    # A rotor behind a gap turns by itself, so the links carry neither its inertia nor its damping.
    geared = [
        replace(motor, inertia=0.0, damping=0.0) if gap > 0 else motor
        for gap, motor in zip(gaps, rig.motors)
    ]
    kernel = load_kernel(n, m)
    c = np.zeros(kernel.CONSTANTS)
    kernel.constants(EquationsOfMotion.values(replace(rig, motors=tuple(geared))), c)
    motors = [(motor.gain, motor.damping, motor.inertia) for motor in rig.motors]
    names = ("contact_stiffness", "contact_damping", "gear_friction")
    gear = np.column_stack([motors, gaps / 2, *(imperfections.each(name, m) for name in names)])
    w_in, w_out = np.zeros(m), np.zeros(n + 1)
    if imperfections.filters:
        if rig.filters is None:
            raise ValueError(
                "filters: switched on, but rig.filters is None; give the rig pl.Filters."
            )
        w_in = 2 * np.pi * np.array(rig.filters.input_hz)
        w_out = 2 * np.pi * np.array(rig.filters.output_hz)
        for w in (w_in, w_out):
            w[w > FAST_FILTER] = 0.0
    dry, reach = imperfections.each("hinge_friction", n), float(imperfections.presliding)
    limit = np.array(rig.u_max) if imperfections.saturation else np.full(m, np.inf)
    gear, pulses = np.ascontiguousarray(gear), np.zeros((0, 4))
    return Plant(c, gear, dry, reach, w_in, w_out, limit, pulses)


class Bench(NamedTuple):
    """One run in the form that the kernel takes."""

    kernel: ModuleType
    state: State
    plant: Plant
    clock: Clock
    ports: Ports
    held: list  # torques on the links over each sample, N m, or one row for all
    work: list


def bench_tuples(rig, imperfections, x0, loads, clock, rows):
    """The `Bench` that starts at the relative angles and rates x0 under `loads` (pulses, held)."""
    kernel = load_kernel(rig.n_links, rig.n_motors)
    pulses, held = loads
    held = held + _start_torque(imperfections, kernel.N, clock.dt, rows)
    plant = plant_numbers(rig, imperfections)._replace(pulses=pulses)
    work = np.zeros((12, 3 * kernel.N + 2 * kernel.M + 1))
    state, ports = _state(x0, kernel.N, kernel.M), _ports(rig, imperfections, rows)
    parts = (state, plant, clock, ports, held, work)
    return Bench(kernel, *(pack(kernel, part) for part in parts))


def _state(x0, n, m):
    """At rest or moving, gears in the middle of their gaps, dry contacts without strain."""
    joints, rates = x0[1 : m + 1], x0[n + 1 : n + m + 1]
    x = np.concatenate([np.cumsum(x0[:n]), np.cumsum(x0[n:]), joints, rates, x0[: n + 1]])
    return State(x, np.concatenate([x0[:n], joints]), *(np.zeros(m) for _ in range(3)))


def _start_torque(imperfections, n, dt, rows):
    """Mean of the fading torques over each sample, N m; one row of zeros where there are none."""
    torque, decay = imperfections.each("start_torque", n), dt / imperfections.start_torque_time
    if not torque.any():
        return np.zeros((1, n))
    mean = -np.expm1(-decay) / decay * np.exp(-decay * np.arange(rows))
    return mean[:, None] * torque


def _ports(rig, imperfections, rows):
    n, m = rig.n_links, rig.n_motors
    noise = np.random.default_rng(imperfections.seed).standard_normal((rows, n + 1))
    with np.errstate(over="ignore"):  # `simulate` says so
        error = imperfections.each("offset", n + 1) + imperfections.each("noise", n + 1) * noise
    steps = imperfections.each("resolution", n + 1), imperfections.each("voltage_resolution", m)
    return Ports(error, *steps)


def pack(kernel, value):
    """Arrays as the kernel takes them: themselves where compiled, else as lists."""
    if kernel.COMPILED:
        return value
    if isinstance(value, tuple):
        return type(value)(*(pack(kernel, part) for part in value))
    return value.tolist() if isinstance(value, np.ndarray) else value


@lru_cache(maxsize=256)
def fastest_rate(rig, imperfections):
    """Largest |eigenvalue| (1/s) of the upright plant with gaps closed and dry joints holding."""
    n, m = rig.n_links, rig.n_motors
    kernel, plant = load_kernel(n, m), plant_numbers(rig, imperfections)
    size = 3 * n + 2 * m + 1
    gear = plant.gear
    strongest = np.where(np.isfinite(rig.u_max), rig.u_max, 10.0) * gear[:, 0]
    x0 = np.zeros(size)
    x0[2 * n : 2 * n + m] = gear[:, 3] + strongest / gear[:, 4]  # pressed by the full torque
    anchor = np.concatenate([np.zeros(n), np.where(gear[:, 3] > 0, x0[2 * n : 2 * n + m], 0.0)])

    def slope(x):
        dx, *zeros = (pack(kernel, np.zeros(count)) for count in (size, m, n, n, n))
        volts, load, torque, a = zeros
        kernel.derivative(
            pack(kernel, x), volts, load, pack(kernel, anchor), pack(kernel, plant), torque, a, dx
        )
        return np.array(dx)

    tiny = 1e-6 * min(1.0, imperfections.presliding / 1e-3)
    with np.errstate(over="ignore", invalid="ignore"):  # infinitely fast, then
        columns = [(slope(x0 + tiny * e) - slope(x0 - tiny * e)) / (2 * tiny) for e in np.eye(size)]
    if not np.isfinite(columns).all():
        return math.inf
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max(initial=plant.w_in.max()))


def integration(rig, imperfections, dt, rows, inner_step=None):
    """The `Clock` of a run of `rows` samples.

    ValueError for a delay above dt, and a step that is too coarse or so fine that no run would end.
    """
    delay = float(imperfections.delay)
    if delay > dt:
        raise ValueError(f"delay: expected at most the sampling time of {dt:g} s, {found(delay)}.")
    rate = fastest_rate(rig, imperfections)
    if inner_step is None:
        step = min(LARGEST_STEP, ACCURATE / rate, dt)
    else:
        step = number("inner_step", inner_step, above=0)
    if not step * MOST_STEPS >= rows * dt:
        raise ValueError(_too_fine(rate, rows * dt, inner_step))
    if inner_step is not None and step * rate > STABLE:
        raise ValueError(
            f"inner_step: {step:g} s is too coarse for the fastest motion of {rate:.4g} 1/s; "
            f"use at most {STABLE / rate:.2g} s, or leave it out."
        )
    late, rest = (math.ceil(span / step - 1e-9) for span in (delay, dt - delay))
    return Clock(dt, delay, late + rest, late, 0)


def _too_fine(rate, span, inner_step):
    most = f"a run takes at most {MOST_STEPS:,} steps of integration"
    if inner_step is not None:
        return (
            f"inner_step: {most}, found {inner_step:g} s over {span:g} s; "
            f"use at least {span / MOST_STEPS:.2g} s, a shorter t_end, or leave it out."
        )
    return (
        f"imperfections, dt: {most}, found a motion of {rate:.3g} 1/s over {span:g} s; take a softer "
        "contact, a larger presliding, less damping, or a shorter t_end."
    )
