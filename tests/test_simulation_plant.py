"""The generated plant: equations of motion, contact, friction, MuJoCo, plain Python, cache."""

import ast
import dataclasses
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import pendlab as pl
from pendlab.bench import generated
from pendlab.bench.generated import load_kernel
from pendlab.bench.plant import _state, fastest_rate, integration, plant_numbers
from pendlab.bench.tuples import State


def rig_of(n, m):
    """A rig with n links and m motors, none of them alike."""
    links = [
        pl.Link(0.15 + 0.02 * i, 0.9 - 0.1 * i, 3e-3 + 1e-3 * i, 0.1 + 0.01 * i, 0.02 + 0.01 * i)
        for i in range(n)
    ]
    motors = [pl.Motor(3.0 / (j + 1), 0.03 / (j + 1), 2.0 - 0.4 * j, 100) for j in range(m)]
    return pl.Pendulum(links, motors, pl.Filters((8.0,) * m, (25.0,) * (n + 1)))


def slopes(rig, imperfections, relative, rotor=(), speed=(), volts=None, load=None, anchor=None):
    """Rates of change from the kernel: relative angles and rates, then of the rotors."""
    n, m = rig.n_links, rig.n_motors
    kernel, plant = load_kernel(n, m), plant_numbers(rig, imperfections)
    x = np.zeros(3 * n + 2 * m + 1)
    x[:n], x[n : 2 * n] = np.cumsum(relative[:n]), np.cumsum(relative[n:])
    x[2 * n : 2 * n + len(rotor)] = rotor
    x[2 * n + m : 2 * n + m + len(speed)] = speed
    dx = np.zeros_like(x)
    kernel.derivative(
        x, np.zeros(m) if volts is None else volts, np.zeros(n) if load is None else load,
        np.zeros(n + m) if anchor is None else anchor, plant, np.zeros(n), np.zeros(n), dx,
    )  # fmt: skip
    links = np.concatenate([np.diff(dx[:n], prepend=0.0), np.diff(dx[n : 2 * n], prepend=0.0)])
    return links, dx[2 * n + m : 2 * n + 2 * m]


@pytest.mark.parametrize("n, m", [(2, 1), (3, 2), (3, 1), (4, 2)])
def test_generated_code_is_the_derivation(n, m):
    rig, rng = rig_of(n, m), np.random.default_rng(n + m)
    f = pl.nonlinear(rig)
    for _ in range(20):
        x, u = rng.uniform(-3, 3, 2 * n), rng.uniform(-9, 9, m)
        expected = f(x, u)
        dx, _ = slopes(rig, pl.Imperfections(), x, volts=u)
        np.testing.assert_allclose(dx, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["double", "triple"])
def test_equations_hold_against_mujoco(name):
    mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo (pip install mujoco)")
    rig = pl.load(name)
    n, m, f = rig.n_links, rig.n_motors, pl.nonlinear(rig)
    model = mujoco.MjModel.from_xml_string(mujoco_xml(rig))
    data, rng = mujoco.MjData(model), np.random.default_rng(7)
    for _ in range(50):
        x, u = rng.uniform(-3, 3, 2 * n), rng.uniform(-9, 9, m)
        data.qpos[:], data.qvel[:], data.ctrl[:] = x[:n], x[n:], u
        mujoco.mj_forward(model, data)
        expected = data.qacc
        np.testing.assert_allclose(
            f(x, u)[n:], expected, rtol=0, atol=1e-12 * max(1, np.abs(expected).max())
        )


def mujoco_xml(rig):
    """The linkage for MuJoCo: hinge coordinates are relative angles, rotors are armatures."""
    rotor = [0.0] + [k.inertia for k in rig.motors] + [0.0] * rig.n_links
    damping = [0.0] + [k.damping for k in rig.motors] + [0.0] * rig.n_links
    body, height = "", 0.0
    for i, link in enumerate(rig.links):
        body += (
            f'<body pos="0 0 {height!r}"><joint name="h{i}" type="hinge" axis="0 1 0" '
            f'damping="{link.friction + damping[i]!r}" armature="{rotor[i]!r}"/>'
            f'<inertial pos="0 0 {link.com!r}" mass="{link.mass!r}" '
            f'diaginertia="{link.inertia!r} {link.inertia!r} 1e-5"/>'
        )
        height = link.length
    body += "</body>" * rig.n_links
    motors = "".join(
        f'<motor joint="h{j + 1}" gear="{k.gain!r}"/>' for j, k in enumerate(rig.motors)
    )
    return (
        f'<mujoco><compiler angle="radian" inertiafromgeom="false" balanceinertia="false"/>'
        f'<option gravity="0 0 {-rig.g!r}" timestep="0.001" integrator="RK4"/>'
        f"<worldbody>{body}</worldbody><actuator>{motors}</actuator></mujoco>"
    )


