"""What students answer to every exercise, and the verdict that is wanted.

* `RIGHT`: the right answer, worked out here once more where that is possible
* `OTHER_FORM`: the same in another form; of all the others the tests change the types
* `PRINTED`: right answers as the notebook prints them, where the tests do not round to three digits
* `WRONG`: usual mistakes, leftovers of earlier cells, another rig, with a part of the hint
* `RIGS`: the rig passed along, where an exercise asks for one's own

All answers are functions, so that nothing is computed before it is needed.
"""

import json
import sys
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import control
import numpy as np
import sympy as sp
from scipy.optimize import brentq

import pendlab as pl
from pendlab.classroom.checks import hw1, hw3, hw5, hw6, hw7, hw8
from pendlab.classroom.checks.acceptance import design_noise, modulus_margins, unstable

sys.path.insert(0, str(Path(__file__).parent))

from open_tasks import answer as found_answer

TS = 0.01
FOUND = json.loads((Path(__file__).parent / "homework_designs.json").read_text())


def letter(name):
    return sp.Symbol(name, positive=True)


def unordered(names):
    return sp.symbols(names, commutative=False)


@lru_cache
def double_motion():
    return pl.derive(2, 1)


def tip(at="l2", rigid=True, factor=1):
    """M and P of the double with a point mass on the tip, or with a mistake in it."""
    motion, m, arm = double_motion(), sp.Symbol("m_t"), letter(at)
    l1, g = letter("l1") if rigid else 0, letter("g")
    M = motion.M + factor * m * sp.Matrix([[l1**2, l1 * arm], [l1 * arm, arm**2]])
    return M, motion.P - m * g * sp.diag(l1, arm)


def belt():
    M, G, rotor = pl.derive(2, 0).M, letter("G1"), letter("I_p1")
    return M + sp.diag(0, rotor), sp.Matrix([0, -G])


def triple_floor():
    poles = np.abs(np.linalg.eigvals(model("triple").A))
    return np.exp(np.log(poles[poles > 1]).sum())


def four_digits(value):
    return float(f"{value:.4g}")


def stiffness():
    return double_motion().P


def double_rates():
    return np.sort(pl.linearize(pl.load("double")).poles().real)[::-1]


def growth(name):
    return pl.linearize(pl.load(name)).poles().real.max()


def model(name="double"):
    return pl.paper_design(name).model


def remainder():
    F, L2, Psi, T, B = unordered("F L2 Psi T B")
    return -F * L2 * Psi * T * B


def rules(sign=-1, swap=False):
    X, Y, R = unordered("X Y R")
    return {Y * X * R: 1 + sign * R, R * (X * Y if swap else Y * X): 1 + sign * R}


def members():
    family, rng = pl.observer_family(model(), 0.9), np.random.default_rng(2)
    return [family.member(rng.standard_normal(2)) for _ in range(5)]


def at_five_members(measure):
    F = pl.lqr(model(), [0.1, 100, 0, 0.01], 3)
    return [measure(pl.controller(F, o, TS, tracked=())) for o in members()]


def at_outputs(values=min):
    omega = pl.frequency_grid(TS)
    G = pl.frequency_response(model(), omega)

    def measure(c):
        loop = np.eye(3) - G @ pl.frequency_response(c.system, omega)
        return np.linalg.svd(loop, compute_uv=False)[:, -1 if values is min else 0].min()

    return at_five_members(measure)


def at_input(filters):
    plant = pl.paper_design("double").filtered if filters else model()
    return at_five_members(lambda c: pl.margins(pl.open_loop(c, plant)).modulus)


def siso_pole():
    plant = control.ss([[1.7, -0.6], [1, 0]], [[1], [0]], [[1, -1.1]], 0, TS)
    F, o = pl.lqr(plant, [1, 1], 1), pl.luenberger(plant, 0.6, [[1]])
    return (o.E - o.H @ F @ o.L2).item()


def ripple():
    gains = [
        abs(pl.frequency_response(pl.paper_design("double", n).controller.system, np.pi / TS))
        for n in (1, 2)
    ]
    return gains[1][0, 0, 0] / gains[0][0, 0, 0]


def upper_margin(filters=True):
    return pl.margins(pl.paper_design("triple").loop(1, filters)).gain_up


def kp_low():
    A, B = model("triple").A, model("triple").B
    return -1 / np.linalg.solve(np.eye(6) - A, B[:, 1])[2]


def twice(rig="double"):
    slow = pl.sample(pl.linearize(pl.load(rig)), 2 * TS)
    return slow.A, slow.B


def delay_budget(total, own=True):
    return 1 / (2 * np.pi * (total - own / (2 * np.pi * pl.load("double").filters.output_hz[0])))


def rotor():
    motor, upper = ADA.motors[0], ADA.links[1]
    hinge = upper.inertia + upper.mass * upper.com**2
    return motor.inertia / motor.ratio**2, motor.inertia / hinge


def rates(name):
    """Eigenvalues of a rig's linear model, the fastest fall first."""
    rig = pl.load(name) if isinstance(name, str) else name
    return np.sort(pl.linearize(rig).poles().real)[::-1]


def mass(rig):
    return sum(link.mass for link in rig.links)


def distance(rig, units=True, sampled=False):
    plant = pl.linearize(rig)
    A, B = pl.in_units(plant, 0.1, 0.2, rig.u_max) if units else (plant.A, plant.B)
    if sampled:
        model = pl.sample(plant)
        A, B = model.A, model.B
    return pl.distance_to_uncontrollability(A, B)[0]


def worst_bar(sign=1, friction=True):
    """Inertia with which the motor has no say in a mode that grows (or, with -1, decays)."""
    rig = pl.load("double")
    motion, values = pl.models.equations(rig)
    _, M, N, P, _ = (np.asarray(X, dtype=float) for X in motion.linear(*values))
    s = sign * np.sqrt(-P[1].sum() / M[1].sum())
    return -(friction * N[0].sum() * s + P[0].sum()) / s**2 - M[0].sum()


def tube_length(arm=12, weight=True):
    rig, line = pl.load("double"), 0.343

    def gain(b):
        barred = pl.with_bar(rig, 2, line * b**3 / arm, mass=weight * line * b)
        return pl.recoverable_tilt(barred) - pl.recoverable_tilt(rig)

    return brentq(gain, 0.5 if arm == 12 else 0.2, 1.5)


