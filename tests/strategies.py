"""Hypothesis strategies: random rigs of 2 to 4 links, weights and observer dynamics."""

import numpy as np
from hypothesis import strategies as st

import pendlab as pl


def between(low, high):
    return st.floats(low, high, allow_nan=False)


def decades(low, high):
    """Numbers from 10^low to 10^high, as likely in one decade as in another."""
    return between(low, high).map(lambda exponent: 10.0**exponent)


@st.composite
def links(draw):
    length = draw(between(0.1, 0.4))
    mass = draw(between(0.3, 1.5))
    com = length * draw(between(0.4, 0.9))
    inertia = mass * length**2 * draw(between(0.05, 0.2))
    return pl.Link(length, mass, inertia, com, friction=draw(between(0.0, 0.05)))


@st.composite
def motors(draw):
    return pl.Motor(
        damping=draw(between(0.05, 5.0)),
        inertia=draw(between(0.0, 0.03)),
        gain=draw(between(0.5, 2.0)),
        ratio=draw(between(20.0, 300.0)),
    )


@st.composite
def rigs(draw, n_links=None, least_motors=1):
    """Any rig. `least_motors` 2 leaves out three links on one motor, whose gains of 1e5 V/rad use
    up the digits that an identity would be compared in.
    """
    n = draw(st.integers(2, 4) if n_links is None else n_links)
    m = draw(st.integers(min(least_motors, n - 1), n - 1))
    return pl.Pendulum(
        links=[draw(links()) for _ in range(n)],
        motors=[draw(motors()) for _ in range(m)],
        filters=pl.Filters(
            [draw(between(5, 30)) for _ in range(m)], [draw(between(10, 60)) for _ in range(n + 1)]
        ),
        name="random",
    )


def weights(size, low=-3, high=3):
    return st.lists(decades(low, high), min_size=size, max_size=size)


@st.composite
def full_weights(draw, size):
    """A symmetric positive definite matrix that is not diagonal."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    root = rng.standard_normal((size, size))
    return root @ root.T + 0.1 * np.eye(size)


@st.composite
def dynamics(draw, size):
    """E as a number, a diagonal, complex pairs or a full matrix, eigenvalues well apart from A's."""
    kind = draw(st.sampled_from(["number", "diagonal", "pairs", "full"]))
    if kind == "number" or size == 1:
        return draw(between(0.3, 0.9))
    spread = np.linspace(0.3, 0.85, size) + draw(between(0.0, 0.05))
    if kind == "diagonal":
        return spread
    E = np.diag(spread)
    angle = draw(between(0.2, 1.5))
    E[:2, :2] = spread[0] * np.array(
        [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    )
    if kind == "pairs":
        return E
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    X = np.eye(size) + 0.3 * rng.standard_normal((size, size)) / size
    return np.linalg.solve(X, E @ X)


def states(n, angle=0.5, rate=2.0):
    return st.tuples(
        st.lists(between(-angle, angle), min_size=n, max_size=n),
        st.lists(between(-rate, rate), min_size=n, max_size=n),
    ).map(lambda parts: np.array([*parts[0], *parts[1]]))
