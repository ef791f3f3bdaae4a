"""The paper's bench as ``data/gearbox.toml`` describes it: its imperfections, its motors, its start."""

from dataclasses import replace

from .._arguments import flag, instance, numbers, whole
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
    table, bench, gears = _bench(rig, foreign)
    n, sensors, hinges = rig.n_links, table["sensors"], table["hinges"]
    bits = whole(_named("bits"), entry(_path(), sensors, "bits", "1"), least=1, most=32)

    def outputs(key):
        angle = _value(sensors, f"angle_{key}", "rad")
        return (angle,) * n + (_value(sensors, f"rate_{key}", "rad/s"),)

    def each(key, unit):
        return tuple(_value(gear, key, unit) for gear in gears)

    return Imperfections(
        filters=True,
        saturation=True,
        resolution=tuple(2 * reach / 2**bits for reach in outputs("range")),
        voltage_resolution=2 * _value(sensors, "voltage_range", "V") / 2**bits,
        delay=_value(bench, "delay", "s"),
        offset=_values(bench, "offset", "rad, rad/s", n + 1),
        noise=outputs("noise"),
        hinge_friction=_values(hinges, "dry_friction", "N m")[:n],
        gear_friction=each("dry_friction", "N m"),
        gap=each("gap", "rad"),
        contact_stiffness=each("contact_stiffness", "N m/rad"),
        contact_damping=each("contact_damping", "s/rad"),
        presliding=_value(hinges, "presliding", "rad"),
    )


def bench_rig(rig, *, foreign=False):
    """The rig as it stands on the bench: `rig` with what the data sheets of its motors leave out.

    The damping of each motor is multiplied by its factor in ``data/gearbox.toml``. Tables 2 to 5 and
    every design stay as printed; only what is simulated with `bench_imperfections` takes this rig.
    Arguments and errors are as there.

    >>> paper = pl.load("double")
    >>> pl.bench_rig(paper).motors[0].damping > paper.motors[0].damping
    True
    """
    _, _, gears = _bench(rig, foreign)
    motors = tuple(
        replace(motor, damping=motor.damping * _value(gear, "damping_factor", "1"))
        for motor, gear in zip(rig.motors, gears)
    )
    return replace(rig, motors=motors)


def bench_start(rig):
    """Relative angles (rad) from which Figs 15-17 are started by hand, from ``data/gearbox.toml``."""
    _, bench, _ = _bench(rig, foreign=True)
    return _values(bench, "start", "rad", rig.n_links)


def _bench(rig, foreign):
    """The file, the entries of the bench with this number of links, and those of its gearboxes."""
    instance("rig", rig, Pendulum, 'pl.load("triple")')
    table = read_toml(_path())
    benches, gears = table.get("benches", {}), table.get("gearboxes", [])[: rig.n_motors]
    bench = benches.get(f"{rig.n_links} links")
    if bench is None:
        raise ValueError(
            f"rig: {_path().name} knows benches with {', '.join(benches)}, found {rig.n_links} "
            "links; build pl.Imperfections(...) by hand."
        )
    for name in ("sensors", "hinges"):
        if name not in table:
            raise ValueError(f"{_path()}: section [{name}] is missing; restore it.")
    if len(gears) < rig.n_motors:
        raise ValueError(
            f"{_path()}: describes {len(gears)} gearboxes, found a rig with {rig.n_motors} motors."
        )
    known = rig.motors if flag("foreign", foreign) else load("triple").motors
    for j, (motor, paper) in enumerate(zip(rig.motors, known), 1):
        if motor.ratio != paper.ratio:
            raise ValueError(
                f"rig: the bench describes the paper's gearboxes, number {j} with a ratio of "
                f"{paper.ratio:g}, found {motor.ratio:g}; build pl.Imperfections(...) for your own, or "
                "say foreign=True to take the paper's play and friction."
            )
    return table, bench, gears


def _path():
    return DATA / "gearbox.toml"


def _named(key):
    return f"{_path()}: entry {key!r}"


def _values(part, key, unit, count=None):
    return numbers(_named(key), entry(_path(), part, key, unit), count)


def _value(part, key, unit):
    return _values(part, key, unit, 1)[0]
