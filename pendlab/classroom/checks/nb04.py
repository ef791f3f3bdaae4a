"""Checks of notebook 04: integrator, turns, observers, k_p."""

from dataclasses import replace

import control
import numpy as np

import pendlab as pl

from ..._arguments import number
from .hw2 import commuting
from .hw3 import kalman_filter
from .judging import asks

OFFSET = 0.01  # rad, on the sensor of theta2 - theta1
SIGMA = (1e-3, 1e-3, 1e-2)  # rad, rad, rad/s: noise of the readings in exercise 7
DISTANCE, NOISE = 0.91, 0.2  # from -1, V: what exercise 7 asks for


@asks("final_angle", tolerance=0.02)  # a simulation of a minute or two has not quite settled
def exercise_1(rig):
    """Angle at which the double settles with an offset in the sensor that is integrated, rad."""
    double = _design("double", rig)
    plain = replace(double, Q=double.Q[:4], tracked=())

    def angle(design):
        """From the offset, as it is switched on, to theta2 - theta1."""
        A, B, F = design.augmented.A, design.augmented.B, design.F
        pushed = -B @ F[:, [1]]
        if design.tracked:
            pushed[4] -= design.dt
        return OFFSET * control.ss(A - B @ F, pushed, np.eye(1, len(A), 1), 0, design.dt)

    settled, without = (angle(design).dcgain() for design in (double, plain))
    yield settled, None
    rising = control.step_response(angle(double), 60.0).outputs
    early = """Has it settled? The integrator is slow: plot the angle, and wait until it moves no
        more."""
    for seconds in (2, *range(5, 51, 5), 60):
        yield rising[round(seconds / double.dt)], early
    yield 0.0, "Which angle is 0 in the end: the true one, or what the sensor shows?"
    yield -settled, "The sign: the sensor shows the true angle plus its offset."
    yield without, "That is without the integrator; use `double.F` with its fifth entry."


@asks("answers", apart=True)
def exercise_2(rig):
    """(turns, unstable closed-loop eigenvalues) of the double's loop times 0.4, 1 and 20."""
    double = _design("double", rig)
    loops = (pl.state_feedback_loop(double.augmented, k * double.F) for k in (0.4, 1.0, 20.0))
    counts = [pl.encirclements(loop) for loop in loops]
    turns, unstable = np.array([(c.turns, c.unstable_closed) for c in counts], dtype=float).T
    praise = "In each pair, turns and unstable eigenvalues add up to the number of the open loop."
    yield np.c_[turns, unstable], praise
    yield np.c_[unstable, turns], "The pairs are the other way round: (turns, unstable)."
    yield np.c_[-turns, unstable], "Turns are counted anticlockwise here."
    half = "That is the upper half of the contour; count both halves."
    yield np.c_[turns / 2, unstable], half
    inside = """You stepped round z = 1 on the inside, where one more pole is outside the contour;
        pl.encirclements steps round it on the outside."""
    yield np.c_[turns + 1, unstable], inside
    opened = turns * 0 + counts[0].unstable_open
    yield np.c_[turns, opened], "Those are the open-loop eigenvalues; P - Z = turns."
    yield np.c_[opened, unstable], "Turns = P - Z; they change with Z."


@asks("ripple")
def exercise_3(rig):
    """Ratio of the controllers' gains from theta1 to the voltage at z = -1, observer 2 to 1."""
    systems = [pl.paper_design("double", observer=n).controller.system for n in (1, 2)]

    def ratio(omega=np.pi / systems[0].dt, sensor=0):
        first, second = (abs(pl.frequency_response(s, omega)[0, 0, sensor]) for s in systems)
        return second / first

    yield ratio(), None
    yield 20 * np.log10(ratio()), "That is in decibels; give the factor itself."
    direct = "Only L1 counted; the observer's state adds its share at z = -1."
    yield abs(systems[1].D[0, 0] / systems[0].D[0, 0]), direct
    yield ratio(50.0), "Half the sampling rate is 50 Hz; frequencies go in as rad/s."
    for sensor in (1, 2):
        other = "That is another sensor; theta1 is the first input of the controller."
        yield ratio(sensor=sensor), other
    yield 1 / ratio(), "That is observer 1 against observer 2; turn it round."


@asks("kp_low", tolerance=1e-2)  # two digits
def exercise_4(rig):
    """Lower end of the interval of k_p with two unstable eigenvalues, V/rad."""
    triple = _design("triple", rig)

    def at_one(motor=1, output=2, model=triple.model):
        A, B, C = model.A, model.B, triple.model.C
        return -1 / (C[output] @ np.linalg.solve(np.eye(len(A)) - A, B[:, motor]))

    yield at_one(), None
    printed = "That is the paper's printed number; the parameters give another."
    yield pl.published("eq18.k_p_interval").values[0], printed
    pair = "That is the upper end; there a pair leaves the circle."
    yield pl.alignment_interval(triple.model)[1], pair
    yield pl.alignment_interval(triple.filtered)[1], "That is the upper end, with filters."
    yield -at_one(), "The sign: A_t1 = A_t - B_t2 k_p C_p C_t, so I - A_t1 has a plus."
    mixed = "Two digits, please. I - A belongs to the sampled model, 0 - A to the continuous one."
    yield at_one(model=triple.plant), mixed  # 0.80, as the truth to one digit is
    yield at_one(motor=0), "That is motor 1's column; the spring is made by motor 2."
    yield at_one(output=1), "That feeds back theta2 - theta1; C_p picks out theta3 - theta2."


