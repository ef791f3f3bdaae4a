"""What the bench does to a design: filters, limits, resolution, delay, sensors, friction, backlash."""

from dataclasses import dataclass, fields, replace
from numbers import Real

import numpy as np

from .._arguments import flag, instance, number, numbers, whole
from ..parameters import DATA, Pendulum, entry, load, read_toml
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
        for name in PER_OUTPUT | PER_LINK | PER_HINGE | PER_MOTOR:
            least = None if name in SIGNED else 0
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
        known = sorted(PER_OUTPUT | PER_LINK | PER_HINGE | PER_MOTOR)
        value = getattr(self, one_of("name", name, known))
        whole("count", count, least=1, most=1000)
        if np.ndim(value) == 0:
            return np.full(count, float(value))
        return np.array(numbers(name, value, count=count))


PER_OUTPUT = {"resolution", "offset", "noise"}
PER_LINK = {"start_torque"}
PER_HINGE = {"hinge_friction"}
PER_MOTOR = {"voltage_resolution", "gear_friction", "gap", "contact_stiffness", "contact_damping"}
SIGNED = {"offset", "start_torque"}


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


def bench_imperfections(rig, *, foreign=False):
    """The imperfections of ``data/gearbox.toml`` that explain Figs 15-17, all switched on.

    Motor 1 has the same gearbox in both rigs. See the file for how its values were found.

    Parameters
    ----------
    rig : one of the paper's, or one that has its gearboxes (with the same ratios) on other links
    foreign : True takes the paper's gearboxes for a rig with others, which the file knows nothing of

    ValueError for a rig that the file does not know, or a damaged entry.
    """
    path, table, bench = _bench(rig)
    n = rig.n_links
    gears = _gears(path, table, rig, foreign)
    sensors, hinges = table["sensors"], table["hinges"]

    def one(part, key, unit):
        return _values(path, part, key, unit, 1)[0]

    def each(key, unit):
        return tuple(one(gear, key, unit) for gear in gears)

    bits = one(sensors, "bits", "1")
    if bits not in range(1, 33):
        raise ValueError(
            f"{path}: entry 'bits': expected a whole number from 1 to 32, found {bits:g}."
        )
    angle, rate, voltage = (
        2 * one(sensors, key, unit) / 2**bits
        for key, unit in (("angle_range", "rad"), ("rate_range", "rad/s"), ("voltage_range", "V"))
    )
    return Imperfections(
        filters=True,
        saturation=True,
        resolution=(angle,) * n + (rate,),
        voltage_resolution=voltage,
        delay=one(bench, "delay", "s"),
        offset=_values(path, bench, "offset", "rad, rad/s", n + 1),
        noise=(one(sensors, "angle_noise", "rad"),) * n + (one(sensors, "rate_noise", "rad/s"),),
        hinge_friction=_values(path, hinges, "dry_friction", "N m", None)[:n],
        gear_friction=each("dry_friction", "N m"),
        gap=each("gap", "rad"),
        contact_stiffness=each("contact_stiffness", "N m/rad"),
        contact_damping=each("contact_damping", "s/rad"),
        presliding=one(hinges, "presliding", "rad"),
    )


def _gears(path, table, rig, foreign):
    """The entries of the rig's gearboxes; a gearbox is known by its ratio."""
    gears = table.get("gearboxes", [])[: rig.n_motors]
    if len(gears) < rig.n_motors:
        raise ValueError(
            f"{path}: describes {len(gears)} gearboxes, found a rig with {rig.n_motors} motors."
        )
    if flag("foreign", foreign):
        return gears
    for j, (motor, paper) in enumerate(zip(rig.motors, load("triple").motors), 1):
        if motor.ratio != paper.ratio:
            raise ValueError(
                f"rig: the bench describes the paper's gearboxes, number {j} with a ratio of "
                f"{paper.ratio:g}, found {motor.ratio:g}; build pl.Imperfections(...) for your own, or "
                "say foreign=True to take the paper's play and friction."
            )
    return gears


def bench_rig(rig, *, foreign=False):
    """The rig as it stands on the bench: `rig` with what the data sheets of its motors leave out.

    The damping of each motor is multiplied by its factor in ``data/gearbox.toml``. Tables 2 to 5 and
    every design stay as printed; only what is simulated with `bench_imperfections` takes this rig.
    Arguments and errors are as there.

    >>> paper = pl.load("double")
    >>> pl.bench_rig(paper).motors[0].damping > paper.motors[0].damping
    True
    """
    path, table, _ = _bench(rig)
    motors = tuple(
        replace(motor, damping=motor.damping * _values(path, gear, "damping_factor", "1", 1)[0])
        for motor, gear in zip(rig.motors, _gears(path, table, rig, foreign))
    )
    return replace(rig, motors=motors)


def bench_start(rig):
    """Relative angles (rad) from which Figs 15-17 are started by hand, from ``data/gearbox.toml``."""
    path, _, bench = _bench(rig)
    return _values(path, bench, "start", "rad", rig.n_links)


def _bench(rig):
    instance("rig", rig, Pendulum, 'pl.load("triple")')
    path = DATA / "gearbox.toml"
    table = read_toml(path)
    known = table.get("benches", {})
    bench = known.get(f"{rig.n_links} links")
    if bench is None:
        raise ValueError(
            f"rig: {path.name} knows benches with {', '.join(known)}, found {rig.n_links} links; "
            "build pl.Imperfections(...) by hand."
        )
    for name in ("sensors", "hinges"):
        if name not in table:
            raise ValueError(f"{path}: section [{name}] is missing; restore it.")
    return path, table, bench


def _values(path, part, key, unit, count):
    return numbers(f"{path}: entry {key!r}", entry(path, part, key, unit), count=count)


def switches():
    """Names of the entries of `Imperfections`, in the order of the dataclass."""
    return [field.name for field in fields(Imperfections)]