def bend(shape=(0, 1), share=0.05, entries=slice(None)):
    f, A = pl.nonlinear(pl.load("double")), pl.paper_design("double").plant.A

    def error(angle):
        x = angle * np.array([*shape, 0, 0])
        return np.linalg.norm((A @ x - f(x, 0))[entries]) / np.linalg.norm(f(x, 0)[entries])

    return brentq(lambda angle: error(angle) - share, 1e-3, 1.5)


def alone():
    """(volts of the middle motor alone, the factor), a mode is caught from |w B| u_max / (s |w1|)."""
    plant, limits = pl.linearize(pl.load("triple")), np.array(pl.load("triple").u_max)
    s, V = np.linalg.eig(plant.A)
    left = np.linalg.inv(V).real[s.real > 0] / s.real[s.real > 0, None]
    shares = np.abs(left @ plant.B) / np.abs(left[:, :1]) / s.real[s.real > 0, None]
    factor = (shares @ limits).min() / shares[:, 0].min()
    return factor, factor / limits[0]


@lru_cache
def pulses(force=True):
    design, real = pl.paper_design("double"), pl.Imperfections(filters=True, saturation=True)
    levers = pl.force_levers(design.rig) if force else None
    found = pl.largest_pulses(design.rig, design.controller, [0.05], real, levers=levers)
    return found.heights[:, 0]


def let_go(link=3, height=-0.025, seconds=5.0):
    torque = tuple(height * np.eye(3)[link - 1])
    bench = pl.bench_imperfections(pl.load("triple"))
    return replace(bench, start_torque=torque, start_torque_time=seconds)


def slowest(name, filters=True):
    design = pl.paper_design(name)
    loop = design.filtered_loop if filters else design.nominal_loop
    return -TS / np.log(np.abs(pl.closed_loop_eigenvalues(loop)[0]))


def second_loop(filters=True):
    return pl.margins(pl.paper_design("triple").loop(1, filters))


def lean(small=False, absolute=True):
    l1, l2, l3 = pl.load("triple").links
    M = np.array([
        l1.mass * l1.com + (l2.mass + l3.mass) * l1.length,
        l2.mass * l2.com + l3.mass * l2.length,
        l3.mass * l3.com,
    ])  # fmt: skip
    steps = np.array([0, 0.3, 0.6 if absolute else 0.3])
    if small:
        return -M @ steps / M.sum()
    return -np.arctan2(M @ np.sin(steps), M @ np.cos(steps))


def noise_volts(motor="u2", filters=True):
    loop = pl.closed_loop(pl.paper_design("triple"), filters=filters)
    return pl.rms(loop[motor, "noise theta3-theta2"], 1e-3)[0]


def least_sigma(left=None, filters=False):
    design = pl.paper_design("triple")
    loop = design.filtered_loop if filters else design.nominal_loop
    D = np.diag(left if left is not None else 1 / np.array(design.rig.u_max))
    Rd = np.eye(2) + pl.frequency_response(loop, pl.frequency_grid(TS, 3000))
    return np.linalg.svd(D @ Rd @ np.linalg.inv(D), compute_uv=False)[:, -1].min()


def half_geared(power=2, ratio=2):
    own = ADA
    motor = own.motors[0]
    inertia, damping = motor.inertia / ratio**power, motor.damping / ratio**power
    half = replace(motor, gain=motor.gain / ratio, inertia=inertia, damping=damping)
    values = rates(replace(own, motors=(half,)))
    return min(values[values > 0])


def reweighted(integrator):
    design = pl.paper_design("double")
    return replace(design, Q=(*design.Q[:-1], integrator))


ADA, ADA3 = pl.my_rig("Ada"), pl.my_rig("Ada", "triple")
RIGS = {"00.3": ADA, "01.1": ADA3, "01.3": ADA, "02.1": ADA, "A.5": ADA}


# ---- Homework: the rig of "your name"


@lru_cache
def start(kp=10.0):
    """The paper's own design on the rig of "your name"."""
    own = pl.paper_design("triple")
    return pl.Design(pl.my_rig("your name", "triple"), own.Q, own.R, own.E, kp)


def unbalanced(kp):
    """Stable without filters, unstable with them."""
    return replace(start(kp), E=(0.9, 0.5), kp=40.0)


def filtered(dt, motors, sensors, kp):
    rig = replace(start().rig, filters=pl.Filters((motors,) * 2, (sensors,) * 4))
    return replace(start(), rig=rig, dt=dt, kp=kp)


def with_weights(**changes):
    """Task of homework 4: the start with other entries of Q."""
    Q = np.array(start(5.0).Q)
    for name, value in changes.items():
        Q[int(name[1:])] = value
    return replace(start(5.0), Q=tuple(Q))


def process_noise(scale):
    B = start(5.0).model.B
    return scale * B @ B.T


class Lazy:
    """Does nothing, at every sample."""

    def step(self, state, y, y_ref):
        return np.zeros(2), state


def own(base="double"):
    return pl.my_rig("your name", base)


def four_links(*ratios):
    """Homework 5: the large motor below, small ones above."""
    motors = [hw5.geared(own("triple").motors[min(i, 1)], ratio) for i, ratio in enumerate(ratios)]
    return hw5.tower(own("triple"), motors, (12.0, 2.5, 2.5)[: len(ratios)])


def four_links_design(E):
    return pl.Design(four_links(120, 120, 68), (0.1,) * 4 + (0.01,) * 5, (1.0,) * 3, E)


def stiff_gear(a):
    return 50.0


def soft_run():
    return hw6.run_with(hw6.reference(own()), hw6.soft_gear(own()))


def with_bar(R):
    bar = (2, 1.5, 0.1, 0.0)
    rig = hw7.barred(own("triple"), *bar)
    return bar, pl.Design(rig, (1, 1, 1, 0, 0, 0, 0.01), R, (0.9, 0.9))


def attitudes(q):
    weights = (1, 1, 1, 0, 0, 0, q, q)
    return pl.Design(own("triple"), weights, (0.1, 0.1), (0.9, 0.9), tracked=(1, 2))


class Asleep:
    def __init__(self, rig):
        self.motors = rig.n_motors

    def step(self, state, y, y_ref):
        return np.zeros(self.motors), state


