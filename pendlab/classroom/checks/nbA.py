"""Checks of notebook A: Lagrange's equations, changed a little and derived anew."""

from dataclasses import replace

import numpy as np

from ...lagrange import derive
from .judging import all_right, asks, on
from .nb00 import growth
from .symbolic import compare_formula


def exercise_1(M_tip=None, P_tip=None, rig=None):
    """Mass matrix and stiffness of the double with a point mass on the tip of link 2."""
    return all_right(_M_tip(M_tip), _P_tip(P_tip))


def _with_tip():
    """M, P and parameters of the triple whose third mass sits in its own lower hinge."""
    motion = derive(3, 1)
    in_hinge = {motion.parameters[name][2]: 0 for name in ("inertia", "com", "friction")}
    return *(X.subs(in_hinge)[:2, :2] for X in (motion.M, motion.P)), motion.parameters


UNTOUCHED = "{} is still that without the mass; the mass has kinetic and potential energy."
AT_COM = "Your mass sits in link 2's centre of mass; the tip is at l2 from the hinge."
LONELY = (
    "The hinge between the links carries the tip along: its position, and so its energy, "
    "depends on the angle of link 1 too."
)


@asks("M_tip", compare_formula, new="m3")
def _M_tip(rig):
    (M, P, parameters), bare = _with_tip(), derive(2, 1).M
    (l1, l2), a2 = parameters["length"][:2], parameters["com"][1]
    yield M, None
    yield P, "You gave the stiffness first; the order is M_tip, P_tip."
    yield bare, UNTOUCHED.format("M_tip")
    yield bare + (M - bare).subs(l2, a2), AT_COM
    yield bare + (M - bare).subs(l1, 0), LONELY
    yield bare + 2 * (M - bare), "Kinetic energy is one half of m v^2."
    yield bare - (M - bare), "Kinetic energy of the mass adds to T; check its sign."


@asks("P_tip", compare_formula, new="m3")
def _P_tip(rig):
    (_, P, parameters), bare = _with_tip(), derive(2, 1).P
    (l1, l2), a2 = parameters["length"][:2], parameters["com"][1]
    yield P, "Hold your prediction against both."
    yield bare, UNTOUCHED.format("P_tip")
    yield bare + (P - bare).subs(l2, a2), AT_COM
    yield bare + (P - bare).subs(l1, 0), LONELY
    sign = "Upright, the mass is at its highest: which sign has the curvature of m g y?"
    yield bare - (P - bare), sign


def exercise_2(M_belt=None, H_belt=None, rig=None):
    """Mass matrix and input of the double with a motor on the ground, a belt away from link 2."""
    return all_right(_M_belt(M_belt), _H_belt(H_belt))


@asks("M_belt", compare_formula)
def _M_belt(rig):
    free, double = derive(2, 0).M, derive(2, 1)
    rotor, gain = (double.parameters[name][0] for name in ("motor_inertia", "motor_gain"))
    on_1, on_2 = (_only(free, {(i, i): rotor}) for i in (0, 1))
    yield free + on_2, None
    yield _only(double.H, {1: -gain}), "You gave the input first; the order is M_belt, H_belt."
    relative = "Your rotor still turns with the relative rate; the belt ties it to one angle."
    yield double.M, relative
    yield free, "Your rotor stores no energy at all; it turns with the rate of link 2."
    yield free + on_1, "Your rotor turns with link 1; which link does the belt drive?"
    yield free + on_1 + on_2, "One rotor turns with one rate; yours is counted twice."
    yield free + 2 * on_2, "Kinetic energy is one half of I omega^2."


@asks("H_belt", compare_formula)
def _H_belt(rig):
    double = derive(2, 1)
    gain = double.parameters["motor_gain"][0]
    H = _only(double.H, {1: -gain})
    yield H, "Now add up its entries, and those of the motor at the hinge."
    yield -H, "H stands on the left side of the equation of motion: H = -dQ/du."
    for reacting in (double.H, -double.H):
        back = "Your motor still pushes link 1 back; now the ground takes the reaction."
        yield reacting, back
    turned = "Your motor turns link 1; do the virtual work again: which angle moves?"
    yield _only(double.H, {0: gain}), turned
    both = "Your motor turns both links; which angle does its work depend on?"
    yield _only(double.H, {0: -gain, 1: -gain}), both


@on("double")
def exercise_3(P_hanging=None, unstable_hanging=None, rig=None):
    """Stiffness about hanging straight down, and the number of unstable eigenvalues there."""
    return all_right(_P_hanging(P_hanging), _unstable_hanging(unstable_hanging, rig))


@asks("P_hanging", compare_formula)
def _P_hanging(rig):
    P = derive(2, 1).P
    yield -P, None  # where gravity points up, and nothing else changes
    yield P, "That is the stiffness upright; put pi for the angles, not 0."
    for first, second in ((-1, 1), (1, -1)):
        turned = (
            "One of your links still stands on its head: the angles are absolute, and link 2 "
            "points down when its own angle is pi."
        )
        yield _only(P, {(0, 0): first * P[0, 0], (1, 1): second * P[1, 1]}), turned


@asks("unstable_hanging")
def _unstable_hanging(rig):
    _, M, N, P, _ = derive(2, 1).linear(*derive(2, 1).values(rig)[:-1], -rig.g)
    n = len(M)
    A = np.vstack([np.eye(n, 2 * n, n), np.linalg.solve(M, -np.hstack([P, N]))])
    hint = (
        "Put P_hanging, not P, into the state matrices and count the eigenvalues with a positive "
        "real part."
    )
    return _counted(np.sum(np.linalg.eigvals(A).real > 0), hint)


@on("triple")
@asks("unstable_four")
def exercise_4(rig):
    """Number of unstable eigenvalues of four links with three motors."""
    links, motors = (*rig.links, rig.links[2]), (*rig.motors, rig.motors[1])
    longer = replace(rig, links=links, motors=motors, u_max=(), filters=None)
    hint = "Count the eigenvalues with a positive real part, the slow ones included."
    return _counted(len(growth(longer)), hint)


def _counted(truth, hint):
    yield truth, None
    for other in range(20):
        yield other, hint


@on("double", own="'A.5', slow_half, rig=own")
@asks("slow_half")
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
    power = (
        "Something of the motor went with the wrong power of the ratio. Torque goes with the "
        "ratio, reflected inertia and drag go with its square."
    )
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
