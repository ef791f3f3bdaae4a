"""Checks of notebook A: Lagrange's equations, changed a little and derived anew."""

from dataclasses import replace

import numpy as np

from ...lagrange import derive
from ...models import linearize
from ...parameters import load
from .judging import all_right, compare, on
from .symbolic import compare_formula


def exercise_1(M_tip=None, P_tip=None, rig=None):
    """Mass matrix and stiffness of the double with a point mass on the tip of link 2.

    A third link whose mass sits in its own lower hinge is such a mass.
    """
    motion, double = derive(3, 1), derive(2, 1)
    in_hinge = {motion.parameters[name][2]: 0 for name in ("inertia", "com", "friction")}
    M, P = (X.subs(in_hinge)[:2, :2] for X in (motion.M, motion.P))
    mass = motion.parameters["mass"][2]
    (l1, l2), a2 = motion.parameters["length"][:2], motion.parameters["com"][1]
    at_com = "Your mass sits in link 2's centre of mass; the tip is at l2 from the hinge."
    untouched = "is still that without the mass; the mass has kinetic and potential energy."
    lonely = (
        "The hinge between the links carries the tip along: its position, and so its energy, "
        "depends on the angle of link 1 too."
    )
    alone = M.subs(l1, 0) - double.M.subs(l1, 0)
    return all_right(
        compare_formula(
            "M_tip",
            M_tip,
            M,
            [
                (P, "You gave the stiffness first; the order is M_tip, P_tip."),
                (double.M, f"M_tip {untouched}"),
                (double.M + (M - double.M).subs(l2, a2), at_com),
                (double.M + alone, lonely),
                (double.M + 2 * (M - double.M), "Kinetic energy is one half of m v^2."),
                (
                    double.M - (M - double.M),
                    "Kinetic energy of the mass adds to T; check its sign.",
                ),
            ],
            new=mass,
        ),
        compare_formula(
            "P_tip",
            P_tip,
            P,
            [
                (double.P, f"P_tip {untouched}"),
                (double.P + (P - double.P).subs(l2, a2), at_com),
                (double.P + (P - double.P).subs(l1, 0), lonely),
                (
                    double.P - (P - double.P),
                    "Upright, the mass is at its highest: which sign has the curvature of m g y?",
                ),
            ],
            praise="Inertia and gravity change; friction and motor know nothing of the mass.",
            new=mass,
        ),
    )


def exercise_2(M_belt=None, H_belt=None, rig=None):
    """Mass matrix and input of the double with the motor on the ground, driving link 2 by a belt."""
    free, double = derive(2, 0), derive(2, 1)
    rotor, G = (double.parameters[name][0] for name in ("motor_inertia", "motor_gain"))
    on_1, on_2 = (_only(double.M, {(i, i): rotor}) for i in (0, 1))
    reaction, both = _only(double.H, {0: G}), _only(double.H, {0: -G, 1: -G})
    M, H = free.M + on_2, _only(double.H, {1: -G})
    return all_right(
        compare_formula(
            "M_belt",
            M_belt,
            M,
            [
                (H, "You gave the input first; the order is M_belt, H_belt."),
                (
                    double.M,
                    "Your rotor still turns with the relative rate; the belt ties it to one angle.",
                ),
                (free.M, "Your rotor stores no energy at all; it turns with the rate of link 2."),
                (free.M + on_1, "Your rotor turns with link 1; which link does the belt drive?"),
                (free.M + on_1 + on_2, "One rotor turns with one rate; yours is counted twice."),
                (free.M + 2 * on_2, "Kinetic energy is one half of I omega^2."),
            ],
        ),
        compare_formula(
            "H_belt",
            H_belt,
            H,
            [
                (-H, "H stands on the left side of the equation of motion: H = -dQ/du."),
                (
                    double.H,
                    "Your motor still pushes link 1 back; now the ground takes the reaction.",
                ),
                (
                    -double.H,
                    "Your motor still pushes link 1 back; now the ground takes the reaction.",
                ),
                (
                    reaction,
                    "Your motor turns link 1; do the virtual work again: which angle moves?",
                ),
                (both, "Your motor turns both links; which angle does its work depend on?"),
            ],
            praise="The sum is no longer zero: this motor can push the pendulum as a whole.",
        ),
    )


