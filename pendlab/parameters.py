"""Parameters of a pendulum rig: links, motors, filters and limits, read from ``data/rigs``.

Link 1 is the lowest. Hinge i carries link i; motor i drives hinge i+1, and hinge 1 is free.
"""

import math
import tomllib
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from ._arguments import found, instance, instances, number, numbers, text

HERE = Path(__file__).parent
# In the repository data/ stands beside the package; an installed wheel carries it inside.
DATA = HERE / "data" if (HERE / "data").is_dir() else HERE.parent / "data"
LARGEST = 1e9  # beyond it, in SI units, stands a slip and no rig


@dataclass(frozen=True)
class Link:
    """One rigid link.

    Parameters
    ----------
    length : distance between its two hinges, m (of the last link: for drawing only)
    mass : kg
    inertia : about the centre of mass, kg m^2
    com : distance from the lower hinge to the centre of mass, m
    friction : viscous, of the lower hinge, N m s

    >>> pl.Link(length=0.5, mass=0.4, inertia=0.01, com=0.25, friction=0.02).com
    0.25
    """

    length: float
    mass: float
    inertia: float
    com: float
    friction: float

    def __post_init__(self):
        _in_range(self, may_be_zero=("friction",))


@dataclass(frozen=True)
class Motor:
    """One motor with its gearbox, everything seen at the output shaft.

    Parameters
    ----------
    damping : viscous friction, N m s
    inertia : rotor inertia times ratio squared, kg m^2
    gain : torque per volt, N m / V
    ratio : gear ratio, turns of the rotor per turn of the shaft

    >>> pl.Motor(damping=7.73, inertia=0.0358, gain=2.0, ratio=236).gain  # Table 3
    2.0
    """

    damping: float
    inertia: float
    gain: float
    ratio: float

    def __post_init__(self):
        _in_range(self, may_be_zero=("damping", "inertia"))


def _in_range(part, may_be_zero):
    for name, value in vars(part).items():
        above = None if name in may_be_zero else 0
        number(f"{type(part).__name__} {name}", value, above=above, least=0, most=LARGEST)


@dataclass(frozen=True)
class Filters:
    """Cut-off frequencies (Hz) of the first-order filters, one per motor voltage and per output.

    >>> pl.Filters([6.05], [15.9, 15.9, 40]).input_hz
    (6.05,)
    """

    input_hz: tuple
    output_hz: tuple

    def __post_init__(self):
        for name in ("input_hz", "output_hz"):
            object.__setattr__(self, name, numbers(f"Filters {name}", getattr(self, name), above=0))


@dataclass(frozen=True)
class Pendulum:
    """A rig of links, motors, filters and limits.

    Parameters
    ----------
    links : n >= 2 `Link`, the lowest first
    motors : m `Motor`, 1 <= m <= n-1; motor i drives hinge i+1
    filters : `Filters` with m inputs and n+1 outputs, or None for a rig without filters
    u_max : m voltage limits, V
    g : acceleration of gravity, m/s^2
    name : for titles and messages

    >>> double = pl.load("double")
    >>> pl.Pendulum(double.links, double.motors).u_max  # without limits
    (inf,)
    """

    links: tuple
    motors: tuple
    filters: Filters | None = None
    u_max: tuple = ()
    g: float = 9.81
    name: str = "pendulum"

    def __post_init__(self):
        set_ = object.__setattr__
        set_(self, "links", instances("links", self.links, Link))
        set_(self, "motors", instances("motors", self.motors, Motor))
        n, m = self.n_links, self.n_motors
        if n < 2:
            raise ValueError(f"links: expected at least 2, found {n}; add a Link.")
        if not 1 <= m <= n - 1:
            raise ValueError(
                f"motors: {n} links take 1 to {n - 1} motors (hinge 1 is free), found {m}."
            )
        u_max = self.u_max if len(numbers("u_max", self.u_max, finite=False)) else (math.inf,) * m
        set_(self, "u_max", numbers("u_max", u_max, above=0, count=m, finite=False))
        number("g", self.g, above=0, most=LARGEST)
        text("name", self.name)
        if self.filters is not None:
            instance("filters", self.filters, Filters, "rig.filters, or None")
            numbers("filters.input_hz", self.filters.input_hz, count=m)
            numbers("filters.output_hz", self.filters.output_hz, count=n + 1)

    @property
    def n_links(self):
        return len(self.links)

    @property
    def n_motors(self):
        return len(self.motors)


