"""Rig files as editors and people write them: byte-order marks, dots in names, misspelt keys."""

import pytest

import pendlab as pl
from pendlab.parameters import DATA

TEXT = (DATA / "rigs" / "triple.toml").read_text(encoding="utf-8")


def written(folder, text, name="mine.toml", encoding="utf-8"):
    path = folder / name
    path.write_text(text, encoding=encoding)
    return pl.load(path)


def test_byte_order_mark(tmp_path, triple):
    assert written(tmp_path, TEXT, encoding="utf-8-sig") == triple


@pytest.mark.parametrize("name", ["rig v1.2", "a.b.c", ".", "été n° 3"])
def test_any_name_goes_the_whole_way(tmp_path, name):
    rig = written(tmp_path, TEXT.replace('name = "triple"', f'name = "{name}"'))
    assert rig.name == name
    goes_the_whole_way(rig)


def test_dot_in_the_name_of_the_file(tmp_path):
    nameless = TEXT.replace('name = "triple"', "")
    rig = written(tmp_path, nameless, "my.rig.toml")
    assert rig.name == "my.rig"
    goes_the_whole_way(rig)


def goes_the_whole_way(rig):
    design = pl.Design(rig, (1,) * 8, (1, 1), 0.9, tracked=(1, 2))
    assert pl.encirclements(design.filtered_loop).stable
    assert pl.closed_loop(design, filters=False).nstates == 6 + 4


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("[filters]", "[filter]", "top level: there is no entry 'filter'; did you mean 'filters'?"),
        ("[limits]", "[Limits]", "top level: there is no entry 'Limits'; did you mean 'limits'?"),
        ("gravity", "graviti", "'graviti'; did you mean 'gravity'?"),
        ("u_max", "umax", "limits: there is no entry 'umax'; did you mean 'u_max'?"),
        ("input_hz", "input_Hz", "filters: there is no entry 'input_Hz'; did you mean 'input_hz'?"),
        ("[limits]", "[friction]\nx = 1\n[limits]", "top level: there is no entry 'friction'"),
        ("friction", "zeal = 1\nfriction", "links 1: there is no entry 'zeal'; known are length"),
        ('name = "triple"', "name = 3", "name: expected text in quotes, found 3"),
        ('name = "triple"', 'name = ""', "name: expected text, found none"),
        ("[limits]", "[[limits]]", "limits: expected a table, found"),
    ],
)
def test_stray_keys_are_named_with_the_nearest_one(tmp_path, old, new, message):
    assert old in TEXT
    with pytest.raises(ValueError) as caught:
        written(tmp_path, TEXT.replace(old, new, 1))
    assert message in str(caught.value) and str(caught.value).startswith(str(tmp_path))


@pytest.mark.parametrize("field", ["com", "mass", "inertia", "length"])
@pytest.mark.parametrize("size", [1e200, 1e12])
def test_sizes_that_no_rig_has(field, size):
    good = dict(length=0.5, mass=0.4, inertia=0.01, com=0.25, friction=0.02)
    with pytest.raises(ValueError, match=f"Link {field}: expected a number of at most"):
        pl.Link(**good | {field: size})


def test_a_mass_matrix_that_rounding_makes_singular_is_a_sentence(double):
    dust = pl.Link(1e-9, 1e-12, 1e-300, 1e-9, 0.0)
    motor = pl.Motor(0.0, 0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="rig: its mass matrix is singular to working precision"):
        pl.linearize(pl.Pendulum([double.links[0], dust], motor))
