"""The derivation against Appendix A, against Kane's method, and against itself."""

import numpy as np
import pytest
import sympy as sp
from sympy.physics import mechanics as me

import pendlab as pl

SHAPES = [(2, 1), (3, 1), (3, 2), (4, 2)]


def appendix_a(n):
    """M, N, P, H of Appendix A, n = 2 or 3, as printed, and the symbols they are written in."""
    s = lambda text: sp.symbols(text, positive=True)  # noqa: E731
    l1, l2, g = s("l1 l2 g")
    m1, m2, m3 = s("m1:4")
    a1, a2, a3 = s("a1:4")
    I1, I2, I3 = s("I1:4")
    C1, C2, C3 = s("C1:4")
    G1, G2, cp1, cp2, Ip1, Ip2 = s("G1 G2 c_p1 c_p2 I_p1 I_p2")
    if n == 2:
        m3, l2 = 0, 0
    M1, M2, M3 = m1 * a1 + (m2 + m3) * l1, m2 * a2 + m3 * l2, m3 * a3
    J1 = I1 + m1 * a1**2 + (m2 + m3) * l1**2
    J2 = I2 + m2 * a2**2 + m3 * l2**2
    J3 = I3 + m3 * a3**2
    if n == 2:
        M = sp.Matrix([[J1 + Ip1, l1 * M2 - Ip1], [l1 * M2 - Ip1, J2 + Ip1]])
        N = sp.Matrix([[C1 + C2 + cp1, -C2 - cp1], [-C2 - cp1, C2 + cp1]])
        return M, N, -g * sp.diag(M1, M2), sp.Matrix([G1, -G1])
    M = sp.Matrix(
        [
            [J1 + Ip1, l1 * M2 - Ip1, l1 * M3],
            [l1 * M2 - Ip1, J2 + Ip1 + Ip2, l2 * M3 - Ip2],
            [l1 * M3, l2 * M3 - Ip2, J3 + Ip2],
        ]
    )
    N = sp.Matrix(
        [
            [C1 + C2 + cp1, -C2 - cp1, 0],
            [-C2 - cp1, C2 + C3 + cp1 + cp2, -C3 - cp2],
            [0, -C3 - cp2, C3 + cp2],
        ]
    )
    return M, N, -g * sp.diag(M1, M2, M3), sp.Matrix([[G1, 0], [-G1, G2], [0, -G2]])


@pytest.mark.parametrize("n", [2, 3])
def test_linearisation_is_appendix_a(n):
    motion = pl.derive(n, n - 1)
    ours = (motion.M, motion.N, motion.P, motion.H)
    for mine, printed in zip(ours, appendix_a(n), strict=True):
        assert (mine - printed).expand() == sp.zeros(*printed.shape)
    assert motion.W == sp.Matrix([[1, 0, 0], [-1, 1, 0], [0, -1, 1]])[:n, :n]


def kane(motion, n, m):
    """Mass matrix and forcing of Kane's equations for the same pendulum, built from bodies."""
    q, v = me.dynamicsymbols(f"q1:{n + 1}"), me.dynamicsymbols(f"v1:{n + 1}")
    u = sp.symbols(f"u1:{m + 1}")
    p = motion.parameters
    ground, hinge = me.ReferenceFrame("ground"), me.Point("hinge0")
    hinge.set_vel(ground, 0)
    frames, bodies, loads = [ground], [], []
    for i in range(n):
        frame = ground.orientnew(f"link{i}", "Axis", (-q[i], ground.z))  # clockwise from up
        frame.set_ang_vel(ground, -v[i] * ground.z)
        com = hinge.locatenew(f"com{i}", p["com"][i] * frame.y)
        com.v2pt_theory(hinge, ground, frame)
        inertia = (me.inertia(frame, 0, 0, p["inertia"][i]), com)
        bodies.append(me.RigidBody(f"body{i}", com, frame, p["mass"][i], inertia))
        loads.append((com, -p["mass"][i] * p["g"] * ground.y))
        below = frames[-1]
        relative = v[i] - (v[i - 1] if i else 0)
        friction, motor = p["friction"][i], 0
        if 0 < i <= m:
            friction += p["motor_damping"][i - 1]
            # The rotor takes I_p times the relative acceleration off the motor's torque.
            motor = p["motor_gain"][i - 1] * u[i - 1]
            motor -= p["motor_inertia"][i - 1] * (v[i].diff() - v[i - 1].diff())
        torque = motor - friction * relative  # about -z, from the link below on link i
        loads.append((frame, -torque * ground.z))
        if i:
            loads.append((below, torque * ground.z))
        frames.append(frame)
        new = hinge.locatenew(f"hinge{i + 1}", p["length"][i] * frame.y)
        new.v2pt_theory(hinge, ground, frame)
        hinge = new
    method = me.KanesMethod(ground, q_ind=q, u_ind=v, kd_eqs=[v[i] - q[i].diff() for i in range(n)])
    fr, frstar = method.kanes_equations(bodies, loads)
    rates = [x.diff() for x in v]
    accelerations = sp.symbols(f"alpha1:{n + 1}")
    equations = (fr + frstar).subs(dict(zip(rates, accelerations, strict=True)))
    equations = equations.subs(dict(zip(q, motion.q, strict=True)))
    return equations.subs(dict(zip(v, motion.v, strict=True))), accelerations, u