def test_links_swing_free_inside_the_gap():
    rig = rig_of(3, 2)
    bare = [dataclasses.replace(k, inertia=0.0, damping=0.0) for k in rig.motors]
    f = pl.nonlinear(dataclasses.replace(rig, motors=bare))
    x, u = np.array([0.1, -0.2, 0.3, 1.0, -2.0, 0.5]), np.array([5.0, -4.0])
    gap = pl.Imperfections(gap=0.05)
    speed = [0.7, -0.3]
    dx, dw = slopes(rig, gap, x, rotor=x[1:3] + [0.02, -0.02], speed=speed, volts=u)
    np.testing.assert_allclose(dx, f(x, [0, 0]), rtol=1e-12)
    expected = [(k.gain * v - k.damping * w) / k.inertia for k, v, w in zip(rig.motors, u, speed)]
    np.testing.assert_allclose(dw, expected, rtol=1e-12)


@pytest.mark.parametrize("strain", [-5e-3, -4e-4, 4e-4, 5e-3])
def test_dry_friction_of_a_gear_acts_on_the_rotor_inside_the_gap(strain):
    rig = rig_of(3, 2)
    on = pl.Imperfections(gap=0.05, gear_friction=(0.3, 0.2), presliding=1e-3)
    x, rotor, u = np.array([0.1, -0.2, 0.3, 0, 0, 0]), np.array([-0.19, 0.29]), np.array([5.0, -4])
    anchor = np.concatenate([np.zeros(3), rotor - strain])
    _, dw = slopes(rig, on, x, rotor=rotor, volts=u, anchor=anchor)
    friction = np.array([0.3, 0.2]) * np.clip(strain / 1e-3, -1, 1)
    gains, inertias = np.array([(motor.gain, motor.inertia) for motor in rig.motors]).T
    np.testing.assert_allclose(dw, (gains * u - friction) / inertias, rtol=1e-10)


def test_contact_pushes_by_its_law_and_never_pulls():
    rig, rng = rig_of(2, 1), np.random.default_rng(0)
    k, d, half = 300.0, 0.5, 0.025
    gap = pl.Imperfections(gap=2 * half, contact_stiffness=k, contact_damping=d)
    motor, pulled = rig.motors[0], 0
    for _ in range(200):
        slip, slip_rate = rng.uniform(-0.06, 0.06), rng.uniform(-5, 5)
        x = np.array([0.1, 0.2, 0.0, 0.4])
        _, (dw,) = slopes(rig, gap, x, rotor=[0.2 + slip], speed=[0.4 + slip_rate])
        tau = -motor.inertia * dw - motor.damping * (0.4 + slip_rate)  # on the link, from the rotor
        depth, closing = abs(slip) - half, slip_rate * np.sign(slip)
        expected = np.sign(slip) * k * max(depth, 0) * max(1 + d * closing, 0)
        assert tau == pytest.approx(expected, abs=1e-11)
        assert tau * slip >= -1e-11
        pulled += depth > 0 and 1 + d * closing < 0
    assert pulled > 0  # the clipped branch was visited


def test_elastic_contact_keeps_the_energy_and_damping_takes_it():
    # Inside the kernel, because rotor and contact are not part of a Run.
    rig = dataclasses.replace(rig_of(2, 1), motors=[pl.Motor(0.0, 0.03, 2.0, 100)])
    rig = dataclasses.replace(rig, links=[dataclasses.replace(k, friction=0.0) for k in rig.links])
    kernel, rotor = load_kernel(2, 1), rig.motors[0].inertia
    bare = dataclasses.replace(rig, motors=[dataclasses.replace(rig.motors[0], inertia=0.0)])

    def energy(x, k, half):
        relative = [x[0], x[1] - x[0], x[2], x[3] - x[2]]
        depth = max(abs(x[4] - relative[1]) - half, 0.0)
        return pl.energy(bare, relative) + rotor * x[5] ** 2 / 2 + k * depth**2 / 2

    lost = {}
    for d in (0.0, 0.5):
        settings = pl.Imperfections(gap=0.05, contact_stiffness=300.0, contact_damping=d)
        plant = plant_numbers(rig, settings)
        x = np.zeros(9)
        x[:6] = [0.02, -0.05, 0.0, 0.0, -0.07, 3.0]  # the rotor flies into the gap
        before = energy(x, 300.0, 0.025)
        state = State(x, np.zeros(3), *np.zeros((3, 1)))
        work = np.zeros((12, 9))
        fell = kernel.advance(state, np.zeros(1), 0.0, 0.2, 20000, plant, np.zeros(2), work)
        assert fell < 0
        lost[d] = before - energy(x, 300.0, 0.025)
    assert abs(lost[0.0]) < 1e-6 * rotor * 9 / 2
    assert lost[0.5] > 0.02 * rotor * 9 / 2


