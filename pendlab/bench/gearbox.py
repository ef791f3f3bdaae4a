"""The paper's bench as ``data/gearbox.toml`` describes it: its imperfections, its motors, its start."""

from dataclasses import replace

from .._arguments import flag, instance, numbers
from ..parameters import DATA, Pendulum, entry, load, read_toml
from .imperfections import Imperfections


def bench_imperfections(rig, *, foreign=False):
    """The imperfections of ``data/gearbox.toml`` that explain Figs 15-17, all switched on.

    Motor 1 has the same gearbox in both rigs. See the file for how its values were found.

    Parameters
    ----------
    rig : one of the paper's, or one that has its gearboxes (with the same ratios) on other links
    foreign : True takes the paper's gearboxes for a rig with others, which the file knows nothing of

    ValueError for a rig that the file does not know, or a damaged entry.
    """
    table, bench = _bench(rig)
    n, gears = rig.n_links, _gears(table, rig, foreign)
    sensors, hinges = table["sensors"], table["hinges"]
    bits = _value(sensors, "bits", "1")
    if bits not in range(1, 33):
        raise ValueError(
            f"{_path()}: entry 'bits': expected a whole number from 1 to 32, found {bits:g}."
        )

    def step(key, unit):
        return 2 * _value(sensors, key, unit) / 2**bits

    def each(key, unit):
        return tuple(_value(gear, key, unit) for gear in gears)

    return Imperfections(
        filters=True,
        saturation=True,
        resolution=(step("angle_range", "rad"),) * n + (step("rate_range", "rad/s"),),
        voltage_resolution=step("voltage_range", "V"),
        delay=_value(bench, "delay", "s"),
        offset=_values(bench, "offset", "rad, rad/s", n + 1),
        noise=(_value(sensors, "angle_noise", "rad"),) * n
        + (_value(sensors, "rate_noise", "rad/s"),),
        hinge_friction=_values(hinges, "dry_friction", "N m")[:n],
        gear_friction=each("dry_friction", "N m"),
        gap=each("gap", "rad"),
        contact_stiffness=each("contact_stiffness", "N m/rad"),
        contact_damping=each("contact_damping", "s/rad"),
        presliding=_value(hinges, "presliding", "rad"),
    )


def _gears(table, rig, foreign):
    """The entries of the rig's gearboxes; a gearbox is known by its ratio."""
    gears = table.get("gearboxes", [])[: rig.n_motors]
    if len(gears) < rig.n_motors:
        raise ValueError(
            f"{_path()}: describes {len(gears)} gearboxes, found a rig with {rig.n_motors} motors."
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
    table, _ = _bench(rig)
    motors = tuple(
        replace(motor, damping=motor.damping * _value(gear, "damping_factor", "1"))
        for motor, gear in zip(rig.motors, _gears(table, rig, foreign))
    )
    return replace(rig, motors=motors)


def bench_start(rig):
    """Relative angles (rad) from which Figs 15-17 are started by hand, from ``data/gearbox.toml``."""
    _, bench = _bench(rig)
    return _values(bench, "start", "rad", rig.n_links)


def _bench(rig):
    """The whole file and the entries of the bench with this number of links."""
    instance("rig", rig, Pendulum, 'pl.load("triple")')
    table = read_toml(_path())
    benches = table.get("benches", {})
    if f"{rig.n_links} links" not in benches:
        raise ValueError(
            f"rig: {_path().name} knows benches with {', '.join(benches)}, found {rig.n_links} "
            "links; build pl.Imperfections(...) by hand."
        )
    for name in ("sensors", "hinges"):
        if name not in table:
            raise ValueError(f"{_path()}: section [{name}] is missing; restore it.")
    return table, benches[f"{rig.n_links} links"]


def _path():
    return DATA / "gearbox.toml"


def _values(part, key, unit, count=None):
    return numbers(f"{_path()}: entry {key!r}", entry(_path(), part, key, unit), count)


def _value(part, key, unit):
    return _values(part, key, unit, 1)[0]
