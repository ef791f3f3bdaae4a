"""Checks of notebook A: Lagrange's equations, changed a little and derived anew."""

from dataclasses import replace

import numpy as np

import pendlab as pl

from .judging import asks
from .nb00 import growth


@asks("M_tip", "P_tip", new="m3")
def exercise_1(rig):
    """Mass matrix and stiffness of the double with a point mass on the tip of link 2."""
    triple, double = pl.derive(3, 1), pl.derive(2, 1)  # the third mass in its own lower hinge
    in_hinge = {triple.parameters[name][2]: 0 for name in ("inertia", "com", "friction")}
    M, P = (X.subs(in_hinge)[:2, :2] for X in (triple.M, triple.P))
    added_M, added_P = M - double.M, P - double.P
    (l1, l2), a2 = triple.parameters["length"][:2], triple.parameters["com"][1]
    untouched = "{} is still that without the mass; the mass has kinetic and potential energy."
    at_com = "Your mass sits in link 2's centre of mass; the tip is at l2 from the hinge."
    lonely = """The hinge between the links carries the tip along: its position, and so its energy,
        depends on the angle of link 1 too."""
    yield M, None
    yield P, "You gave the stiffness first; the order is M_tip, P_tip."
    yield double.M, untouched.format("M_tip")
    yield double.M + added_M.subs(l2, a2), at_com
    yield double.M + added_M.subs(l1, 0), lonely
    yield double.M + 2 * added_M, "Kinetic energy is one half of m v^2."
    yield double.M - added_M, "Kinetic energy of the mass adds to T; check its sign."

    yield "P_tip"
    yield P, "Hold your prediction against both."
    yield double.P, untouched.format("P_tip")
    yield double.P + added_P.subs(l2, a2), at_com
    yield double.P + added_P.subs(l1, 0), lonely
    sign = "Upright, the mass is at its highest: which sign has the curvature of m g y?"
    yield double.P - added_P, sign


@asks("M_belt", "H_belt")
def exercise_2(rig):
    """Mass matrix and input of the double with a motor on the ground, a belt away from link 2."""
    free, double = pl.derive(2, 0).M, pl.derive(2, 1)
    rotor, gain = (double.parameters[name][0] for name in ("motor_inertia", "motor_gain"))
    on_1, on_2 = (_only(free, {(i, i): rotor}) for i in (0, 1))
    H = _only(double.H, {1: -gain})
    yield free + on_2, None
    yield H, "You gave the input first; the order is M_belt, H_belt."
    relative = "Your rotor still turns with the relative rate; the belt ties it to one angle."
    yield double.M, relative
    yield free, "Your rotor stores no energy at all; it turns with the rate of link 2."
    yield free + on_1, "Your rotor turns with link 1; which link does the belt drive?"
    yield free + on_1 + on_2, "One rotor turns with one rate; yours is counted twice."
    yield free + 2 * on_2, "Kinetic energy is one half of I omega^2."

    yield "H_belt"
    yield H, "Now add up its entries, and those of the motor at the hinge."
    yield -H, "H stands on the left side of the equation of motion: H = -dQ/du."
    for reacting in (double.H, -double.H):
        yield reacting, "Your motor still pushes link 1 back; now the ground takes the reaction."
    turned = "Your motor turns link 1; do the virtual work again: which angle moves?"
    yield _only(double.H, {0: gain}), turned
    both = "Your motor turns both links; which angle does its work depend on?"
    yield _only(double.H, {0: -gain, 1: -gain}), both


@asks("P_hanging", "unstable_hanging", base="double")
def exercise_3(rig):
    """Stiffness about hanging straight down, and the number of unstable eigenvalues there."""
    double = pl.derive(2, 1)
    upper, lower = (_only(double.P, {(i, i): double.P[i, i]}) for i in (1, 0))
    yield -double.P, None  # where gravity points up, and nothing else changes
    yield double.P, "That is the stiffness upright; put pi for the angles, not 0."
    for turned in (upper - lower, lower - upper):
        head = """One of your links still stands on its head: the angles are absolute, and link 2
            points down when its own angle is pi."""
        yield turned, head

    yield "unstable_hanging"
    _, M, N, P, _ = double.linear(*double.values(rig)[:-1], -rig.g)
    A = np.vstack([np.eye(2, 4, 2), np.linalg.solve(M, -np.hstack([P, N]))])
    hint = """Put P_hanging, not P, into the state matrices and count the eigenvalues with a
        positive real part."""
    yield from _counted(np.sum(np.linalg.eigvals(A).real > 0), hint)


@asks("unstable_four", base="triple")
def exercise_4(rig):
    """Number of unstable eigenvalues of four links with three motors."""
    links, motors = (*rig.links, rig.links[2]), (*rig.motors, rig.motors[1])
    longer = replace(rig, links=links, motors=motors, u_max=(), filters=None)
    hint = "Count the eigenvalues with a positive real part, the slow ones included."
    yield from _counted(len(growth(longer)), hint)


def _counted(truth, hint):
    yield truth, None
    for other in range(20):
        yield other, hint


@asks("slow_half", base="double", own="'A.5', slow_half, rig=own")
def exercise_5(rig):
    """Slow unstable eigenvalue of a double whose gearbox has half the ratio, 1/s."""

    def slow(which=-1, **by):
        """An unstable eigenvalue with fields of motor 1 divided by the given numbers."""
        motor = rig.motors[0]
        changed = {name: getattr(motor, name) / k for name, k in by.items()}
        return growth(replace(rig, motors=(replace(motor, **changed), *rig.motors[1:])))[which]

    half = {"gain": 2, "inertia": 4, "damping": 4}
    yield slow(**half), "Now hold it against your prediction."
    yield slow(), "That is the rig as it is; replace gain, inertia and damping of its motor."
    yield slow(0, **half), "That is the fast eigenvalue; the slow one is asked for."
    power = """Something of the motor went with the wrong power of the ratio. Torque goes with the
        ratio, reflected inertia and drag go with its square."""
    for wrong in (dict.fromkeys(half, 2), {"inertia": 4}, {"gain": 2}):
        yield slow(**wrong), power
    twice = {name: 1 / by for name, by in half.items()}
    yield slow(**twice), "That is twice the ratio; half of it is asked for."


def _only(like, entries):
    """A matrix of zeros of the same size but for some entries."""
    result = (like * 0).as_mutable()
    for place, value in entries.items():
        result[place] = value
    return result