@on("double")
def exercise_3(P_hanging=None, unstable_hanging=None, rig=None):
    """Stiffness about hanging straight down, and the number of unstable eigenvalues there.

    Hanging is standing upright where gravity points up: g changes its sign and nothing else does.
    """
    motion = derive(2, 1)
    g = motion.parameters["g"]
    P = motion.P.subs(g, -g)
    one_turned = (
        "One of your links still stands on its head: the angles are absolute, and link 2 points "
        "down when its own angle is pi."
    )
    _, M, N, down, _ = motion.linear(*motion.values(rig)[:-1], -rig.g)
    return all_right(
        compare_formula(
            "P_hanging",
            P_hanging,
            P,
            [
                (motion.P, "That is the stiffness upright; put pi for the angles, not 0."),
                (_only(P, {(0, 0): P[0, 0], (1, 1): -P[1, 1]}), one_turned),
                (_only(P, {(0, 0): -P[0, 0], (1, 1): P[1, 1]}), one_turned),
            ],
        ),
        _count(
            "unstable_hanging",
            unstable_hanging,
            np.sum(_eigenvalues(M, N, down).real > 0),
            "Does a pendulum that hangs fall anywhere? Put P_hanging, not P, into the state "
            "matrices and count the eigenvalues with a positive real part.",
        ),
    )


def exercise_4(unstable_four, rig=None):
    """Number of unstable eigenvalues of four links with three motors."""
    triple = load("triple") if rig is None else rig
    links, motors = (*triple.links, triple.links[2]), (*triple.motors, triple.motors[1])
    longer = replace(triple, links=links, motors=motors, u_max=(), filters=None)
    return _count(
        "unstable_four",
        unstable_four,
        np.sum(linearize(longer).poles().real > 0),
        "Motors and friction decide how fast it falls, not in how many ways. Count the eigenvalues "
        "with a positive real part, the slow ones included.",
    )


@on("double", own="'A.5', slow_half, rig=own")
def exercise_5(slow_half, rig=None):
    """Slow unstable eigenvalue of a double whose gearbox has half the ratio, 1/s."""
    half = {"gain": 2, "inertia": 4, "damping": 4}
    truth, fast = _unstable(_geared(rig, half))
    advice = "Torque goes with the ratio, reflected inertia and drag go with its square."
    linearly = "Something of the motor went with the wrong power of the ratio. " + advice
    return compare(
        "slow_half",
        slow_half,
        truth,
        [
            (_unstable(rig)[0], "That is the rig as it is; " + advice[0].lower() + advice[1:]),
            (fast, "That is the fast eigenvalue; the slow one folds the pendulum at its hinge."),
            (_unstable(_geared(rig, dict.fromkeys(half, 2)))[0], linearly),
            (_unstable(_geared(rig, {"inertia": 4}))[0], linearly),
            (_unstable(_geared(rig, {"gain": 2}))[0], linearly),
            (
                _unstable(_geared(rig, {name: 1 / by for name, by in half.items()}))[0],
                "That is twice the ratio; half of it is asked for.",
            ),
        ],
        tolerance=2e-3,
        praise="Folding is a balance of gravity against drag: a quarter of the drag, so much faster.",
    )


def _count(name, answer, truth, hint):
    return compare(name, answer, truth, [(k, hint) for k in range(20) if k != truth])


def _only(like, entries):
    """A matrix of zeros of the same size but for some entries."""
    result = (like * 0).as_mutable()
    for place, value in entries.items():
        result[place] = value
    return result


def _eigenvalues(M, N, P):
    n = len(M)
    lower = np.linalg.solve(M, -np.hstack([P, N]))
    return np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), lower]))


def _geared(rig, by):
    """The rig with fields of motor 1 divided by the given numbers."""
    motor = rig.motors[0]
    changed = replace(motor, **{name: getattr(motor, name) / k for name, k in by.items()})
    return replace(rig, motors=(changed, *rig.motors[1:]))


def _unstable(rig):
    """Smallest and largest of the unstable eigenvalues."""
    values = linearize(rig).poles().real
    return min(values[values > 0]), max(values)