def test_dry_friction_saturates_at_its_torque_and_opposes_motion():
    rig = rig_of(2, 1)
    dry = pl.Imperfections(hinge_friction=(0.3, 0.2), presliding=1e-3)
    x = np.array([0.2, -0.1, 0.0, 0.0])
    f, none = pl.nonlinear(rig), np.zeros(1)
    for strain in (-5e-3, -4e-4, 4e-4, 5e-3):
        # The same accelerations come from the friction torques applied as loads on the links.
        friction = np.array([0.3, 0.2]) * np.clip(strain / 1e-3, -1, 1)
        load = np.array([-friction[0] + friction[1], -friction[1]])
        held, _ = slopes(rig, dry, x, anchor=np.array([0.2, -0.1, 0.0]) - strain)
        loaded, _ = slopes(rig, pl.Imperfections(), x, load=load)
        np.testing.assert_allclose(held, loaded, rtol=1e-11, atol=1e-11)
        assert not np.allclose(held, f(x, none))


def test_a_run_starts_with_gears_amid_their_play_and_filters_settled():
    angles, rates = np.array([0.1, -0.2, 0.4]), np.array([1.0, 2.0, -5.0])
    state = _state(np.concatenate([angles, rates]), 3, 2)
    readings = [*angles, rates[0]]
    parts = np.cumsum(angles), np.cumsum(rates), angles[1:], rates[1:], readings
    np.testing.assert_array_equal(state.x, np.concatenate(parts))
    np.testing.assert_array_equal(state.anchor, [*angles, *angles[1:]])


@pytest.mark.parametrize("gap", [0.0, 0.05])
def test_dry_contacts_are_dragged_along_no_further_than_they_reach(gap):
    """Of a gear with play the rotor's contact, else the joint's; where there is no friction, none."""
    rig, rng = rig_of(3, 2), np.random.default_rng(1)
    dry = dict(hinge_friction=(0.3, 0.0, 0.2), gear_friction=(0.1, 0.0))
    plant = plant_numbers(rig, pl.Imperfections(gap=gap, presliding=0.1, **dry))
    for _ in range(20):
        x, anchor = rng.standard_normal(14), rng.standard_normal(5)
        relative = np.diff(x[:3], prepend=0.0)
        contacts = np.concatenate([relative, x[6:8] if gap else relative[1:]])
        dragged = np.where([1, 0, 1, 1, 0], np.clip(anchor, contacts - 0.1, contacts + 0.1), anchor)
        load_kernel(3, 2).drag(x, anchor, plant)
        np.testing.assert_allclose(anchor, dragged, rtol=1e-12)


def test_readings_are_filtered_then_spoiled_then_rounded():
    kernel, rng = load_kernel(3, 2), np.random.default_rng(2)
    quantum, w_out = np.array([0.1, 0.0, 0.3, 0.2]), np.array([0.0, 5.0, 0.0, 0.0])
    for cut in (w_out, 5.0 - w_out):
        x, error, y = rng.standard_normal(14), rng.standard_normal(4), np.zeros(4)
        true = np.append(np.diff(x[:3], prepend=0.0), x[3])
        expected = np.where(cut > 0, x[10:], true) + error
        rounded = quantum * np.floor(expected / np.where(quantum, quantum, 1) + 0.5)
        kernel.read(x, error, quantum, cut, y)
        np.testing.assert_allclose(y, np.where(quantum > 0, rounded, expected), rtol=1e-12)


def test_a_pulse_counts_by_its_share_of_the_step():
    """From 0.2 s to 0.5 s 2 N m on link 2, from 0.3 s on 1 N m on link 1, besides 4 and 5 N m held."""
    kernel, load = load_kernel(2, 1), np.zeros(2)
    pulses = np.array([[1, 0.2, 0.5, 2.0], [0, 0.3, 9.0, 1.0]])
    for t, h, shares in [
        (0.0, 0.2, (0, 0)), (0.1, 0.2, (0, 0.5)), (0.1, 0.8, (0.75, 0.375)), (0.25, 0.1, (0.5, 1)),
        (0.4, 0.2, (1, 0.5)), (0.5, 0.1, (1, 0)),
    ]:  # fmt: skip
        kernel.mean_load(t, h, pulses, load, np.array([4.0, 5.0]))
        np.testing.assert_allclose(load, [4 + shares[0], 5 + 2 * shares[1]], atol=1e-12)


