"""Rigs: what may be built, what a rig file may hold, and how each fault is named."""

import dataclasses
import math
import re

import pytest

import pendlab as pl
from pendlab import parameters

LINK = dict(length=0.2, mass=0.5, inertia=4e-3, com=0.1, friction=0.02)
MOTOR = dict(damping=1.0, inertia=0.01, gain=2.0, ratio=100.0)


def build(n=2, m=1, **options):
    return pl.Pendulum([pl.Link(**LINK)] * n, [pl.Motor(**MOTOR)] * m, **options)


def test_published_rigs():
    assert {"double", "triple"} <= set(pl.rigs())
    double, triple = pl.load("double"), pl.load("triple")
    assert (double.n_links, double.n_motors, double.u_max) == (2, 1, (9.0,))
    assert (triple.n_links, triple.n_motors, triple.u_max) == (3, 2, (12.0, 2.5))
    assert double.motors[0] == triple.motors[0], "the double uses motor 1 of Table 3"
    assert len(triple.filters.input_hz) == 2 and len(triple.filters.output_hz) == 4


def test_equal_rigs_are_equal_and_hashable():
    assert pl.load("triple") == pl.load("triple")
    assert hash(pl.load("triple")) == hash(pl.load("triple")) and len({build(), build()}) == 1


def test_slow_filters_are_filters():
    assert build(filters=pl.Filters([0.5], [0.1] * 3)).filters.output_hz == (0.1, 0.1, 0.1)


def test_replace_and_frozen(triple):
    lighter = dataclasses.replace(triple.links[2], mass=0.1)
    changed = dataclasses.replace(triple, links=(*triple.links[:2], lighter))
    assert changed.links[2].mass == 0.1 and triple.links[2].mass == 0.50637
    with pytest.raises(dataclasses.FrozenInstanceError):
        triple.g = 1.62
    with pytest.raises(ValueError, match="Link mass: expected a number above 0, found -1"):
        dataclasses.replace(triple.links[0], mass=-1.0)


@pytest.mark.parametrize("n, m", [(2, 1), (3, 1), (3, 2), (4, 1), (5, 4)])
def test_any_number_of_links_and_motors(n, m):
    rig = build(n, m)
    assert (rig.n_links, rig.n_motors) == (n, m)
    assert rig.u_max == (math.inf,) * m and rig.filters is None and rig.g == 9.81


@pytest.mark.parametrize("field", LINK)
@pytest.mark.parametrize(
    "bad, error",
    [
        (-0.1, ValueError),
        (math.nan, ValueError),
        (math.inf, ValueError),
        ("1", TypeError),
        (True, TypeError),
        (None, TypeError),
    ],
)
def test_bad_link(field, bad, error):
    with pytest.raises(error, match=f"^Link {field}: expected a .*number"):
        pl.Link(**LINK | {field: bad})


@pytest.mark.parametrize("field", MOTOR)
@pytest.mark.parametrize("bad, error", [(-1, ValueError), (math.nan, ValueError), ([1], TypeError)])
def test_bad_motor(field, bad, error):
    with pytest.raises(error, match=f"^Motor {field}: expected a .*number"):
        pl.Motor(**MOTOR | {field: bad})


