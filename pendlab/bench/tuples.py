"""What the kernel's functions take, by what it belongs to: arrays, or lists where nothing is compiled."""

from collections import namedtuple
from typing import NamedTuple


class State(NamedTuple):
    """The rig between two samples; changed in place."""

    x: list  # link angles, link rates, rotor angles, rotor rates, filtered outputs
    anchor: list  # where each dry contact holds on, rad: hinges, then gearboxes
    volts: list  # filtered motor voltages
    before: list  # voltages that the D/A held before the last sample
    sent: list  # and those that it holds since


class Plant(NamedTuple):
    """The rig and what acts on it between the samples."""

    c: list  # combined parameters of the equations of motion
    gear: list  # a row per motor: gain, damping, inertia, half gap, stiffness, impact, dry friction
    dry: list  # dry friction of the hinges, N m
    reach: float  # presliding, rad
    w_in: list  # filter rates, 1/s; 0: no filter
    w_out: list
    limit: list  # of each amplifier, V; it comes after the filter
    pulses: list  # a row per pulse: index of the link, start and end in s, torque in N m


class Clock(NamedTuple):
    """Times of one sampling interval."""

    dt: float  # s
    delay: float  # from reading to sending, s
    steps: int  # of integration, in all
    late: int  # of these before the delay has passed
    first: int  # number of the first sample


class Ports(NamedTuple):
    """Sensor errors and converters."""

    error: list  # of the sensors, a row per sample
    ad: list  # A/D step of each output; 0: exact
    da: list  # D/A step of each motor, V


# The paper's controller, as `pl.Controller` has it.
Law = namedtuple("Law", "E H K L1 L2 F tracked u_max")


class Memory(NamedTuple):
    """What the controller keeps from sample to sample; changed in place."""

    v: list  # observer
    w: list  # integrators
    v_next: list  # room for the observer's next state


# The record, a row per sample: relative states, readings, voltages, estimates.
Rows = namedtuple("Rows", "X Y U XH")
