"""Checks of notebook 04: integrator, turns, observers, k_p."""

from dataclasses import replace

import control
import numpy as np
from scipy.linalg import solve_discrete_are

from ..._arguments import number
from ...controllers import controller
from ...gain import lqr
from ...loop import frequency_response, margins, open_loop, state_feedback_loop
from ...nyquist import encirclements
from ...observers import Observer, observer_family
from ...paper.alignment import alignment_interval
from ...paper.designs import paper_design
from ...paper.ledger import published
from ...sampled import add_integrator
from ...studies.transmission import rms
from .judging import Verdict, compare

OFFSET = 0.01  # rad, on the sensor of theta2 - theta1
SIGMA = (1e-3, 1e-3, 1e-2)  # rad, rad, rad/s: noise of the readings in exercise 7
DISTANCE, NOISE = 0.91, 0.2  # from -1, V: what exercise 7 asks for


def exercise_1(final_angle, rig=None):
    """Angle at which the double settles with an offset in the sensor that is integrated, rad."""
    double = _design("double", rig)
    plant, F = double.augmented, double.F
    A, B = plant.A, plant.B
    pushed = -B @ F @ [0, OFFSET, 0, 0, 0] - double.dt * OFFSET * np.eye(5)[4]
    settled = np.linalg.solve(np.eye(5) - A + B @ F, pushed)[1]
    plain = replace(double, Q=double.Q[:4], tracked=()).F
    A, B = double.model.A, double.model.B
    without = np.linalg.solve(np.eye(4) - A + B @ plain, -B @ plain @ [0, OFFSET, 0, 0])[1]

    def after(seconds):
        """The angle at a time when the integrator is still at work."""
        loop = A_w - B_w @ F
        return settled - (np.linalg.matrix_power(loop, round(seconds / double.dt)) @ rest)[1]

    A_w, B_w = plant.A, plant.B
    rest = np.linalg.solve(np.eye(5) - A_w + B_w @ F, pushed)
    early = (
        "Has it settled? The integrator is slow: plot the angle, and wait until it moves no more."
    )
    return compare(
        "final_angle",
        final_angle,
        settled,
        [
            *(
                (after(seconds), early)
                for seconds in (2, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 60)
            ),
            (0.0, "That is what the sensor shows in the end. The true angle is asked for."),
            (-settled, "The sign: the sensor shows the true angle plus its offset."),
            (without, "That is without the integrator; use `double.F` with its fifth entry."),
        ],
        tolerance=0.02,  # a simulation of a minute or two has not quite settled
        praise="The integrator is as good as the sensor that it integrates.",
    )


def exercise_2(answers, rig=None):
    """(turns, unstable closed-loop eigenvalues) of the double's loop times 0.4, 1 and 20."""
    double = _design("double", rig)
    loops = (state_feedback_loop(double.augmented, k * double.F) for k in (0.4, 1.0, 20.0))
    counts = [encirclements(loop) for loop in loops]
    truth = np.array([(count.turns, count.unstable_closed) for count in counts], dtype=float)
    turns, unstable = truth.T
    opened = counts[0].unstable_open

    def pairs(first, second):
        return np.column_stack([first, second])

    return compare(
        "answers",
        answers,
        truth,
        [
            (pairs(unstable, turns), "The pairs are the other way round: (turns, unstable)."),
            (pairs(-turns, unstable), "Turns are counted anticlockwise here."),
            (
                pairs(turns / 2, unstable),
                "That is the upper half of the contour; count both halves.",
            ),
            (
                pairs(turns + 1, unstable),
                "You stepped round z = 1 on the inside, where one more pole is outside the contour; "
                "pl.encirclements steps round it on the outside.",
            ),
            (
                pairs(turns, turns * 0 + opened),
                "Those are the open-loop eigenvalues; P - Z = turns.",
            ),
            (pairs(turns * 0 + opened, unstable), "Turns = P - Z; they change with Z."),
        ],
        apart=True,
        praise="In each pair, turns and unstable eigenvalues add up to the number of the open loop.",
    )