class Forgetful(Asleep):
    def step(self, state, y, y_ref):
        self.motors += 1
        return self.motors, state


class Crashing(Asleep):
    def step(self, state, y, y_ref):
        raise RuntimeError("boom")


def delays():
    filters = own("triple").filters
    cuts = filters.input_hz[1], filters.output_hz[2]
    return [TS / 2, *(1 / (2 * np.pi * cut) for cut in cuts)]


def kalman():
    model, V = start(5.0).model, np.diag([1e-3, 1e-3, 1e-3, 1e-2]) ** 2
    X, _, _ = control.dare(model.A.T, model.C.T, process_noise(1.0), V)
    return X @ model.C.T @ np.linalg.inv(model.C @ X @ model.C.T + V)


def slow_motion():
    return -TS / np.log(np.abs(pl.closed_loop_eigenvalues(start(5.0).nominal_loop)[0]))


def alias(f, dt):
    return abs(f - round(f * dt) / dt)


def longest_period():
    """By bisection of the smaller margin without filters."""
    short, long = 0.005, 0.1
    while long > 1.01 * short:
        middle = (short + long) / 2
        fits = min(modulus_margins(replace(start(), dt=middle), filters=False)) >= 0.25
        short, long = (middle, long) if fits else (short, middle)
    return short


def own_design(task):
    return found_answer(task, "your name", FOUND[task]["your name"]["made_of"])


@lru_cache
def largest_lean():
    (design,) = own_design("hw1.4")
    low, high = 0.01, 0.3
    while high > 1.02 * low:
        middle = (low + high) / 2
        low, high = (middle, high) if hw1.recovers(design, middle) else (low, middle)
    return low


def fastest_observer():
    start5, fits = start(5.0), []
    limit = 1.5 * design_noise(start5)
    for e in np.arange(0.89, 0.5, -0.01):
        if design_noise(replace(start5, E=(e, e))) > limit:
            return e + 0.01
    return fits


def two_members():
    rng, made = np.random.default_rng(1), []
    for _ in range(20):
        design = replace(start(5.0), E=(0.95, 0.7), coefficients=tuple(rng.standard_normal(4)))
        if unstable(design.filtered_loop) is None:
            made.append((modulus_margins(design)[0], design))
    made.sort(key=lambda pair: pair[0])
    return made[-1][1], made[0][1]


class Pilot:
    """The filter of homework 3; `predicted` is the voltage that the prediction is told."""

    def __init__(self, predicted="limited", integrates=1.0):
        design, (W,) = start(5.0), own_design("hw3.4")
        self.A, self.B, self.C = design.model.A, design.model.B, design.model.C
        self.F, self.dt, self.u_max = design.controller.F, design.dt, np.array(design.rig.u_max)
        self.M, self.predicted, self.integrates = (
            hw3.kalman_gain(design.model, W),
            predicted,
            integrates,
        )

    def start(self, x0):
        return x0, 0.0

    def step(self, state, y, y_ref):
        x, w = state
        x = x + self.M @ (y - self.C @ x)
        wanted = -self.F @ np.append(x, w)
        u = np.clip(wanted, -self.u_max, self.u_max)
        told = {"limited": u, "wanted": wanted, "nothing": 0 * u}[self.predicted]
        w = w + self.integrates * self.dt * (y_ref - y[1])
        return (wanted if self.predicted == "nothing" else u), (self.A @ x + self.B @ told, w)


class Selfish(Pilot):
    """Remembers in self, and forgets at every start."""

    def start(self, x0):
        self.kept = super().start(x0)

    def step(self, state, y, y_ref):
        u, self.kept = super().step(self.kept, y, y_ref)
        return u, None


def mass_and_gravity(rig, own_inertia=1, g=1):
    a = np.zeros((rig.n_links, rig.n_links))
    for i, link in enumerate(rig.links):
        a[i, :i] = [lower.length for lower in rig.links[:i]]
        a[i, i] = link.com
    m = np.diag([link.mass for link in rig.links])
    M = a.T @ m @ a + own_inertia * np.diag([link.inertia for link in rig.links])
    return M, -(rig.g if g == 1 else 1) * np.diag((m @ a).sum(axis=0))


def standing_tower():
    Q = (0.1,) * 4 + (0.01,) * 5
    return pl.Design(four_links(120, 120, 68), Q, (1.0,) * 3, (0.05, 0.1, 0.2), kp=None, tracked=1)


def play_of_gear(a, whole=1):
    half, psi = whole * hw6.gap(own()) / 2, np.linspace(0, 2 * np.pi, 20000, endpoint=False)
    delta = a * np.cos(psi)
    tau = 50.0 * np.sign(delta) * np.maximum(np.abs(delta) - half, 0)
    return 2 * np.mean(tau * np.cos(psi)) / a


def at_gear(omega):
    return hw6.at_the_gear(hw6.reference(own()), omega)[0]


def cycle():
    """From the equations of the task: Im W = 0, then N(a) = -1/W."""

    def W(w):
        return hw6.at_the_gear(hw6.reference(own()), np.array([w]))

    w = brentq(lambda w: W(w)[0].imag[0], 20, 40)
    needed = -1 / W(w)[0].real[0]
    a = brentq(lambda a: play_of_gear(a) - needed, 0.6 * hw6.gap(own()), 10 * hw6.gap(own()))
    return np.array([w / (2 * np.pi), a, abs(W(w)[1][0]) * needed * a])


def carried(link, inertia, mass, height, steiner=True):
    total = link.mass + mass
    com = (link.mass * link.com + mass * height) / total
    about = link.inertia + inertia
    about += steiner * (link.mass * (link.com - com) ** 2 + mass * (height - com) ** 2)
    return replace(link, mass=total, com=com, inertia=about)


def at_rest():
    plant = pl.linearize(own("triple"))
    wish = np.eye(6)[[1, 2]]
    left = np.block([[plant.A, plant.B], [wish, np.zeros((2, 2))]])
    found = np.linalg.solve(left, [0] * 6 + [0.1, -0.1])
    return found[:6], found[6:]


def sent():
    """The rows that arrive as the wave."""
    (design,) = own_design("hw8.3")
    names = ["theta2-theta1", "theta3-theta2"]
    loop = pl.closed_loop(design)[names, [f"reference {name}" for name in names]]
    T = pl.frequency_response(loop, [2 * np.pi / hw8.PERIOD])[0]
    turning = np.exp(2j * np.pi * design.dt * np.arange(2401) / hw8.PERIOD)
    return design, (turning[:, None] * np.linalg.solve(T, [-0.15j, 0.15])).real - [0, 0.15]


