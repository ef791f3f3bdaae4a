"""Homework 1: sampling period and filters of one's own."""

from dataclasses import replace

import control
import numpy as np

import pendlab as pl

from ..._arguments import number
from . import acceptance
from .judging import asks, not_callable

RIG = dict(base="triple", who="your name")
PASS = 1e-3  # s, the paper's steps 1 to 6 for the triple
LOAD, HUM_HZ, HUM, HUM_VOLTS, LOWEST, MARGIN = 0.2, 50.0, 1e-3, 1.0, 5.0, 0.25
CROSSOVER = 2.5  # Hz
FURTHER, LASTING, REST = 1.05, 6.0, 0.05  # s, rad: the lean and the period to within 5 %
SMOOTHING = 3  # factor by which the motors' filters weaken the sampling frequency
WEAKENED = 1.5  # factor by which each sensor's filter weakens the hum


@asks("delays", apart=True)
def exercise_1(rig):
    """Delays of hold, motor 2's filter and the filter of theta3 - theta2, s."""
    hold = acceptance.reference(rig).dt / 2
    cuts = np.array([rig.filters.input_hz[1], rig.filters.output_hz[2]])
    truth = np.array([hold, *(1 / (2 * np.pi * cuts))])
    yield truth, f"Now count them in degrees at {CROSSOVER:g} Hz."
    mean = "The hold delays by less than a whole period: think of the staircase's mean."
    yield [2 * hold, *truth[1:]], mean
    hertz = "The cut-offs are in hertz; arctan(w/w_c) needs rad/s for both."
    yield [hold, *(1 / cuts)], hertz
    yield [2 * hold, *(1 / cuts)], "Two things: the hold's mean delay, and hertz against rad/s."
    yield truth[[0, 2, 1]], "Motor filter before sensor filter, please."


def exercise_2(alias, rig):
    """A function that tells where a frequency turns up."""
    yield not_callable(alias, "your function alias(f, dt)")
    cases = [(3, 0.01), (50, 0.02), (50, 0.01), (97, 0.01), (60, 0.01), (130, 0.008), (460, 0.005)]
    for f, dt in cases:
        found = number("alias(f, dt)", np.asarray(alias(f, dt)).item())
        said = f"At {f} Hz and dt = {dt} s you say {found:.4g} Hz"
        # What a sampled cosine of f looks like decides, not a formula.
        n = np.arange(64)
        same = np.cos(2 * np.pi * f * n * dt) - np.cos(2 * np.pi * found * n * dt)
        if not -1e-9 <= found <= 0.5 / dt + 1e-9:
            yield f"{said}; an alias lies from 0 to half the sampling frequency."
        if np.abs(same).max() > 1e-6:
            yield f"""{said}, but the samples of the two cosines differ. Which multiple of 1/dt is
                nearest?"""
    return "The samples of both cosines agree in every case tried."


def exercise_3(longest, rig):
    """The longest period at which the margins without filters are large enough, s."""
    longest = number("longest", longest, above=0)
    if longest > 0.2:
        yield "A period in seconds is asked for; this one would be very long."
    periods = (longest, FURTHER * longest)
    designs = (acceptance.reference(rig).changed(dt=dt) for dt in periods)
    here, beyond = (min(acceptance.modulus_margins(one, filters=False)) for one in designs)
    if here < MARGIN:
        yield f"Without filters the smaller modulus margin is {here:.3f} there, under {MARGIN}."
    if beyond >= MARGIN:
        yield f"Still {here:.3f} there, and {beyond:.3f} at a period 5 % longer: go on."
    return f"The smaller margin is {here:.3f}; a period longer by 5 % takes it below {MARGIN}."


def exercise_4(design, rig):
    """Period, filters and k_p of one's own."""
    yield acceptance.wrong_design(design, rig, any_filters=True)
    filters, rate, load = design.rig.filters, 1 / design.dt, PASS / design.dt
    if filters is None:
        yield "This rig has no filters at all; its cables' 50 Hz would reach the sampler whole."
    if load > LOAD + 1e-9:
        yield f"""One pass takes 1 ms, so at dt = {1000 * design.dt:.3g} ms the computer is busy
            {load:.1%} of the time; at most {LOAD:.0%} is allowed."""
    seen = abs(HUM_HZ - round(HUM_HZ / rate) * rate)
    if seen < LOWEST:
        yield f"""Sampled at {rate:.4g} Hz, the mains' 50 Hz turns up at {seen:.2g} Hz, where it
            looks like a motion of the pendulum; no voltage will show it, the pendulum will. Keep it
            above {LOWEST:g} Hz."""
    smoothing = np.hypot(1, rate / max(filters.input_hz))
    if smoothing < SMOOTHING:
        yield f"""The faster motor filter weakens the staircase's {rate:.4g} Hz by a factor of
            {smoothing:.4g} only; {SMOOTHING} is asked for."""
    passed = np.hypot(1, HUM_HZ / max(filters.output_hz))
    if passed < WEAKENED:
        yield f"""The fastest sensor filter weakens the hum's {HUM_HZ:g} Hz by a factor of
            {passed:.4g} only; {WEAKENED:g} is asked for: behind the sampler nobody can tell it from
            a motion."""
    yield acceptance.unstable(design.filtered_loop)
    yield acceptance.small_margins(design, (MARGIN, MARGIN))
    volts = hum_volts(design)
    if volts > HUM_VOLTS:
        yield f"""The hum moves motor 1 by {volts:.2f} V, {HUM_VOLTS:g} V is allowed; the sensors'
            filters and the period both have a say in it."""
    first, second = acceptance.modulus_margins(design)
    return f"Margins {first:.2f} and {second:.2f}, hum {volts:.2f} V."


def hum_volts(design):
    """Amplitude of u1 for hum on the three angles' cables, before the sensors' filters."""
    cuts = np.array(design.rig.filters.output_hz)
    arriving = np.array([HUM, HUM, HUM, 0]) / (1 + 1j * HUM_HZ / cuts)
    to_u = control.feedback(-design.controller.system, design.filtered)
    return float(abs(pl.frequency_response(to_u, 2 * np.pi * HUM_HZ)[0, 0] @ arriving))


def exercise_5(design, lean, rig):
    """The largest lean from which it comes back, rad."""
    yield acceptance.before("The design", "exercise 4", exercise_4(design, rig))
    lean = number("lean", lean, above=0)
    if lean > 0.5:
        yield "The lean is in radians; this one is nearly lying down."
    if not recovers(design, lean):
        yield f"From {lean:.4f} rad your pendulum does not come back in 6 s."
    if recovers(design, FURTHER * lean):
        yield f"It still comes back from {FURTHER * lean:.4f} rad: lean further."
    return f"From {lean:.3f} rad it comes back, from 5 % more it does not."


def recovers(design, lean):
    bench = replace(acceptance.REAL, delay=PASS)
    run = pl.simulate(design.rig, design.controller, LASTING, [lean, 0, 0], imperfections=bench)
    return not run.fell and float(np.abs(run.angles[run.t > LASTING - 1]).max()) < REST
