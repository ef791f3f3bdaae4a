"""What a simulation is given, brought into rows; the bench file as imperfections."""

import dataclasses
import tomllib

import numpy as np
import pytest

import pendlab as pl
from pendlab.bench import inputs
from pendlab.parameters import DATA

T = np.array([0.0, 0.01, 0.02])


class Clocked:
    """A controller with a sampling time of its own."""

    dt = 0.02


@pytest.mark.parametrize("off, same", [(1e-13, True), (1e-10, False)])
def test_sampling_time_is_the_controllers(off, same):
    assert inputs.sampling_time(object(), None) == 0.01
    assert inputs.sampling_time(object(), 0.03) == 0.03
    assert inputs.sampling_time(Clocked(), None) == 0.02
    if same:
        assert inputs.sampling_time(Clocked(), 0.02 + off) == 0.02 + off
    else:
        with pytest.raises(ValueError, match=r"dt: the controller is made for 0\.02 s"):
            inputs.sampling_time(Clocked(), 0.02 + off)


@pytest.mark.parametrize("t_end, last", [(0.3, 3), (0.3 * (1 - 1e-12), 3), (0.3 - 1e-8, 2), (0, 0)])
def test_samples_reach_the_end_whatever_its_rounding(t_end, last):
    """0.3/0.1 is 2.9999999999999996."""
    np.testing.assert_array_equal(inputs.sample_times(t_end, 0.1), 0.1 * np.arange(last + 1))


def test_a_million_samples_and_no_more():
    assert len(inputs.sample_times(999_999, 1)) == 1_000_000
    with pytest.raises(ValueError, match="t_end: expected less than 1e"):
        inputs.sample_times(1_000_000, 1)


def test_initial_state():
    """The links may lean up to the horizontal, each by its absolute angle; rates up to 1e6 rad/s."""
    np.testing.assert_array_equal(inputs.initial_state(None, 2), np.zeros(4))
    np.testing.assert_array_equal(inputs.initial_state((0.1, 0.2), 2), [0.1, 0.2, 0, 0])
    for good in ([1.57, -3.14, 0, 0], [-1.57, 0.1, 0, -1e6], [0.1, 0.2, 1e6, 0]):
        np.testing.assert_array_equal(inputs.initial_state(good, 2), good)
    for bad in ([np.pi / 2, 0], [0.8, 0.8], [-0.8, -0.8], [1.57, -3.15]):
        with pytest.raises(ValueError, match="initial: a link starts past the horizontal"):
            inputs.initial_state(bad, 2)
    with pytest.raises(ValueError, match=r"initial: expected rates below 1e\+06"):
        inputs.initial_state([0, 0, 0, -1.1e6], 2)


@pytest.mark.parametrize("reference, columns, rows", [
    (0.5, 2, [[0.5, 0.5]] * 3),
    (0.5, None, [[0.5]] * 3),
    ([0.1, 0.2, 0.3], 1, [[0.1], [0.2], [0.3]]),
    ([0.1, 0.2, 0.3], 2, [[0.1] * 2, [0.2] * 2, [0.3] * 2]),
    ([[0.1, 1], [0.2, 2], [0.3, 3]], None, [[0.1, 1], [0.2, 2], [0.3, 3]]),
    (float, 1, [[0.0], [0.01], [0.02]]),
    (lambda t: (t, -t), 2, [[0, 0], [0.01, -0.01], [0.02, -0.02]]),
])  # fmt: skip
def test_reference_becomes_a_row_for_each_sample(reference, columns, rows):
    np.testing.assert_array_equal(inputs.reference_rows(reference, T, columns), rows)


@pytest.mark.parametrize("reference, columns", [
    ([0.1, 0.2], 1), (np.zeros((3, 2)), 1), (np.zeros((3, 2)), 3), (np.zeros((3, 1, 1)), 1),
    (np.zeros((2, 2)), None), (lambda t: (t, -t), 1),
])  # fmt: skip
def test_reference_of_another_shape_is_refused(reference, columns):
    with pytest.raises(ValueError, match="reference: expected a number, a function of t, or one"):
        inputs.reference_rows(reference, T, columns)