class First:
    """The smallest controller of homework 9."""

    dt, correction = 0.01, 0.5

    def __init__(self, rig):
        model = pl.sample(pl.linearize(rig), self.dt)
        self.A, self.B = model.A, model.B[:, 0]
        self.F = pl.lqr(model, (0.1, 100, 0, 0.01), 0.3)[0]

    def step(self, state, y, y_ref):
        guess = np.array([*y, 0.0]) if state is None else state
        x = np.array([*y, guess[3] + self.correction * (y[1] - guess[1]) / self.dt])
        u = -self.F @ x
        return u, self.A @ x + self.B * u


class Uncorrected(First):
    correction = 0.0


class Backwards(First):
    def step(self, state, y, y_ref):
        u, state = super().step(state, y, y_ref)
        return -u, state


class Wrapped:
    """A design of the package and a push against dry friction."""

    dt, weights, R, E, push = 0.01, (0.1, 100, 0, 0.01, 5), (1.0,), (0.5,), 1.2

    def __init__(self, rig):
        self.inner = pl.Design(rig, self.weights, self.R, self.E).controller
        self.u_max = np.array(rig.u_max)

    def start(self, x0):
        return self.inner.start(x0)

    def step(self, state, y, y_ref):
        u = self.inner.control(state, y)
        u = np.clip(u + self.push * np.tanh(u / 0.3), -self.u_max, self.u_max)
        return u, self.inner.update(state, y, u, y_ref)


class FirstTry(Wrapped):
    """Cheaper volts, and no more."""

    weights, R, E, push = (0.1, 100, 0, 0.01, 0.01), (0.3,), (0.9,), 0.0


def wrapped_margin(filters=True, made=Wrapped):
    rig = pl.load("double")
    plant = pl.linearize(rig)
    model = pl.sample(pl.with_filters(plant, rig.filters) if filters else plant, 0.01)
    return pl.margins(pl.open_loop(made(rig).inner, model)).modulus


def score(run, by_limit=True):
    if run.fell:
        return 20 * run.fell_at / 8.0
    angles = np.sqrt(np.mean(run.angles**2)) / 0.05
    volts = np.sqrt(np.mean(run.u**2)) / (run.rig.u_max[0] if by_limit else 1)
    return 50 + 50 / (1 + angles + volts)


# ---- The table

RIGHT = {
    "00.1": lambda: (6,),
    "00.2": lambda: (np.log(2) / rates("double")[0],),
    "00.3": lambda: (mass(ADA),),
    "01.1": lambda: (np.log(2) / rates(ADA3)[0] / TS,),
    "01.2": lambda: ("forwards",),
    "01.3": lambda: (distance(ADA),),
    "01.4": lambda: (worst_bar(),),
    "01.5": lambda: (tube_length(),),
    "02.1": lambda: rotor(),
    "02.2": lambda: (np.log(30) / growth("double"), np.log(30) / growth("triple")),
    "02.3": lambda: (bend(),),
    "02.4": lambda: (delay_budget(0.02),),
    "02.5": lambda: twice(),
    "02.6": lambda: alone()[:1],
    "03.1": lambda: ([[-1, -1, 1]], [[-1, -0.5]]),
    "03.2": lambda: (2 * (4 - 1),),
    "03.3": lambda: ((1, 2),),
    "03.4": lambda: (44, 7),
    "03.5": lambda: (1.5, -0.5),
    "03.6": lambda: (1.2, 0.2),
    "04.1": lambda: (-0.01,),
    "04.2": lambda: ([(0, 2), (2, 0), (1, 1)],),
    "04.3": lambda: (ripple(),),
    "04.4": lambda: (kp_low(),),
    "04.5": lambda: ((1, 0, 2),),
    "04.6": lambda: (10 * upper_margin(),),
    "04.7": lambda: (10,),
    "04.8": lambda: ((triple_floor(), triple_floor() ** (50 / 10.26)),),
    "05.1": lambda: ([0.0, 0.0],),
    "05.2": lambda: (reweighted(100),),
    "05.3": lambda: (("no", "yes"),),
    "05.4": lambda: (pulses()[1],),
    "05.5": lambda: (let_go(),),
    "05.6": lambda: (("same", "opposite"),),
    "06.1": lambda: (slowest("double"),),
    "06.2": lambda: (second_loop().phase / second_loop().phase_omega,),
    "06.3": lambda: (lean(),),
    "06.4": lambda: (noise_volts(),),
    "06.5": lambda: (least_sigma(),),
    "A.1": lambda: tip(),
    "A.2": lambda: belt(),
    "A.3": lambda: (-stiffness(), 0),
    "A.4": lambda: (4,),
    "A.5": lambda: (half_geared(),),
    "B.1": lambda: (remainder(),),
    "B.2": lambda: (rules(), 0),
    "B.3": lambda: (at_outputs(),),
    "B.4": lambda: (siso_pole(),),
    "B.5": lambda: (at_input(filters=True),),
    "hw1.1": lambda: (delays(),),
    "hw1.2": lambda: (alias,),
    "hw1.3": lambda: (longest_period(),),
    "hw1.4": lambda: own_design("hw1.4"),
    "hw1.5": lambda: (*own_design("hw1.4"), largest_lean()),
    "hw2.1": lambda: ((0, 2),),
    "hw2.2": lambda: (fastest_observer(),),
    "hw2.3": lambda: two_members(),
    "hw2.4": lambda: own_design("hw2.4"),
    "hw3.1": lambda: (kalman(),),
    "hw3.2": lambda: (hw3.compensator(start(5.0), process_noise(1.0)),),
    "hw3.3": lambda: (process_noise(1e-4),),
    "hw3.4": lambda: own_design("hw3.4"),
    "hw3.5": lambda: (Pilot(),),
    "hw4.1": lambda: (slow_motion(),),
    "hw4.2": lambda: (250 / 20**2,),
    "hw4.3": lambda: own_design("hw4.3"),
    "hw4.4": lambda: own_design("hw4.4"),
    "hw5.1": lambda: (hw5.geared,),
    "hw5.2": lambda: (mass_and_gravity,),
    "hw5.3": lambda: ([4, 3, 2], 2),
    "hw5.4": lambda: (four_links(120, 120, 68),),
    "hw5.5": lambda: (standing_tower(),),
    "hw6.1": lambda: (play_of_gear,),
    "hw6.2": lambda: (at_gear,),
    "hw6.3": lambda: (cycle(), "stable"),
    "hw6.4": lambda: (hw6.measured(soft_run()),),
    "hw6.5": lambda: own_design("hw6.5"),
    "hw7.1": lambda: (carried,),
    "hw7.2": lambda: (2, 3),
    "hw7.3": lambda: own_design("hw7.3"),
    "hw7.4": lambda: own_design("hw7.4"),
    "hw7.5": lambda: own_design("hw7.5"),
    "hw8.1": lambda: at_rest(),
    "hw8.2": lambda: ([(0,), (1,), (2,), (0, 1), (0, 2), (1, 2)],),
    "hw8.3": lambda: own_design("hw8.3"),
    "hw8.4": lambda: (hw8.bow(own("triple")),),
    "hw8.5": lambda: sent(),
    "hw9.1": lambda: (First,),
    "hw9.2": lambda: (score,),
    "hw9.3": lambda: (Wrapped, 1),
    "hw9.4": lambda: (Wrapped, 1, wrapped_margin()),
}  # fmt: skip

