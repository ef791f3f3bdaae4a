"""What the bench does to a design: filters, limits, resolution, delay, sensors, friction, backlash."""

from dataclasses import dataclass, fields

import numpy as np

from .._arguments import found, number, numbers, whole
from ..parameters import DATA, Pendulum, entry, read_toml


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
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise TypeError(f"{name}: expected True or False, {found(getattr(self, name))}.")
        number("delay", self.delay, least=0)
        for name in ("presliding", "start_torque_time"):
            number(name, getattr(self, name), above=0)
        whole("seed", self.seed)
        for name in PER_OUTPUT | PER_LINK | PER_HINGE | PER_MOTOR:
            least = None if name in SIGNED else 0
            values = numbers(name, getattr(self, name), least=least)
            # Tuples, so that equal settings compare equal; a single number stays one.
            single = np.ndim(getattr(self, name)) == 0
            object.__setattr__(self, name, values[0] if single else values)
        if min(numbers("contact_stiffness", self.contact_stiffness)) <= 0:
            raise ValueError(
                "contact_stiffness: expected numbers above 0; use gap=0 for no backlash."
            )

    def each(self, name, count):
        """The entry `name` as an array with `count` values."""
        value = getattr(self, name)
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


def bench_imperfections(rig):
    """The imperfections of ``data/gearbox.toml`` that explain Figs 15-17, all switched on.

    Motor 1 has the same gearbox in both rigs. See the file for how its values were found.

    Raises
    ------
    ValueError : a rig that the file does not know, or a damaged entry
    """
    rig, path, table, entry = _bench(rig)
    n, m = rig.n_links, rig.n_motors
    gears = table.get("gearboxes", [])
    if len(gears) < m:
        raise ValueError(f"{path}: describes {len(gears)} gearboxes, found a rig with {m} motors.")
    take = lambda part, key, unit, count=1: _values(path, part, key, unit, count)  # noqa: E731
    each = lambda key, unit: sum((take(gear, key, unit) for gear in gears[:m]), ())  # noqa: E731
    sensors = table["sensors"]
    one = lambda part, key, unit: take(part, key, unit)[0]  # noqa: E731
    angles, rate = one(sensors, "angle_range", "rad"), one(sensors, "rate_range", "rad/s")
    codes = 2 ** int(one(sensors, "bits", "1"))
    voltage = one(sensors, "voltage_range", "V")
    return Imperfections(
        filters=True,
        saturation=True,
        resolution=(2 * angles / codes,) * n + (2 * rate / codes,),
        voltage_resolution=2 * voltage / codes,
        delay=one(entry, "delay", "s"),
        offset=take(entry, "offset", "rad, rad/s", n + 1),
        noise=take(sensors, "angle_noise", "rad") * n + take(sensors, "rate_noise", "rad/s"),
        hinge_friction=take(table["hinges"], "dry_friction", "N m", None)[:n],
        gear_friction=each("dry_friction", "N m"),
        gap=each("gap", "rad"),
        contact_stiffness=each("contact_stiffness", "N m/rad"),
        contact_damping=each("contact_damping", "s/rad"),
        presliding=one(table["hinges"], "presliding", "rad"),
    )


def bench_start(rig):
    """Relative angles (rad) from which Figs 15-17 are started by hand, from ``data/gearbox.toml``."""
    _, path, _, entry = _bench(rig)
    return _values(path, entry, "start", "rad", rig.n_links)


def _bench(rig):
    if not isinstance(rig, Pendulum):
        raise TypeError(f'rig: expected a pl.Pendulum such as pl.load("triple"), {found(rig)}.')
    path = DATA / "gearbox.toml"
    table = read_toml(path)
    known = table.get("benches", {})
    entry = known.get(f"{rig.n_links} links")
    if entry is None:
        raise ValueError(
            f"rig: {path.name} knows benches with {', '.join(known)}, found {rig.n_links} links; "
            "build pl.Imperfections(...) by hand."
        )
    for name in ("sensors", "hinges"):
        if name not in table:
            raise ValueError(f"{path}: section [{name}] is missing; restore it.")
    return rig, path, table, entry


def _values(path, part, key, unit, count):
    return numbers(f"{path}: entry {key!r}", entry(path, part, key, unit), count=count)


def switches():
    """Names of the entries of `Imperfections`, in the order of the dataclass."""
    return [field.name for field in fields(Imperfections)]