@asks("free", apart=True)
def exercise_5(rig):
    """Parameters of the observer that change the controller: double, triple, triple with two E."""
    cases = (("double", (0.9,)), ("triple", (0.9, 0.9)), ("triple", (0.9, 0.8)))
    families = (pl.observer_family(pl.paper_design(name).model, E) for name, E in cases)
    solutions = np.array([family.dimension for family in families])
    renaming = np.array([commuting(np.diag(E)) for _, E in cases])
    rows = np.array([len(E) for _, E in cases])
    yield solutions - renaming, "What commutes with E only renames the observer's states."
    yield solutions, "Those are the dimensions of the null spaces; now subtract."
    yield renaming, "Those are the dimensions of what commutes with E; subtract them."
    diagonal = "Which 2 x 2 matrices commute with 0.9 times the identity? More than the diagonal."
    yield solutions - rows, diagonal
    every = "Not every 2 x 2 matrix commutes with diag(0.9, 0.8): multiply one out."
    yield solutions - rows**2, every
    yield solutions - 1, "Scaling is one matrix that commutes with E; are there more?"


@asks("kp_max")
def exercise_6(rig):
    """Largest k_p of the finished triple with filters, F unchanged, V/rad."""
    triple = _design("triple", rig)
    kp, second = triple.kp, pl.margins(triple.loop(1, filters=True))
    yield kp * second.gain_up, None
    yield second.gain_up, "That is a factor; of which k_p?"
    upper = "That is the upper end of the interval; here the loops of both motors are closed."
    yield pl.alignment_interval(triple.filtered)[1], upper
    yield pl.alignment_interval(triple.model)[1], f"Put the filters in. {upper}"
    yield kp * pl.margins(triple.loop(1)).gain_up, "That is without filters; put them in."
    one = "That is the gain margin at input 1; k_p is the gain of loop 2."
    yield kp * pl.margins(triple.loop(0, filters=True)).gain_up, one
    yield kp * second.gain_down, "That is how far k_p may fall; how far may it rise?"
    yield kp * (second.gain_up - 1), "That is how much may be added to k_p."


def exercise_7(q_mine, rig=None):
    """Process noise of a Kalman filter for the double with its filters: near, and quiet."""
    q = number("q_mine", q_mine, above=0, most=1e9)  # V^2
    distance, noise = np.round(_kalman(_design("double", rig), q), 3)  # as printed
    told = f"With your q the distance is {distance:.3f} and the noise {noise:.3f} V."
    if distance < DISTANCE:
        yield f"{told} Doubt the motor more."
    if noise > NOISE:
        yield f"{told} Doubt it less."
    return f"Distance {distance:.3f} at {noise:.3f} V. Now say why both grow with q."


def _kalman(design, q):
    """Distance from -1 with filters, and noise on u in V, where the filter expects q B B'."""
    model = design.filtered
    observer = kalman_filter(model, q * model.B @ model.B.T, np.diag(np.square(SIGMA)))
    Q = [*design.Q[:4], *[0] * (model.nstates - 4), design.Q[4]]
    F = pl.lqr(pl.add_integrator(model, 1), Q, design.R)
    own = pl.controller(F, observer, design.dt)
    noise = pl.rms(control.feedback(own.system, model, sign=1), SIGMA)[0]
    return pl.margins(pl.open_loop(own, model)).modulus, noise


@asks("floors")
def exercise_8(rig):
    """Hard floor of the triple's peak of |det S|, and the soft one below the motors' cut-off."""
    triple = _design("triple", rig)
    cut_off, dt = triple.rig.filters.input_hz[0], triple.dt

    def floors(model, highest=0.5 / dt):
        hard = np.prod([max(1.0, abs(p)) for p in model.poles()])
        return np.array([hard, hard ** (highest / cut_off)])

    hard, soft = floors(triple.model)
    yield (hard, soft), "Hold the peak of part 3 against them."
    yield (soft, hard), "The other way round: first the floor for any controller."
    peak = "The first is the sum of the logarithms; the peak is its exponential."
    yield (np.log(hard), soft), peak
    yield floors(triple.model, 1 / dt), "Frequencies go up to half the sampling rate."
    yield floors(pl.paper_design("double").model), "That is the double's; take the triple."


def _design(name, rig):
    design = pl.paper_design(name)
    return design if rig is None else replace(design, rig=rig, coefficients=None)