@pytest.mark.parametrize("n, m", [(2, 1), (3, 1), (3, 2)])
def test_equations_are_those_of_kanes_method(n, m):
    motion = pl.derive(n, m)
    equations, accelerations, u = kane(motion, n, m)
    arguments = (list(motion.q), list(motion.v), list(u), motion.symbols, list(accelerations))
    residual = sp.lambdify(arguments, equations, cse=True)
    rng = np.random.default_rng(n * 10 + m)
    for _ in range(20):
        values = tuple(rng.uniform(0.1, 1.0, len(motion.symbols)))
        q, v = rng.uniform(-3, 3, n), rng.uniform(-5, 5, n)
        volts = rng.uniform(-9, 9, m)
        M, bias = motion.nonlinear(q, v, values)
        H = motion.linear(*values)[-1]
        a = np.linalg.solve(M, -np.ravel(bias) - H @ volts)
        terms = np.abs(M) @ np.abs(a) + np.abs(np.ravel(bias)) + np.abs(H) @ np.abs(volts)
        gap = np.ravel(residual(q, v, volts, values, a))
        np.testing.assert_allclose(gap / terms, 0, atol=1e-12)


@pytest.mark.parametrize("n, m", SHAPES)
def test_mass_matrix_is_symmetric_positive_definite_and_carries_the_kinetic_energy(n, m):
    motion = pl.derive(n, m)
    M = motion.mass_matrix
    assert (M - M.T).expand() == sp.zeros(n)
    assert sp.expand((motion.v.T * M * motion.v)[0] / 2 - motion.kinetic) == 0
    rng = np.random.default_rng(0)
    for _ in range(10):
        matrix, _ = motion.nonlinear(
            rng.uniform(-3, 3, n), np.zeros(n), tuple(rng.uniform(0.1, 1, len(motion.symbols)))
        )
        assert np.linalg.eigvalsh(matrix)[0] > 0


@pytest.mark.parametrize("n, m", [(2, 0), (2, 1), (3, 2)])
def test_energy_falls_at_twice_the_dissipation(n, m):
    """dE/dt = v' M a + dE/dq v with M a = -bias equals -2 D, symbolically."""
    motion = pl.derive(n, m)
    v, gradient = motion.v, sp.Matrix([motion.energy]).jacobian(motion.q)
    rate = (-v.T * motion.bias)[0] + (gradient * v)[0]
    assert sp.simplify(sp.expand(rate + 2 * motion.dissipation)) == 0


def test_simple_pendulum_in_closed_form():
    motion = pl.derive(1, 0)
    (theta,), p = motion.q, motion.parameters
    m, a, inertia, C = (p[name][0] for name in ("mass", "com", "inertia", "friction"))
    g = p["g"]
    assert motion.mass_matrix == sp.Matrix([[inertia + m * a**2]])
    assert sp.simplify(motion.bias[0] - (C * motion.v[0] - m * g * a * sp.sin(theta))) == 0


def test_parameters_follow_the_rig(triple):
    motion = pl.derive(3, 2)
    values = dict(zip(motion.symbols, motion.values(triple), strict=True))
    assert values[motion.parameters["com"][2]] == triple.links[2].com
    assert values[motion.parameters["motor_gain"][1]] == triple.motors[1].gain
    assert values[motion.parameters["g"]] == triple.g
    assert [str(s) for s in motion.u] == ["u1", "u2"]


def test_repeated_calls_cost_nothing():
    assert pl.derive(3, 2) is pl.derive(3, 2)


def test_six_links():
    """Derived once, large, and still right: the linear part against sums written by hand."""
    motion = pl.derive(6, 3)
    assert motion.M.shape == (6, 6) and motion.H.shape == (6, 3)
    values = np.random.default_rng(6).uniform(0.1, 1, len(motion.symbols))
    named = dict(zip(map(str, motion.symbols), values, strict=True))
    M = np.asarray(motion.linear(*values)[1], float)
    assert M[4, 5] == pytest.approx(named["l5"] * named["m6"] * named["a6"])
    J5 = named["I5"] + named["m5"] * named["a5"] ** 2 + named["m6"] * named["l5"] ** 2
    assert M[4, 4] == pytest.approx(J5)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((0, 0), "n_links: expected a whole number from 1 to 8, found 0"),
        ((2.0, 1), "n_links: expected a whole number from 1 to 8, found 2.0"),
        ((True, 0), "n_links"),
        (("3", 2), "n_links"),
        ((3, -1), "n_motors: expected a whole number of at least 0, found -1"),
        ((3, 3), "n_motors: 3 links take 0 to 2 motors .* found 3"),
    ],
)
def test_bad_numbers(arguments, message):
    pl.derive(2, 1)  # a remembered result must not let 2.0 pass
    with pytest.raises(ValueError, match=message):
        pl.derive(*arguments)