def rigs():
    """Names of the rigs in ``data/rigs``.

    >>> pl.rigs()
    ['double', 'triple']
    """
    return sorted(path.stem for path in (DATA / "rigs").glob("*.toml"))


UNITS = {
    Link: dict(length="m", mass="kg", inertia="kg m^2", com="m", friction="N m s"),
    Motor: dict(damping="N m s", inertia="kg m^2", gain="N m/V", ratio="1"),
    Filters: dict(input_hz="Hz", output_hz="Hz"),
}


def load(name):
    """A rig by name (``"double"``, ``"triple"``: Tables 2-5) or from the path of a rig file.

    ValueError names the file and the entry that is missing, damaged or unknown.

    >>> pl.load("double").n_links
    2
    """
    if not isinstance(name, (str, Path)):
        raise TypeError(f"name: expected the name of a rig or the path of its file, {found(name)}.")
    path = Path(name)
    if path.suffix != ".toml":
        path = DATA / "rigs" / f"{name}.toml"
        if str(name) not in rigs():
            raise ValueError(
                f"name: no rig {name!r} in {path.parent}; known are {', '.join(rigs()) or 'none'}. "
                f"A path ending in .toml loads a rig of your own."
            )
    table = read_toml(path)
    try:
        known("top level", table, ("name", "gravity", "links", "motors", "filters", "limits"))
        links, motors = _parts(Link, table, "links"), _parts(Motor, table, "motors")
        filters = _part(Filters, table["filters"], "filters") if "filters" in table else None
        limits = known("limits", table.get("limits", {}), ("u_max",))
        u_max = entry("limits", limits, "u_max", "V")
        g = entry("top level", table, "gravity", "m/s^2")
        return Pendulum(links, motors, filters, u_max, g, table.get("name", path.stem))
    except (ValueError, TypeError) as problem:
        raise ValueError(f"{path}: {problem}") from None


def read_toml(path):
    """A TOML file as a dict; a missing or damaged file is named in the error."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise ValueError(f"{path}: file not found; restore it from the repository.") from None
    except OSError as problem:
        raise ValueError(f"{path}: cannot be read ({problem.strerror}).") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
        raise ValueError(f"{path}: not readable as TOML ({problem}); mend or restore it.") from None


def known(place, table, names):
    """`table` if it is one and every key of it is among `names`."""
    if not isinstance(table, dict):
        raise ValueError(f"{place}: expected a table, {found(table)}.")
    for key in table.keys() - set(names):
        near = get_close_matches(key, names, n=1)
        advice = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names)}."
        raise ValueError(f"{place}: there is no entry {key!r}; {advice}")
    return table


def entry(place, table, key, unit):
    """The value of ``key = {value = ..., unit = ..., source = ...}`` in a table of a file."""
    item = table.get(key) if isinstance(table, dict) else None
    if not isinstance(item, dict) or "value" not in item:
        raise ValueError(
            f"{place}: entry {key!r} is missing or has no value; "
            f'write {key} = {{value = ..., unit = "{unit}", source = "..."}}.'
        )
    if item.get("unit") != unit:
        raise ValueError(f"{place}: entry {key!r} must be in {unit!r}, found {item.get('unit')!r}.")
    return item["value"]


def _parts(kind, table, key):
    parts = table.get(key, [])
    parts = parts if isinstance(parts, list) else [parts]
    return [_part(kind, part, f"{key} {i}") for i, part in enumerate(parts, 1)]


def _part(kind, table, place):
    known(place, table, tuple(UNITS[kind]))
    values = {key: entry(place, table, key, unit) for key, unit in UNITS[kind].items()}
    try:
        return kind(**values)
    except (ValueError, TypeError) as problem:
        raise ValueError(f"{place}: {problem}") from None