def exercise_3(ripple, rig=None):
    """Ratio of the controllers' gains from theta1 to the voltage at z = -1, observer 2 to 1."""
    systems = [paper_design("double", observer=n).controller.system for n in (1, 2)]

    def ratio(omega, sensor=0):
        gains = [frequency_response(system, omega)[0, 0, sensor] for system in systems]
        return abs(gains[1]) / abs(gains[0])

    truth = ratio(np.pi / systems[0].dt)
    direct = [abs(system.D[0, 0]) for system in systems]
    other = "That is another sensor; theta1 is the first input of the controller."
    return compare(
        "ripple",
        ripple,
        truth,
        [
            (20 * np.log10(truth), "That is in decibels; give the factor itself."),
            (
                direct[1] / direct[0],
                "Only L1 counted; the observer's state adds its share at z = -1.",
            ),
            (ratio(50.0), "Half the sampling rate is 50 Hz; frequencies go in as rad/s."),
            (ratio(np.pi / systems[0].dt, 1), other),
            (ratio(np.pi / systems[0].dt, 2), other),
            (1 / truth, "That is observer 1 against observer 2; turn it round."),
        ],
        praise="Observer 2 differentiates theta1, and a motor would shake with it.",
    )


def exercise_4(kp_low, rig=None):
    """Lower end of the interval of k_p with two unstable eigenvalues, V/rad."""
    triple = _design("triple", rig)
    A, B, C = triple.model.A, triple.model.B, triple.model.C

    def at_one(motor, output):
        return -1 / (C[output] @ np.linalg.solve(np.eye(len(A)) - A, B[:, motor]))

    truth = at_one(1, 2)
    plant = triple.plant
    mixed = -1 / (C[2] @ np.linalg.solve(np.eye(len(A)) - plant.A, plant.B[:, 1]))
    printed = published("eq18.k_p_interval").values[0]
    return compare(
        "kp_low",
        kp_low,
        truth,
        [
            (printed, "That is the paper's printed number; the parameters give another."),
            (
                alignment_interval(triple.model)[1],
                "That is the upper end; there a pair leaves the circle.",
            ),
            (alignment_interval(triple.filtered)[1], "That is the upper end, with filters."),
            (-truth, "The sign: A_t1 = A_t - B_t2 k_p C_p C_t, so I - A_t1 has a plus."),
            (mixed, "I - A belongs to the sampled model; for the continuous one it is 0 - A."),
            (at_one(0, 2), "That is motor 1's column; the spring is made by motor 2."),
            (at_one(1, 1), "That feeds back theta2 - theta1; C_p picks out theta3 - theta2."),
        ],
        tolerance=1e-2,  # two digits
        praise="At z = 1 nothing moves: a static balance, whatever the sampling time.",
    )


def exercise_5(free, rig=None):
    """Parameters of the observer that change the controller: double, triple, triple with two E."""
    double, triple = (paper_design(name).model for name in ("double", "triple"))
    cases = ((double, (0.9,)), (triple, (0.9, 0.9)), (triple, (0.9, 0.8)))
    solutions = np.array([observer_family(model, E).dimension for model, E in cases])
    commuting = np.array([_commuting(np.diag(E)) for _, E in cases])
    rows = np.array([len(E) for _, E in cases])
    return compare(
        "free",
        free,
        solutions - commuting,
        [
            (solutions, "Those are the dimensions of the null spaces; now subtract."),
            (commuting, "Those are the dimensions of what commutes with E; subtract them."),
            (
                solutions - rows,
                "Which 2 x 2 matrices commute with 0.9 times the identity? More than the diagonal.",
            ),
            (
                solutions - rows**2,
                "Not every 2 x 2 matrix commutes with diag(0.9, 0.8): multiply one out.",
            ),
            (solutions - 1, "Scaling is one matrix that commutes with E; are there more?"),
        ],
        apart=True,
        praise="What commutes with E only renames the observer's states.",
    )


