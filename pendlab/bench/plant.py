"""Numbers that the compiled plant needs, and an inner step that fits its fastest motion."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..lagrange import parameter_values
from .generated import load_kernel

LARGEST_STEP = 1e-3  # s
ACCURATE = 0.35  # step times fastest rate: the error of a Runge-Kutta step is then below 1e-4
STABLE = 2.0  # beyond 2.8 classical Runge-Kutta diverges


class Plant(NamedTuple):
    """Settings of `kernel.advance`, in its order (arrays, or lists where nothing is compiled)."""

    c: list  # combined parameters of the equations of motion
    gear: list  # a row per motor: gain, damping, inertia, half gap, stiffness, impact, dry friction
    dry: list  # dry friction of the hinges, N m
    reach: float  # rad
    w_in: list  # filter rates, 1/s; 0: no filter
    w_out: list


@lru_cache(maxsize=256)
def plant_numbers(rig, imperfections):
    """The `Plant` of `rig` as arrays."""
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
    kernel.constants(parameter_values(replace(rig, motors=tuple(geared))), c)
    gear = np.column_stack(
        [
            [motor.gain for motor in rig.motors],
            [motor.damping for motor in rig.motors],
            [motor.inertia for motor in rig.motors],
            gaps / 2,
            imperfections.each("contact_stiffness", m),
            imperfections.each("contact_damping", m),
            imperfections.each("gear_friction", m),
        ]
    )
    w_in, w_out = np.zeros(m), np.zeros(n + 1)
    if imperfections.filters:
        if rig.filters is None:
            raise ValueError(
                "filters: switched on, but rig.filters is None; give the rig pl.Filters."
            )
        w_in = 2 * np.pi * np.array(rig.filters.input_hz)
        w_out = 2 * np.pi * np.array(rig.filters.output_hz)
    dry = imperfections.each("hinge_friction", n)
    return Plant(c, np.ascontiguousarray(gear), dry, imperfections.presliding, w_in, w_out)


def pack(kernel, value):
    """An array as the kernel takes it: itself where compiled, else as lists."""
    if isinstance(value, np.ndarray) and not kernel.COMPILED:
        return value.tolist()
    return value


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
    settings = [pack(kernel, value) for value in plant]
    c, gear, dry, reach, _, w_out = settings
    zeros = lambda count: pack(kernel, np.zeros(count))  # noqa: E731

    def slope(x):
        dx = zeros(size)
        kernel.derivative(
            pack(kernel, x),
            zeros(m),
            zeros(n),
            pack(kernel, anchor),
            c,
            gear,
            dry,
            reach,
            w_out,
            zeros(n),
            zeros(n),
            dx,
        )
        return np.array(dx)

    tiny = 1e-6 * min(1.0, imperfections.presliding / 1e-3)
    columns = [(slope(x0 + tiny * e) - slope(x0 - tiny * e)) / (2 * tiny) for e in np.eye(size)]
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())


def inner_steps(rig, imperfections, dt, inner_step=None):
    """(steps before the delay has passed, steps in all) of one sampling interval."""
    rate = fastest_rate(rig, imperfections)
    if inner_step is None:
        inner_step = min(LARGEST_STEP, ACCURATE / rate, dt)
    elif inner_step * rate > STABLE:
        raise ValueError(
            f"inner_step: {inner_step:g} s is too coarse for the fastest motion of {rate:.4g} 1/s; "
            f"use at most {STABLE / rate:.2g} s, or leave it out."
        )
    count = lambda duration: math.ceil(duration / inner_step - 1e-9)  # noqa: E731
    late = count(imperfections.delay)
    return late, late + count(dt - imperfections.delay)