def test_disturbances_become_rows():
    """Pulses: index of the link, start, end, height; a function: a row for each sample."""
    pulses, held = inputs.disturbance_rows([pl.Pulse(2, 0.5, 0.25, -3.0)], T, 2)
    np.testing.assert_array_equal(pulses, [[1, 0.5, 0.75, -3.0]])
    np.testing.assert_array_equal(held, [[0, 0]])
    pulses, held = inputs.disturbance_rows(lambda t: (t, 2 * t), T, 2)
    assert pulses.shape == (0, 4)
    np.testing.assert_array_equal(held, np.outer(T, [1, 2]))
    pulses, held = inputs.disturbance_rows(None, T, 2)
    assert pulses.shape == (0, 4) and np.array_equal(held, [[0, 0]])
    with pytest.raises(ValueError, match="disturbance: expected a torque for each of the 2 links"):
        inputs.disturbance_rows(lambda t: (t, t, t), T, 2)


# ---- Imperfections


def test_all_is_off_by_default():
    laws = ("contact_stiffness", "contact_damping", "presliding", "start_torque_time")
    assert not any(v for name, v in vars(pl.Imperfections()).items() if name not in laws)


@pytest.mark.parametrize("name", ["presliding", "start_torque_time"])
def test_least_of_what_is_divided_by(name):
    assert getattr(pl.Imperfections(**{name: 1e-9}), name) == 1e-9
    with pytest.raises(ValueError, match=f"{name}: expected a number of at least 1e-09"):
        pl.Imperfections(**{name: 9e-10})


def test_signs_belong_to_offsets_and_start_torques_only():
    assert pl.Imperfections(offset=-0.1, start_torque=(-0.1, 0.2)).start_torque == (-0.1, 0.2)
    for field in dataclasses.fields(pl.Imperfections):
        if "tuple" in str(field.type) and field.name not in ("offset", "start_torque"):
            with pytest.raises(ValueError, match=f"{field.name}.*: expected a number"):
                pl.Imperfections(**{field.name: -0.1})
    with pytest.raises(ValueError, match="contact_stiffness: expected numbers above 0"):
        pl.Imperfections(contact_stiffness=(100.0, 0.0))


def test_each_has_a_value_for_every_part():
    on = pl.Imperfections(gap=(0.1, 0.2), noise=0.3)
    np.testing.assert_array_equal(on.each("gap", 2), [0.1, 0.2])
    np.testing.assert_array_equal(on.each("noise", 4), [0.3] * 4)
    np.testing.assert_array_equal(on.each("noise", 1), [0.3])
    with pytest.raises(ValueError, match="gap: expected 3 numbers, found 2"):
        on.each("gap", 3)


@pytest.mark.parametrize("name", ["double", "triple"])
def test_bench_is_what_its_file_says(name):
    with open(DATA / "gearbox.toml", "rb") as file:
        table = tomllib.load(file)
    rig = pl.load(name)
    n, m, on = rig.n_links, rig.n_motors, pl.bench_imperfections(rig)
    sensors, bench = table["sensors"], table["benches"][f"{n} links"]
    codes = 2 ** sensors["bits"]["value"]
    step = {
        key: 2 * sensors[f"{key}_range"]["value"] / codes for key in ("angle", "rate", "voltage")
    }
    assert on.resolution == pytest.approx([step["angle"]] * n + [step["rate"]])
    assert on.voltage_resolution == pytest.approx(step["voltage"])
    noise = [sensors[f"{key}_noise"]["value"] for key in ("angle",) * n + ("rate",)]
    assert on.noise == pytest.approx(noise)
    assert on.filters and on.saturation
    assert (on.delay, on.offset) == (bench["delay"]["value"], tuple(bench["offset"]["value"]))
    assert pl.bench_start(rig) == tuple(bench["start"]["value"])
    for ours, theirs in dict(gear_friction="dry_friction", gap="gap").items():
        gears = [gear[theirs]["value"] for gear in table["gearboxes"][:m]]
        assert list(getattr(on, ours)) == gears
    assert on.hinge_friction == tuple(table["hinges"]["dry_friction"]["value"][:n])


@pytest.mark.parametrize(
    "bits, works", [(1, True), (32, True), (0, False), (33, False), (12.5, False)]
)
def test_bits_of_the_converters(tmp_path, monkeypatch, bits, works):
    text = (DATA / "gearbox.toml").read_text(encoding="utf-8")
    assert "{value = 12, " in text
    (tmp_path / "gearbox.toml").write_text(
        text.replace("{value = 12, ", f"{{value = {bits}, "), "utf-8"
    )
    monkeypatch.setattr("pendlab.bench.gearbox.DATA", tmp_path)
    if works:
        on = pl.bench_imperfections(pl.load("double"))
        assert on.voltage_resolution == pytest.approx(2 * 12.0 / 2**bits)
    else:
        with pytest.raises(ValueError, match="entry 'bits': expected a whole number from 1 to 32"):
            pl.bench_imperfections(pl.load("double"))
