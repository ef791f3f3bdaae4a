"""What the bench does to a design: filters, limits, resolution, delay, sensors, friction, backlash."""

from dataclasses import dataclass, fields
from numbers import Real

import numpy as np

from .._arguments import flag, number, numbers, whole
from .arguments import one_of


@dataclass(frozen=True)
class Imperfections:
    """Everything that `simulate` can add to the ideal rig; all off by default.

    A value of zero (or False) switches an entry off, and ``dataclasses.replace(all_on, gap=0.0)``
    takes one away. An entry with one value per output, link, hinge or motor takes a single number for
    all of them. Outputs are the n relative angles and the rate of the lowest link.

    Parameters
    ----------
    filters : first-order filters ``rig.filters`` on the motor voltages and the outputs
    saturation : amplifiers limited to ``rig.u_max``, after the filters as in Fig 4, at every moment; a
        `Controller` has limits of its own besides, before the D/A
    resolution : A/D step of each output, rad and rad/s
    voltage_resolution : D/A step of each motor, V
    delay : from reading to sending, s, at most one sampling time; the old voltage holds meanwhile
    offset : constant sensor error of each output, rad and rad/s
    noise : standard deviation of each reading, rad and rad/s, normal and white
    seed : of the noise
    hinge_friction : dry (Coulomb) friction torque of each of the n hinges, N m
    gear_friction : dry friction torque of each gearbox at its output shaft, N m
    gap : backlash of each gearbox at its output shaft, side to side, rad
    contact_stiffness : of the closed gap, N m/rad
    contact_damping : of the closed gap, s/rad
    presliding : angle over which dry friction builds up from zero before it slips, rad
    start_torque : on each of the n links at t = 0, N m, fading: a hand or cable that lets go slowly
    start_torque_time : time constant of that fading, s

    Notes
    -----
    Start torque: start_torque exp(-t/start_torque_time) on the link, besides any disturbance; its mean
    is held over each sample. Nothing in the paper identifies it: it is a hypothesis for the slow
    growth in Fig 15, and the bench has it off.
    Backlash: the rotor turns by itself, I_p d2phi/dt2 + c_p dphi/dt = G u - dry - tau. With the
    closure delta > 0 of the gap the tooth pushes with
    tau = contact_stiffness delta (1 + contact_damping d(delta)/dt), never pulling (Hunt and
    Crossley 1975: damping grows with delta, so that the torque starts from zero at touch-down).
    Dry friction is an elastic stop dragged along: torque F clip((angle - anchor)/presliding, -1, 1)
    whose anchor follows when it slips. It holds a standing joint for ever, without creep.
    """

    filters: bool = False
    saturation: bool = False
    resolution: float | tuple = 0.0
    voltage_resolution: float | tuple = 0.0
    delay: float = 0.0
    offset: float | tuple = 0.0
    noise: float | tuple = 0.0
    seed: int = 0
    hinge_friction: float | tuple = 0.0
    gear_friction: float | tuple = 0.0
    gap: float | tuple = 0.0
    contact_stiffness: float | tuple = 1000.0
    contact_damping: float | tuple = 1.0
    presliding: float = 1e-3
    start_torque: float | tuple = 0.0
    start_torque_time: float = 5.0

    def __post_init__(self):
        for name in ("filters", "saturation"):
            object.__setattr__(self, name, flag(name, getattr(self, name)))
        number("delay", self.delay, least=0)
        number("presliding", self.presliding, above=0, least=1e-9)
        number("start_torque_time", self.start_torque_time, above=0, least=1e-9)
        whole("seed", self.seed)
        for name in SEVERAL:
            least = None if name in ("offset", "start_torque") else 0
            values = numbers(name, getattr(self, name), least=least)
            # Tuples, so that equal settings compare equal; a single number stays one.
            single = isinstance(getattr(self, name), (Real, np.number))
            object.__setattr__(self, name, values[0] if single else values)
        if np.min(self.contact_stiffness, initial=np.inf) <= 0:
            raise ValueError(
                "contact_stiffness: expected numbers above 0; use gap=0 for no backlash."
            )

    def each(self, name, count):
        """The entry `name` as an array with `count` values."""
        value = getattr(self, one_of("name", name, SEVERAL))
        whole("count", count, least=1, most=1000)
        if np.ndim(value) == 0:
            return np.full(count, float(value))
        return np.array(numbers(name, value, count=count))


# Entries with one value per output, link, hinge or motor.
SEVERAL = [field.name for field in fields(Imperfections) if field.type == float | tuple]


@dataclass(frozen=True)
class Pulse:
    """A rectangular torque pulse on one link, in the direction of growing angles.

    Parameters
    ----------
    link : 1 is the lowest
    start, length : s
    height : N m
    """

    link: int
    start: float
    length: float
    height: float

    def __post_init__(self):
        whole("Pulse link", self.link, least=1)
        number("Pulse start", self.start, least=0)
        number("Pulse length", self.length, above=0)
        number("Pulse height", self.height)