def exercise_6(kp_max, rig=None):
    """Largest k_p of the finished triple with filters, F unchanged, V/rad."""
    triple = _design("triple", rig)
    up = margins(triple.loop(1, filters=True)).gain_up
    return compare(
        "kp_max",
        kp_max,
        triple.kp * up,
        [
            (up, "That is a factor; of which k_p?"),
            (
                alignment_interval(triple.filtered)[1],
                "That belongs to motor 2's loop alone. Here the loop of motor 1 is closed as well.",
            ),
            (alignment_interval(triple.model)[1], "That is without filters and without loop 1."),
            (triple.kp * margins(triple.loop(1)).gain_up, "That is without filters; put them in."),
            (
                triple.kp * margins(triple.loop(0, filters=True)).gain_up,
                "That is the gain margin at input 1; k_p is the gain of loop 2.",
            ),
            (
                triple.kp * margins(triple.loop(1, filters=True)).gain_down,
                "That is how far k_p may fall; how far may it rise?",
            ),
            (triple.kp * (up - 1), "That is how much may be added to k_p."),
        ],
        tolerance=5e-3,  # three digits
        praise="Not far above the chosen value: the filters have used up what was to spare.",
    )


def exercise_7(q_mine, rig=None):
    """Process noise of a Kalman filter for the double with its filters: near, and quiet."""
    q = number("q_mine", q_mine, above=0)
    double = _design("double", rig)
    distance, noise = _kalman(double, q)
    if distance >= DISTANCE and noise <= NOISE:
        return Verdict(
            True,
            f"Distance {distance:.3f} at {noise:.3f} V: the more the filter doubts the motor, "
            "the nearer it comes to H = 0, and the more it must believe the sensors.",
        )
    told = f"With your q the distance is {distance:.3f} and the noise {noise:.3f} V. "
    return Verdict(
        False, told + ("Doubt the motor more." if distance < DISTANCE else "Doubt it less.")
    )


def _kalman(design, q):
    """Distance from -1 with filters, and noise on u in V, with the filter of process noise q B B'."""
    model = design.filtered
    A, B, C, V = model.A, model.B, model.C, np.diag(np.square(SIGMA))
    X = solve_discrete_are(A.T, C.T, q * B @ B.T, V)
    M = X @ C.T @ np.linalg.inv(C @ X @ C.T + V)
    T = np.eye(len(A)) - M @ C
    Q = [*design.Q[:4], *[0] * (len(A) - 4), design.Q[4]]
    F = lqr(add_integrator(model, 1), Q, design.R)
    own = controller(F, Observer(T @ A, T @ B, T, T @ A @ M, M, np.eye(len(A))), design.dt)
    noise = rms(control.feedback(own.system, model, sign=1), SIGMA)[0]
    return margins(open_loop(own, model)).modulus, noise


def exercise_8(floors, rig=None):
    """Hard floor of the peak of |det S| of the triple, and the soft one below the motors' cut-off."""
    triple = _design("triple", rig)
    hard, soft = _floors(triple.model, triple.rig.filters.input_hz[0], triple.dt)
    double = _design("double", None)
    return compare(
        "floors",
        floors,
        (hard, soft),
        [
            ((soft, hard), "The other way round: first the floor for any controller."),
            ((np.log(hard), soft), "The first is the sum of the logarithms; the peak is its exponential."),
            ((hard, hard ** (1 / (triple.dt * triple.rig.filters.input_hz[0]))), "Frequencies go up to half the sampling rate."),
            (_floors(double.model, double.rig.filters.input_hz[0], double.dt), "That is the double's; take the triple."),
        ],
        tolerance=5e-3,
        praise="The pendulum asks for little; the rest of the peak is the design's.",
    )  # fmt: skip


def _floors(model, cut_off, dt):
    hard = np.prod([max(1.0, abs(p)) for p in np.linalg.eigvals(model.A)])
    return hard, hard ** (0.5 / dt / cut_off)


def _design(name, rig):
    design = paper_design(name)
    return design if rig is None else replace(design, rig=rig, coefficients=None)


def _commuting(E):
    """Dimension of the space of matrices M with ME = EM."""
    identity = np.eye(len(E))
    commutator = np.kron(identity, E.T) - np.kron(E, identity)
    return len(E) ** 2 - np.linalg.matrix_rank(commutator)
