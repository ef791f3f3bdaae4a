"""Checks of the notebooks' exercises on a rig of one's own, and answers found another way."""

from dataclasses import replace

import numpy as np

import pendlab as pl


def own_triple_limit(own=None):
    own = pl.my_rig("Ada", "triple") if own is None else own
    sampled = pl.sample(pl.linearize(own))
    return own, -1 / np.linalg.solve(np.eye(6) - sampled.A, sampled.B[:, 1])[2]


def test_own_rig_has_its_own_answer():
    own, answer = own_triple_limit()
    assert pl.check("04.4", answer, rig=own)
    assert not pl.check("04.4", own_triple_limit(pl.load("triple"))[1], rig=own)


def test_slow_fold_of_half_the_gear_ratio():
    def slow(power, rig):
        motor = rig.motors[0]
        half = replace(
            motor,
            gain=motor.gain / 2,
            inertia=motor.inertia / 2**power,
            damping=motor.damping / 2**power,
        )
        poles = pl.linearize(replace(rig, motors=(half,))).poles().real
        return min(poles[poles > 0])

    for rig in (pl.my_rig("Bela"), pl.my_rig("Ada")):
        assert pl.check("A.5", slow(2, rig), rig=rig)
        assert "power" in pl.check("A.5", slow(1, rig), rig=rig).message
        assert (
            "as it is"
            in pl.check(
                "A.5", min(p for p in pl.linearize(rig).poles().real if p > 0), rig=rig
            ).message
        )


def test_five_per_cent_of_bending_and_volts_of_one_motor():
    f, A = pl.nonlinear(pl.load("double")), pl.paper_design("double").plant.A

    def off(x):
        return np.linalg.norm(A @ x - f(x, 0)) / np.linalg.norm(f(x, 0))

    angles = np.arange(0.2, 0.8, 1e-3)
    bend, lean = (
        angles[np.argmax([off(np.append(a * np.array(shape), [0, 0])) > 0.05 for a in angles])]
        for shape in ([0, 1], [1, 0])
    )
    assert pl.check("02.3", bend)
    assert "leans" in pl.check("02.3", lean).message
    assert "degrees" in pl.check("02.3", np.degrees(bend)).message

    # A mode w is caught from a lean below |w B| u_max / (s |w1|); the one with the least decides.
    plant, limits = pl.linearize(pl.load("triple")), np.array(pl.load("triple").u_max)
    s, V = np.linalg.eig(plant.A)
    left = np.linalg.inv(V).real[s.real > 0] / s.real[s.real > 0, None]
    shares = np.abs(left @ plant.B) / np.abs(left[:, :1]) / s.real[s.real > 0, None]
    both, alone = (shares @ limits).min(), shares[:, 0].min()
    assert pl.check("02.6", both / alone)
    assert "factor" in pl.check("02.6", both / alone / limits[0]).message
    assert "add up" in pl.check("02.6", limits.sum()).message
