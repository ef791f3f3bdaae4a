"""Equations of motion of an n-link pendulum, derived by SymPy from its energies (Appendix A)."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy as sp

from ._arguments import instance, whole
from .parameters import Pendulum


@dataclass(frozen=True)
class EquationsOfMotion:
    """Lagrange's equations M(q) dv/dt + bias(q, v) + H u = 0 in absolute angles from upright.

    Attributes
    ----------
    q, v, u : angles (rad), angular rates (rad/s), motor voltages (V), as n x 1 or m x 1 matrices
    parameters : symbols by the fields of `Link` and, behind ``motor_``, of `Motor`, such as
        ``parameters["mass"][0]`` = m1; and ``parameters["g"]``
    kinetic, potential : energies, J, including the reflected inertia of the rotors
    dissipation : Rayleigh's function, W (half the power lost to viscous friction)
    mass_matrix, bias : M(q), n x n, and bias(q, v), n x 1
    W, M, N, P, H : Appendix A: relative angles are W q, and near upright
        M d2q/dt2 + N dq/dt + P q + H u = 0
    """

    q: sp.Matrix
    v: sp.Matrix
    u: sp.Matrix
    parameters: dict
    kinetic: sp.Expr
    potential: sp.Expr
    dissipation: sp.Expr
    mass_matrix: sp.Matrix
    bias: sp.Matrix
    W: sp.Matrix
    M: sp.Matrix
    N: sp.Matrix
    P: sp.Matrix
    H: sp.Matrix

    @property
    def energy(self):
        """Kinetic plus potential energy, J; falls at the rate 2 x dissipation when u = 0."""
        return self.kinetic + self.potential

    @property
    def symbols(self):
        """All parameter symbols as one flat tuple, in the order of `values`."""
        flat = [s for name, group in self.parameters.items() if name != "g" for s in group]
        return (*flat, self.parameters["g"])

    @staticmethod
    def values(rig):
        """The numbers of `rig` for `symbols`."""
        instance("rig", rig, Pendulum, 'pl.load("double")')
        values = [getattr(link, name) for name in LINK_LETTERS for link in rig.links]
        values += [getattr(motor, name) for name in MOTOR_LETTERS for motor in rig.motors]
        return (*map(float, values), rig.g)

    @cached_property
    def linear(self):
        """NumPy function of `symbols` that returns W, M, N, P, H."""
        return sp.lambdify(self.symbols, [self.W, self.M, self.N, self.P, self.H], cse=True)

    @cached_property
    def nonlinear(self):
        """NumPy function of q, v (sequences) and `symbols` that returns mass matrix and bias."""
        arguments = (list(self.q), list(self.v), self.symbols)
        return sp.lambdify(arguments, [self.mass_matrix, self.bias], modules="numpy", cse=True)

    @cached_property
    def total_energy(self):
        """NumPy function of q, v (sequences) and `symbols` that returns the energy, J."""
        return sp.lambdify((list(self.q), list(self.v), self.symbols), self.energy, cse=True)


# Field of Link or Motor -> the paper's letter.
LINK_LETTERS = dict(length="l", mass="m", inertia="I", com="a", friction="C")
MOTOR_LETTERS = dict(damping="c_p", inertia="I_p", gain="G")


def derive(n_links, n_motors):
    """`EquationsOfMotion` of a pendulum with `n_links` links and motors on hinges 2 to n_motors+1.

    Lagrange's equations with viscous friction, d/dt dT/dv - dT/dq + dV/dq + dD/dv = Q, where motor
    i with voltage u_i turns link i+1 with the torque G_i u_i and link i with the opposite one. The
    rotor's inertia, reflected to the output shaft, turns with the relative rate of its hinge.

    One link gives the simple pendulum, no motor the free one; there are at most n_links - 1 motors.
    Source: Appendix A of the paper, equations (i)-(iii).

    >>> pl.derive(2, 1).H
    Matrix([
    [ G1],
    [-G1]])
    """
    n = whole("n_links", n_links, least=1, most=8)
    m = whole("n_motors", n_motors)
    if m > n - 1:
        raise ValueError(
            f"n_motors: {n} links take 0 to {n - 1} motors (hinge 1 is free), found {m}."
        )
    return _derive(n, m)


@lru_cache
def _derive(n, m):
    q, v, u = (
        sp.ImmutableMatrix(count, 1, _symbols(letter, count, real=True))
        for letter, count in (("theta", n), ("omega", n), ("u", m))
    )
    parameters = {name: _symbols(letter, n) for name, letter in LINK_LETTERS.items()}
    parameters |= {f"motor_{name}": _symbols(letter, m) for name, letter in MOTOR_LETTERS.items()}
    lengths, masses, inertias, coms, frictions, dampings, rotors, gains = parameters.values()
    parameters["g"] = g = sp.Symbol("g", positive=True)
    W = sp.Matrix(n, n, lambda i, j: int(i == j) - int(i == j + 1))
    relative_rates = W * v

    # Energies: positions of the centres of mass, their velocities, rotation of links and rotors.
    kinetic, potential, hinge = 0, 0, sp.zeros(2, 1)
    for i in range(n):
        upward = sp.Matrix([sp.sin(q[i]), sp.cos(q[i])])  # along the link
        centre = hinge + coms[i] * upward
        velocity = centre.jacobian(q) * v
        kinetic += (masses[i] * velocity.dot(velocity) + inertias[i] * v[i] ** 2) / 2
        potential += masses[i] * g * centre[1]
        hinge += lengths[i] * upward
    kinetic += sum(rotors[i] * relative_rates[i + 1] ** 2 for i in range(m)) / 2
    dissipation = sum(frictions[i] * relative_rates[i] ** 2 for i in range(n)) / 2
    dissipation += sum(dampings[i] * relative_rates[i + 1] ** 2 for i in range(m)) / 2

    # cos a cos b + sin a sin b = cos(a - b) folds the mass matrix into its textbook form.
    mass_matrix = sp.hessian(kinetic, list(v))
    for fold in (sp.expand, sp.fu, sp.expand):
        mass_matrix = mass_matrix.applyfunc(fold)
    kinetic = sp.expand((v.T * mass_matrix * v)[0] / 2)
    bias = (mass_matrix * v).jacobian(q) * v + (potential - kinetic).diff(q) + dissipation.diff(v)
    bias = bias.applyfunc(sp.expand)

    matrices = mass_matrix, bias.jacobian(v), bias.jacobian(q)
    M, N, P = (matrix.subs(dict.fromkeys([*q, *v], 0)) for matrix in matrices)
    H = W[:, :m] * sp.diag(*gains)
    energies = kinetic, potential, dissipation
    return EquationsOfMotion(q, v, u, parameters, *energies, mass_matrix, bias, W, M, N, P, H)


def _symbols(letter, count, **kind):
    """letter1, letter2, ...: positive numbers where no other `kind` is named."""
    return sp.symbols(f"{letter}1:{count + 1}", **(kind or dict(positive=True)))