OTHER_FORM = {
    "03.3": lambda: ([2, 1],),
    "A.1": lambda: tuple(X.subs(sp.Symbol("m_t"), sp.Symbol("mu", real=True)) for X in tip()),
    "A.3": lambda: (stiffness() * sp.cos(sp.pi), np.int64(0)),
    "B.1": lambda: ((remainder() * 3 - remainder()) / 2,),
    "B.2": lambda: (dict(reversed(rules().items())), sp.Integer(0)),
    "01.2": lambda: (" Forwards ",),
    "01.5": lambda: (np.array([tube_length()]),),
    "02.3": lambda: (-bend(),),
    "05.2": lambda: (replace(reweighted(30), Q=(1.0, 100, 0, 0.01, 30)),),
    "05.3": lambda: (["No", "YES"],),
    "hw1.2": lambda: (lambda f, dt: min(f % (1 / dt), -f % (1 / dt)),),
    "hw1.3": lambda: (0.98 * longest_period(),),
    "hw3.3": lambda: (2e-4 * process_noise(1.0),),
    "hw3.5": lambda: (Pilot(),),
    "hw4.2": lambda: (1.03 * 250 / 20**2,),
    "hw5.2": lambda: (lambda rig: list(mass_and_gravity(rig)),),
    "hw7.4": lambda: (list(own_design("hw7.4")[0]),),
    "hw7.5": lambda: (list(own_design("hw7.5")[0]), own_design("hw7.5")[1]),
    "hw7.2": lambda: (np.int64(2), np.int64(3)),
    "hw8.1": lambda: (at_rest()[0][:3], at_rest()[1]),
    "hw8.2": lambda: (((0, 1), (2, 1), (2, 0), 0, 1, 2),),
    "hw8.4": lambda: ([*hw8.bow(own("triple")), 0, 0, 0],),
    "hw9.2": lambda: (lambda run: np.float64(score(run)),),
}  # fmt: skip

PRINTED = {
    "04.7": lambda: (4,),  # prints the distance asked for
    "hw7.4": RIGHT["hw7.4"],
    "hw7.5": RIGHT["hw7.5"],
    "02.5": lambda: tuple(np.vectorize(four_digits)(part) for part in twice()),
    "02.1": lambda: (rotor()[0], float(f"{rotor()[1]:.3g}")),
}