def test_inner_step_follows_the_fastest_motion():
    rig = pl.load("triple")
    ideal, stiff = pl.Imperfections(), pl.Imperfections(gap=0.05, contact_stiffness=1e4)
    # Rigid and without filters, the fastest eigenvalue is that of equation (2).
    eigenvalues = np.linalg.eigvals(pl.linearize(rig).A)
    assert fastest_rate(rig, ideal) == pytest.approx(np.abs(eigenvalues).max(), rel=1e-5)
    assert integration(rig, stiff, 0.01, 1).steps > integration(rig, ideal, 0.01, 1).steps
    clock = integration(rig, dataclasses.replace(ideal, delay=5e-4), 0.01, 1)
    assert (clock.late, clock.steps) == (1, 11)


@pytest.mark.parametrize(
    "dry",
    [
        dict(hinge_friction=1.0),
        dict(gear_friction=1.0),
        dict(gear_friction=1.0, gap=0.05, contact_stiffness=1.0, contact_damping=0.0),
    ],
)
def test_a_dry_contact_is_as_fast_as_its_presliding_is_short(dry):
    # A spring of stiffness torque/presliding: a hundredth of the angle, ten times the frequency.
    rates = [
        fastest_rate(pl.load("triple"), pl.Imperfections(**dry, presliding=reach))
        for reach in (1e-4, 1e-6, 1e-8)
    ]
    assert np.array(rates[1:]) / rates[:-1] == pytest.approx(10, rel=0.02)


def test_the_step_follows_the_fastest_of_plant_and_input_filters():
    rig = rig_of(2, 1)
    fast = dataclasses.replace(rig, filters=pl.Filters((1000.0,), (1.0,) * 3))
    assert fastest_rate(fast, pl.Imperfections(filters=True)) == pytest.approx(2000 * np.pi)


SCRIPT = """
import json, warnings, numpy as np
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    import pendlab as pl
    rig = pl.load("double")
    imperfections = pl.Imperfections(
        filters=True, saturation=True, resolution=1e-3, voltage_resolution=5e-3, delay=5e-4,
        offset=2e-3, noise=1e-4, seed=3, hinge_friction=2e-3, gear_friction=0.5, gap=0.05,
        contact_stiffness=300.0)
    run = pl.simulate(rig, pl.paper_design("double").controller, 1.0, initial=(0.02, -0.01),
                      imperfections=imperfections, disturbance=pl.Pulse(2, 0.3, 0.05, 0.1))
    run = pl.simulate(rig, pl.paper_design("double").controller, 1.0, initial=(0.02, -0.01),
                      imperfections=imperfections, disturbance=pl.Pulse(2, 0.3, 0.05, 0.1))
print(json.dumps([[str(w.message) for w in said if "numba" in str(w.message)],
                  run.angles.tolist(), run.u.tolist(), run.estimate.tolist()]))
"""


def run_script(**environment):
    out = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=os.environ | environment, capture_output=True,
        text=True, check=True, timeout=120,
    )  # fmt: skip
    return json.loads(out.stdout)


def test_plain_python_gives_equal_results_and_says_so_once():
    pytest.importorskip("numba", reason="compares with the compiled code")
    silent, *compiled = run_script(PENDLAB_NUMBA="1", NUMBA_DISABLE_JIT="0")
    said, *plain = run_script(PENDLAB_NUMBA="0")
    assert silent == [] and len(said) == 1 and "without numba" in said[0]
    assert compiled == plain  # to the last bit


def test_kernel_loads_without_any_cache_folder(monkeypatch):
    monkeypatch.setattr("pendlab.bench.cache.cache_folders", lambda: [])
    monkeypatch.setattr(generated, "_compile", lambda module, cache: cache)
    kernel = load_kernel.__wrapped__(2, 1)
    assert kernel.COMPILED is False and (kernel.N, kernel.M) == (2, 1)


def test_the_kernel_takes_few_arguments():
    text = (generated.HERE / "kernel.py").read_text(encoding="utf-8")
    functions = {f.name: f for f in ast.walk(ast.parse(text)) if isinstance(f, ast.FunctionDef)}
    most = {name: 8 for name in functions} | {"run": 11, "hold": 7}
    assert set(generated.COMPILED) == {"accelerate", *functions}
    for name, function in functions.items():
        assert len(function.args.args) <= most[name], name


def test_a_rotor_without_inertia_cannot_have_a_gap():
    rig = dataclasses.replace(rig_of(2, 1), motors=[pl.Motor(1.0, 0.0, 2.0, 100)])
    with pytest.raises(ValueError, match="gap: motor 1 has no rotor inertia"):
        plant_numbers(rig, pl.Imperfections(gap=0.05))