@pytest.mark.parametrize(
    "call, error, message",
    [
        (lambda: build(1, 0), ValueError, "links: expected at least 2, found 1"),
        (lambda: build(3, 3), ValueError, "motors: 3 links take 1 to 2 motors .* found 3"),
        (lambda: build(2, 0), ValueError, "motors: 2 links take 1 to 1 motors .* found 0"),
        (lambda: build(u_max=(1, 2)), ValueError, "u_max: expected 1 numbers, found 2"),
        (lambda: build(u_max=(0,)), ValueError, r"u_max\[0\]: expected a number above 0"),
        (lambda: build(u_max=(math.nan,)), ValueError, r"u_max\[0\]"),
        (lambda: build(g=0), ValueError, "g: expected a number above 0"),
        (
            lambda: build(filters=(5,)),
            TypeError,
            "filters: expected a pl.Filters such as rig.filters, or None",
        ),
        (
            lambda: build(filters=pl.Filters([5, 5], [9] * 3)),
            ValueError,
            "filters.input_hz: expect",
        ),
        (lambda: build(filters=pl.Filters([5], [9] * 2)), ValueError, "filters.output_hz: expect"),
        (lambda: pl.Filters([-5], [9]), ValueError, r"Filters input_hz\[0\]: expected a number"),
        (lambda: pl.Pendulum([LINK] * 2, []), TypeError, "links: entry 1: expected a pl.Link"),
        (lambda: pl.Pendulum(3, []), TypeError, "links: expected a list of pl.Link, found 3"),
        (lambda: pl.Pendulum(pl.Link(**LINK), []), ValueError, "links: expected at least 2"),
    ],
)
def test_bad_pendulum(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_one_motor_need_not_stand_in_a_list():
    assert pl.Pendulum([pl.Link(**LINK)] * 2, pl.Motor(**MOTOR)) == build()


@pytest.mark.parametrize("name", ["quadruple", "", "Double", "../rigs/double"])
def test_unknown_rig_lists_the_known(name):
    known = f"no rig {re.escape(repr(name))}.* known are {', '.join(pl.rigs())}"
    with pytest.raises(ValueError, match=known):
        pl.load(name)


@pytest.mark.parametrize("name", [None, 3, ["double"]])
def test_name_must_be_text(name):
    with pytest.raises(TypeError, match="name: expected the name of a rig"):
        pl.load(name)


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Change the text of the double's file and load it by name from a data folder of one's own."""
    good = (parameters.DATA / "rigs" / "double.toml").read_text(encoding="utf-8")
    (tmp_path / "rigs").mkdir()
    monkeypatch.setattr(parameters, "DATA", tmp_path)

    def load(old="", new=""):
        assert old in good
        (tmp_path / "rigs" / "mine.toml").write_text(good.replace(old, new, 1), encoding="utf-8")
        return pl.load("mine")

    return load


def test_own_folder_and_own_path(own, tmp_path, double):
    assert own() == double
    assert pl.rigs() == ["mine"] and pl.load(tmp_path / "rigs" / "mine.toml") == double
    with pytest.raises(ValueError, match=r"no rig 'double' in .*rigs; known are mine"):
        pl.load("double")


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("[[links]]", "[[links]", r"mine\.toml: not readable as TOML \(.*\); mend or restore"),
        (
            "mass     = ",
            "mess = ",
            r"mine\.toml: links 1: there is no entry 'mess'; did you mean 'mass'\?",
        ),
        ("value = 0.7867,", "", r"mine\.toml: links 1: entry 'mass' is missing or has no value"),
        ("{value = 9.81, unit", "9.81 #", r"mine\.toml: top level: entry 'gravity' is missing"),
        ('"kg"', '"g"', r"mine\.toml: links 1: entry 'mass' must be in 'kg', found 'g'"),
        ("0.7867", "-0.7867", r"mine\.toml: links 1: Link mass: expected a number above 0"),
        ("0.7867", '"heavy"', r"mine\.toml: links 1: Link mass: expected a number, found 'heavy'"),
        ("0.7867", "nan", r"mine\.toml: links 1: Link mass: expected a finite number"),
        ("2.00,", "0,", r"mine\.toml: motors 1: Motor gain: expected a number above 0"),
        ("[6.05]", "[6.05, 7]", r"mine\.toml: filters.input_hz: expected 1 numbers, found 2"),
        ("[9.0]", "[]", None),
        ("[limits]", "[limit]", r"mine\.toml: top level: there is no entry 'limit'; .* 'limits'\?"),
        (
            "[filters]",
            "[filter]",
            r"mine\.toml: top level: there is no .* 'filter'; .* 'filters'\?",
        ),
    ],
)
def test_damaged_rig_file_names_file_and_entry(own, old, new, message):
    if message is None:  # both may be left out: no limits, no filters
        assert own(old, new).n_links == 2
    else:
        with pytest.raises(ValueError, match=message):
            own(old, new)


def test_missing_and_unreadable_files(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"gone\.toml: file not found"):
        pl.load(tmp_path / "gone.toml")
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(ValueError, match=r"folder\.toml: cannot be read"):
        pl.load(tmp_path / "folder.toml")
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe4"')
    with pytest.raises(ValueError, match=r"latin\.toml: not readable as TOML"):
        pl.load(tmp_path / "latin.toml")
    monkeypatch.setattr(parameters, "DATA", tmp_path / "nowhere")
    with pytest.raises(ValueError, match=r"no rig 'double' .*known are none"):
        pl.load("double")