WRONG = {
    "00.1": [(lambda: (3,), "what comes next"), (lambda: (4,), "measured outputs")],
    "00.2": [
        (lambda: (1 / rates("double")[0],), "factor e"),
        (lambda: (np.log10(2) / rates("double")[0],), "natural logarithm"),
        (lambda: (2 / rates("double")[0],), "not linear"),
        (lambda: (np.log(2) / rates("double")[1],), "slow"),
        (lambda: (rates("double")[0],), "eigenvalue itself"),
        (lambda: (np.log(2) / rates("triple")[0],), "triple"),
    ],
    "00.3": [
        (lambda: (ADA.links[0].mass,), "link 1 alone"),
        (lambda: (9.81 * mass(ADA),), "weight in newtons"),
        (lambda: (mass(pl.load("double")),), "near"),
        (lambda: (mass(pl.load("double")),), "paper's rig", pl.load("double")),
        (lambda: (mass(ADA),), "Pass your own rig", None),
    ],
    "01.1": [
        (lambda: (1 / rates(ADA3)[0] / TS,), "factor e"),
        (lambda: (np.log(2) / rates(ADA3)[1] / TS,), "slower way"),
        (lambda: (np.log(2) / rates(ADA3)[0],), "in seconds"),
        (lambda: (np.log(2) / rates("triple")[0] / TS,), "paper's rig", pl.load("triple")),
        (lambda: (np.log(2) / rates("triple")[0] / TS,), "near"),
        (lambda: (np.log(2) / rates(ADA)[0] / TS,), "about the triple", ADA),
    ],
    "01.2": [
        (lambda: ("backwards",), "centre of mass"),
        (lambda: ("neither",), "centre of mass"),
        (lambda: ("left",), "one of"),
    ],
    "01.3": [
        (lambda: (distance(ADA, units=False),), "pl.in_units first"),
        (lambda: (distance(ADA, sampled=True),), "sampled"),
        (lambda: (distance(pl.load("double")),), "paper's rig", pl.load("double")),
    ],
    "01.4": [
        (lambda: (worst_bar(sign=-1),), "dies away"),
        (lambda: (worst_bar(friction=False),), "friction"),
        (lambda: (worst_bar() + pl.load("double").links[0].inertia,), "new inertia"),
    ],
    "01.5": [
        (lambda: (tube_length(arm=3),), "held at its middle"),
        (lambda: (1000 * tube_length(),), "milli-units"),
    ],
    "02.3": [
        (lambda: (bend((1, 0)),), "it leans"),
        (lambda: (np.degrees(bend()),), "degrees"),
        (lambda: (bend(share=0.5),), "50 %"),
        (lambda: (bend(entries=[2]),), "link 1 alone"),
        (lambda: (bend(entries=[3]),), "together"),
    ],
    "02.6": [
        (lambda: alone()[1:], "factor"),
        (lambda: (14.5,), "add up"),
        (lambda: (alone()[0] - 12,), "has to be added"),
    ],
    "05.1": [
        (lambda: ([0.003, 0.0],), "sensor errors"),
        (lambda: ([0.001, 0.0],), "centre of mass"),
        (lambda: ([0.0, 0.003],), "insist"),
    ],
    "05.2": [
        (lambda: (pl.paper_design("double"),), "which weight acts on w"),
        (lambda: (reweighted(1e5),), "less haste"),
        (lambda: (pl.paper_design("triple"),), "double"),
        (lambda: (2.0,), "pl.Design"),
    ],
    "05.3": [
        (lambda: (("yes", "yes"),), "into which state"),
        (lambda: (("no", "no"),), "order matters"),
        (lambda: ("no",), "A pair"),
    ],
    "05.4": [
        (lambda: (0.05 * pulses()[1],), "impulse"),
        (lambda: (pulses()[0],), "link 1"),
        (lambda: (pulses(force=False)[1],), "torque"),
    ],
    "05.5": [
        (lambda: (let_go(seconds=50.0),), "faded"),
        (lambda: (let_go(height=-1e-6),), "quenched"),
        (lambda: (3.0,), "a start torque"),
    ],
    "05.6": [
        (lambda: (("opposite", "opposite"),), "signs of both"),
        (lambda: (("same", "same"),), "16c"),
        (lambda: (("same",),), "Two words"),
    ],
    "04.7": [(lambda: (0.1,), "more"), (lambda: (1e4,), "less")],
    "04.8": [
        (lambda: ((triple_floor() ** (50 / 10.26), triple_floor()),), "other way round"),
        (lambda: ((np.log(triple_floor()), triple_floor() ** (50 / 10.26)),), "logarithms"),
    ],
    "03.6": [
        (lambda: (0, 0.2), "which c puts it there"),
        (lambda: (1.2, 2.2), "lower end"),
        (lambda: (0.2, 1.2), "is not at 0"),
    ],
    "06.1": [
        (lambda: (slowest("triple"),), "triple"),
        (lambda: (slowest("double") / TS,), "in samples"),
        (lambda: (slowest("double") * np.log(2),), "halve"),
    ],
    "06.2": [
        (lambda: (second_loop(False).phase / second_loop(False).phase_omega,), "without filters"),
        (lambda: (second_loop().phase,), "phase margin"),
        (lambda: (np.degrees(second_loop().phase) / second_loop().phase_omega,), "rad"),
    ],
    "06.3": [
        (lambda: (lean(small=True),), "sines"),
        (lambda: (lean(absolute=False),), "relative angles add up"),
        (lambda: (-lean(),), "opposite sign"),
    ],
    "06.4": [
        (lambda: (0.01,), "closed loop"),
        (lambda: (noise_volts("u1"),), "motor 1"),
        (lambda: (noise_volts(filters=False),), "without filters"),
    ],
    "06.5": [
        (lambda: (least_sigma([12, 2.5]),), "wrong side"),
        (lambda: (least_sigma([1, 1]),), "in volts"),
        (lambda: (least_sigma(filters=True),), "with filters"),
    ],
    "A.5": [
        (lambda: (half_geared(power=1),), "power"),
        (lambda: (half_geared(ratio=1),), "as it is"),
        (lambda: (half_geared(),), "paper's rig", pl.load("double")),
    ],
    "02.1": [
        (lambda: rotor(), "paper's rig", pl.load("double")),
        (lambda: (rotor()[0] * ADA.motors[0].ratio, rotor()[1]), "square"),
        (lambda: (rotor()[0], 1 / rotor()[1]), "upside down"),
    ],
    "02.2": [
        (lambda: (np.log(30) * growth("double"), 1), "divide by s"),
        (lambda: RIGHT["02.2"]()[::-1], "other pendulum"),
        (lambda: (np.log(30) / double_rates()[1], 1), "slower"),
        (lambda: (np.log10(30) / growth("double"), 1), "natural logarithm"),
    ],
    "02.4": [
        (lambda: (pl.load("double").filters.input_hz[0],), "the rig has"),
        (lambda: (delay_budget(0.02, own=False),), "output filter delays too"),
        (lambda: (2 * np.pi * delay_budget(0.02),), "rad/s"),
    ],
    "02.5": [
        (lambda: (2 * model().A, model().B), "multiply"),
        (lambda: (twice()[0].T, twice()[1]), "transposed"),
        (lambda: (pl.paper_design("double").plant.A, 0), "continuous"),
        (lambda: (twice()[0], model().A @ model().B), "first sample's share"),
    ],
    "03.1": [
        (lambda: ([[-0.1, -1, 1]], [[-0.01, 0.4]]), "0.9"),
        (lambda: ([[-1, 0, 1]], [[-1, 0]]), "has to know u"),
        (lambda: ([2, 2, -2], [2, 1]), "another scale"),
    ],
    "03.2": [
        (lambda: (4,), "both inputs"),
        (lambda: (8,), "no input kept out"),
        (lambda: (7,), "too large"),
    ],
    "03.3": [(lambda: ((0, 1),), "largest of all"), (lambda: ((0, 2),), "all three")],
    "03.4": [
        (lambda: (43, 7), "just above"),
        (lambda: (43.70869, 7), "round"),
        (lambda: (7, 44), "other"),
    ],
    "03.5": [(lambda: (1.1, -0.5), "odd number"), (lambda: (1.5, 0.5), "opposite sign")],
    "04.1": [(lambda: (0,), "sensor shows"), (lambda: (0.01,), "sign")],
    "04.2": [
        (lambda: ([(2, 0), (0, 2), (1, 1)],), "other way round"),
        (lambda: ([(1, 2), (3, 0), (2, 1)],), "inside"),
    ],
    "04.3": [
        (lambda: (20 * np.log10(ripple()),), "decibels"),
        (lambda: (1 / ripple(),), "turn it round"),
    ],
    "04.4": [
        (lambda: (-kp_low(),), "sign"),
        (lambda: (0.7,), "printed"),
        (lambda: (0.8,), "Two digits"),
    ],
    "04.5": [(lambda: ((2, 4, 4),), "subtract"), (lambda: ((1, 2, 2),), "identity")],
    "04.6": [
        (lambda: (upper_margin(),), "factor"),
        (lambda: (10 * upper_margin(filters=False),), "without filters"),
    ],
    "A.1": [
        (lambda: (tip(at="a2")[0], tip()[1]), "centre of mass"),
        (lambda: (tip(rigid=False)[0], tip()[1]), "carries the tip along"),
        (lambda: (tip(factor=2)[0], tip()[1]), "one half"),
        (lambda: (tip()[0], 2 * stiffness() - tip()[1]), "highest"),
        (lambda: tip()[::-1], "order"),
    ],
    "A.2": [
        (lambda: (belt()[0], -belt()[1]), "left side"),
        (lambda: (belt()[0], belt()[1].T), "transposed"),
        (lambda: (double_motion().M, belt()[1]), "relative rate"),
        (lambda: (belt()[0], double_motion().H), "reaction"),
    ],
    "A.3": [
        (lambda: (stiffness(), 0), "upright"),
        (lambda: (sp.diag(-stiffness()[0, 0], stiffness()[1, 1]), 0), "absolute"),
        (lambda: (-stiffness(), 2), "not P"),
    ],
    "A.4": [
        (lambda: (3,), "positive real part"),
        (lambda: (0,), "positive real part"),
    ],
    "B.1": [
        (lambda: (-remainder(),), "opposite sign"),
        (lambda: (sp.Integer(0),), "T B"),
        (lambda: (remainder().subs(unordered("T"), unordered("H")),), "H is zero"),
    ],
    "B.2": [
        (lambda: (rules(), None), "gap"),
        (lambda: (rules(sign=1), 0), "sign"),
        (lambda: (rules(swap=True), 0), "order"),
        (lambda: (rules(), 1), "reduces to zero"),
        (lambda: (dict(list(rules().items())[:1]), 0), "two rules"),
    ],
    "B.3": [
        (lambda: (at_input(filters=False),), "at the input"),
        (lambda: (at_outputs(max),), "smallest"),
        (lambda: (sorted(at_outputs()),), "sorted"),
    ],
    "B.4": [(lambda: (0.6,), "That is E"), (lambda: (np.log(siso_pole()) / TS,), "continuous")],
    "B.5": [
        (lambda: (at_input(filters=False),), "Without filters"),
        (lambda: (sorted(at_input(filters=True)),), "sorted"),
    ],
    "hw1.1": [
        (lambda: [0.005, *2 * np.pi * np.array(delays()[1:])], "hertz"),
        (lambda: delays()[::-1], "order"),
        (lambda: [0.01, 0.0155, 0.0047], "less than a whole period"),
    ],
    "hw1.2": [
        (lambda: lambda f, dt: f % (1 / dt), "half the sampling frequency"),
        (lambda: lambda f, dt: 0.0, "differ"),
    ],
    "hw1.3": [
        (lambda: 0.01, "go on"),
        (lambda: 0.05, "under 0.25"),
    ],
    "hw1.4": [
        (lambda: replace(start(), rig=replace(start().rig, filters=None)), "no filters at all"),
        (lambda: filtered(0.009, 39, 1e9, 6.0), "weakens the hum"),
        (start, "modulus margin at input 2"),
        (lambda: unbalanced(10.0), "unstable"),
        (lambda: filtered(0.002, 100, 30, 5.0), "busy"),
        (lambda: filtered(0.02, 15, 30, 4.0), "looks like a motion"),
        (lambda: filtered(0.008, 100, 30, 5.0), "staircase"),
        (lambda: filtered(0.0055, 60, 40, 5.0), "hum"),
        (lambda: pl.paper_design("double"), "another rig"),
    ],
    "hw1.5": [
        (lambda: (*own_design("hw1.4"), 0.01), "lean further"),
        (lambda: (*own_design("hw1.4"), 0.4), "does not come back"),
        (lambda: (start(), 0.05), "The design first"),
    ],
    "hw2.1": [
        (lambda: [0, 4], "Scale one row"),
        (lambda: [4, 4], "dimension of the null space"),
    ],
    "hw2.2": [
        (lambda: 0.3, "is the limit"),
        (lambda: 0.9, "faster by 0.02"),
    ],
    "hw2.3": [
        (lambda: (start(5.0),), "Two designs"),
        (lambda: (replace(start(5.0), E=(0.99, 0.7)), start(5.0)), "wrong for too long"),
        (lambda: (start(5.0), start(5.0)), "always agree"),
    ],
    "hw2.4": [
        (lambda: replace(start(5.0), kp=4.0), "F and k_p"),
        (lambda: replace(start(5.0), R=(10.0,)), "F and k_p"),
        (lambda: start(5.0), "equal"),
        (lambda: replace(start(5.0), E=(0.9, 0.99)), "wrong for too long"),
        (lambda: replace(start(5.0), E=(0.9, 0.7)), "modulus margin"),
        (lambda: replace(start(5.0), E=(0.95, 0.0)), "Sensor noise"),
    ],
    "hw3.1": [
        (lambda: start(5.0).model.A @ kalman(), "prediction"),
        (lambda: kalman().T, "transposed"),
        (lambda: np.zeros((4, 6)), "shape"),
        (lambda: kalman() * (np.arange(6) > 0)[:, None], "entry (0,"),
    ],
    "hw3.2": [
        (lambda: start(5.0).controller.system, "u = -P y"),
        (lambda: -start(5.0).controller.system, "missing among"),
    ],
    "hw3.3": [
        (lambda: process_noise(1e4), "less than 10%"),
        (lambda: -process_noise(1.0), "covariance"),
    ],
    "hw3.4": [
        (lambda: process_noise(1.0), "modulus margin at input 1"),
        (lambda: process_noise(1e-5), "unstable"),
        (lambda: process_noise(1e4), "modulus margin at input 1"),
    ],
    "hw3.5": [
        (lambda: Pilot, "Expected an object with step"),
        (lambda: Pilot("wanted"), "which one did the motor get"),
        (lambda: Pilot(integrates=0.0), "where is w"),
        (lambda: Pilot(integrates=-1.0), "w again"),
        (lambda: Selfish(), "not in self"),
        (Lazy, "falls"),
        (lambda: start(5.0).controller, "Sensor noise"),
    ],
    "hw4.1": [
        (lambda: slow_motion() * np.log(2), "half-life"),
        (lambda: 50072.0, "samples"),
        (lambda: slow_motion() / 60, "minutes"),
    ],
    "hw4.2": [
        (lambda: 250 / 20, "which power"),
        (lambda: 0.001, "which power"),
    ],
    "hw4.3": [
        (lambda: start(5.0), "time constant"),
        (lambda: with_weights(q6=100.0), "modulus margin"),
        (lambda: unbalanced(5.0), "unstable"),
    ],
    "hw4.4": [
        (lambda: with_weights(q1=25.0, q6=1.7), "for good after"),
        (lambda: with_weights(q1=1.0, q6=3.0), "swings out"),
    ],
    "hw5.1": [
        (
            lambda: lambda motor, ratio: replace(motor, ratio=ratio, gain=2 * motor.gain),
            "energy or power",
        ),
        (lambda: 3, "Expected your function"),
        (lambda: lambda motor, ratio: replace(motor, ratio=ratio), "energy or power"),
    ],
    "hw5.2": [
        (lambda: lambda rig: mass_and_gravity(rig, own_inertia=0), "turns about its own"),
        (lambda: lambda rig: mass_and_gravity(rig, g=0), "g is missing"),
        (lambda: lambda rig: (np.eye(rig.n_links), np.eye(rig.n_links)), "look again"),
    ],
    "hw5.3": [
        (lambda: ([5, 5, 5], 2), "one away per motor"),
        (lambda: ([4, 3, 2], 3), "number of rows"),
    ],
    "hw5.4": [
        (lambda: four_links(120, 120), "too weak"),
        (lambda: four_links(120, 120, 300), "to be had"),
        (lambda: own("triple"), "Links, filters and g"),
    ],
    "hw5.5": [
        (lambda: four_links(120, 120, 68), "pl.Design"),
        (lambda: four_links_design((0.7, 0.8, 0.9)), "unstable"),
    ],
    "hw6.1": [
        (lambda: lambda a: play_of_gear(a, whole=2), "side to side"),
        (lambda: stiff_gear, "nothing touches"),
    ],
    "hw6.2": [
        (
            lambda: lambda w: at_gear(w) - hw6.at_the_gear(hw6.reference(own()), w)[1],
            "moves under the torque",
        ),
        (lambda: lambda w: 2 - at_gear(w), "look again"),
    ],
    "hw6.3": [
        (lambda: ([29.0, 0.044, 0.054], "stable"), "predicted"),
        (lambda: (cycle(), "unstable"), "too large"),
    ],
    "hw6.4": [
        (lambda: np.array([2 * np.pi, 1]) * hw6.measured(soft_run()), "hertz"),
        (lambda: np.array([2, 1]) * hw6.measured(soft_run()), "upward crossings"),
    ],
    "hw6.5": [
        (lambda: (hw6.reference(own()), 0.0), "time constant"),
        (lambda: (own_design("hw6.5")[0], 0.0), "teeth"),
        (lambda: (hw6.reference(own()), 0.3), "at most"),
    ],
    "hw7.1": [
        (lambda: lambda *bar: carried(*bar, steiner=False), "centres are apart"),
        (lambda: lambda link, inertia, mass, height: link, "computed from both"),
    ],
    "hw7.2": [
        (lambda: (2, 1), "more is better"),
        (lambda: (1, 3), "less is better"),
    ],
    "hw7.3": [
        (lambda: (3, 0.05), "ratio"),
        (lambda: (2, 0.2), "does help"),
    ],
    "hw7.4": [
        (lambda: [2, 1.5, 0.2, 0.0], "weighs"),
        (lambda: [4, 1.5, 0.1, 0.0], "links 1 to 3"),
        (lambda: [3, 1.0, 0.1, 0.4], "Inertia helps"),
        (lambda: [3, 3.0, 0.1, 0.0], "at most"),
    ],
    "hw7.5": [
        (lambda: ((3, 1.5, 0.2, 0.0), start()), "The bar first"),
        (lambda: (*own_design("hw7.4"), start()), "another rig"),
        (lambda: with_bar((1, 1)), "falls"),
    ],
    "hw8.1": [
        (lambda: (np.cumsum(at_rest()[0][:3]), at_rest()[1]), "absolute"),
        (lambda: ([0, 0.1, -0.1], [0, 0]), "centre of mass"),
    ],
    "hw8.2": [
        (lambda: [(0,), (0, 1, 2)], "what gravity decides"),
        (lambda: [(1,), (1, 3)], "never lets the pendulum rest"),
        (lambda: [(0,), (1,)], "more of the candidates"),
    ],
    "hw8.3": [
        (lambda: attitudes(0.1), "after 2 s"),
        (start, "integrator"),
    ],
    "hw8.4": [
        (lambda: hw8.equilibrium(pl.linearize(own("triple")), (0.6, 0.5))[0][:3], "linear model"),
        (lambda: np.cumsum(hw8.bow(own("triple"))), "absolute"),
    ],
    "hw8.5": [
        (lambda: (start(), hw8.wave(0.01 * np.arange(2401))), "integrator"),
        (lambda: (attitudes(10), hw8.wave(0.01 * np.arange(2401))), "come late"),
        (lambda: (sent()[0], hw8.wave(0.95 + 0.01 * np.arange(2401))), "another amplitude"),
    ],
    "hw9.1": [
        (lambda: Uncorrected, "correct it"),
        (lambda: Backwards, "sign"),
        (lambda: Asleep, "falls"),
        (lambda: Forgetful, "not in self"),
    ],
    "hw9.2": [
        (lambda: lambda run: score(run, by_limit=False), "units of u_max"),
        (lambda: lambda run: 50 + 50 / (1 + np.std(run.angles)), "points of"),
    ],
    "hw9.3": [
        (lambda: FirstTry, "asked for"),
        (lambda: Asleep, "falls in 8"),
        (lambda: Crashing, "boom"),
    ],
    "hw9.4": [
        (lambda: (Wrapped, 1, None), "least_margin"),
        (lambda: (Wrapped, 1, wrapped_margin(filters=False)), "without filters"),
        (lambda: Asleep, "more often"),
        (lambda: (FirstTry, 1, wrapped_margin(made=FirstTry)), "by heart"),
    ],
}
