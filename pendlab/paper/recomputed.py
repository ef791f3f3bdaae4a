"""What stands behind the scoreboard: for each printed number the calculation that gives ours."""

from functools import partial
from operator import attrgetter

import numpy as np

from ..loop import crossings, frequency_response, loop_frequencies, margins
from ..nyquist import encirclements
from ..parameters import load
from ..sampled import align
from . import words
from .alignment import alignment_interval
from .designs import OBSERVERS, estimating_rows, paper_design
from .ledger import published

# Numbers that a design holds: key -> which, and where in it.
IN_THE_DESIGN = {
    "table1.gravity": ("double", "rig.g"),
    "table5.double.input_hz": ("double", "rig.filters.input_hz"),
    "table5.double.output_hz": ("double", "rig.filters.output_hz"),
    "table5.triple.input_hz": ("triple", "rig.filters.input_hz"),
    "table5.triple.output_hz": ("triple", "rig.filters.output_hz"),
    "eq1.A": ("double", "plant.A"),
    "eq1.B": ("double", "plant.B"),
    "eq1.C": ("double", "plant.C"),
    "eq1.input_limit": ("double", "rig.u_max"),
    "eq2.A": ("triple", "plant.A"),
    "eq2.B": ("triple", "plant.B"),
    "eq2.C": ("triple", "plant.C"),
    "eq2.input_limits": ("triple", "rig.u_max"),
    "eq23.F": ("double", "F"),
    "eq24.solutions": ("double", "family.dimension"),
    "eq32.F": ("triple", "F"),
    "eq36.solutions": ("triple", "family.dimension"),
    "sec5.integrator.T_s": ("triple", "dt"),
}

# Tables 2 to 4: the rig and which of its parts.
TABLES = {
    "table2": ("triple", "links", ("length", "mass", "inertia", "com", "friction")),
    "table3": ("triple", "motors", ("damping", "inertia", "gain", "ratio")),
    "table4": ("double", "links", ("length", "mass", "inertia", "com", "friction")),
}

# Nyquist curves of Figs 8, 10 and 11: the design, its observer, the loop, whether with filters.
CURVES = {
    "fig8.frequencies.nominal": ("double", 1, 0, False),
    "fig8.frequencies.observer1": ("double", 1, 0, True),
    "fig8.frequencies.observer2": ("double", 2, 0, True),
    "fig10.frequencies.nominal": ("triple", 1, 0, False),
    "fig10.frequencies.filters": ("triple", 1, 0, True),
    "fig11.frequencies.nominal": ("triple", 1, 1, False),
    "fig11.frequencies.filters": ("triple", 1, 1, True),
}


def _triple():
    return paper_design("triple")


def _in_the_design(name, where):
    return attrgetter(where)(paper_design(name))


def _column(rig, kind, field):
    """A column of a table; no length is printed for the last link."""
    parts = getattr(load(rig), kind)
    return [getattr(part, field) for part in (parts[:-1] if field == "length" else parts)]


def _eigenvalues(name, key):
    """Eigenvalues of the plant in the order of the paper."""
    ranks = np.argsort(np.argsort(published(key).values))
    return np.sort(np.linalg.eigvals(paper_design(name).plant.A).real)[ranks]


def _member(rig, number, part):
    o = paper_design(rig, number).observer
    copied = np.hstack([o.L1, o.L2])[: o.K.shape[1]]
    return {"T": o.T, "K": o.K, "L": estimating_rows(o), "L_copied": copied}[part]


def _frequency(end, rig, observer, index, filters):
    """Frequency (Hz) at which a loop meets the real axis left of -1 (lower), or the circle (upper)."""
    m = margins(paper_design(rig, observer).loop(index, filters))
    return (m.gain_down_omega if end == "lower" else m.crossover[-1]) / (2 * np.pi)


def _magnitudes(kp):
    """Magnitudes of the eigenvalues of A_t1; the root locus leaves out the least, near 0.15."""
    return np.abs(np.linalg.eigvals(align(_triple().model, kp).A))


def _locus_branches():
    """How many eigenvalues of A_t1 pass through the frame of Fig 6."""
    (left, right), (bottom, top) = published("fig6.frame").values
    seen = []
    for kp in np.linspace(*published("fig6.k_p_range").values, 201):
        z = np.linalg.eigvals(align(_triple().model, kp).A)
        framed = (left < z.real) & (z.real < right) & (bottom < z.imag) & (z.imag < top)
        seen.append(framed.sum())
    return max(seen)


def det_crossing(loop, omega=None, curve=None):
    """Where det(I + L) meets the negative real axis next to 0, rad/s; nan where it does not.

    `curve` are its values at `omega`, where these are known.
    """

    def det(omega):
        return np.linalg.det(np.eye(loop.ninputs) + frequency_response(loop, omega))

    if omega is None:
        omega = loop_frequencies(loop)
        curve = det(omega)
    left = np.where(curve.real < 0, curve.imag, np.nan)
    at = crossings(omega, left, lambda w: det(w)[0].imag)
    return max(at, key=lambda w: det(w)[0].real, default=np.nan)


RECOMPUTED = {
    **{key: partial(_in_the_design, *where) for key, where in IN_THE_DESIGN.items()},
    **{
        f"{table}.{field}": partial(_column, rig, kind, field)
        for table, (rig, kind, fields) in TABLES.items()
        for field in fields
    },
    **{
        key: partial(_member, rig, number, key.partition(".")[2])
        for (rig, number), keys in OBSERVERS.items()
        for key in (*keys, f"{keys[2]}_copied")
    },
    **{
        f"{key}.{end}": partial(_frequency, end, *curve)
        for key, curve in CURVES.items()
        for end in ("lower", "upper")
    },
    "eq1.eigenvalues": partial(_eigenvalues, "double", "eq1.eigenvalues"),
    "eq2.eigenvalues": partial(_eigenvalues, "triple", "eq2.eigenvalues"),
    "eq18.eigenvalue.k_p_0": lambda: _magnitudes(0).min(),
    "eq18.eigenvalue.k_p_10": lambda: _magnitudes(10).min(),
    "eq18.eigenvalue.k_p_20": lambda: _magnitudes(20).min(),
    "eq18.k_p_interval": lambda: alignment_interval(_triple().model),
    "eq18.unstable": lambda: np.sum(_magnitudes(_triple().kp) > 1),
    "fig6.eigenvalues": _locus_branches,
    "fig7.encirclements": lambda: encirclements(paper_design("double").state_feedback_loop).turns,
    "fig11.encirclements": lambda: encirclements(_triple().loop(1)).turns,
    "fig12.encirclements": lambda: encirclements(_triple().nominal_loop).turns,
    "fig12.frequencies.nominal.lower": lambda: det_crossing(_triple().nominal_loop) / (2 * np.pi),
    "fig12.frequencies.filters.lower": lambda: det_crossing(_triple().filtered_loop) / (2 * np.pi),
    "sec5.integrator.feedback": lambda: _triple().F[0, -1],
}

# Judged on the ensemble: the share of runs for which the words hold.
SHARES = {
    "sec5.attitude_range": words.attitude_share,
    "sec5.triple.alignment": partial(words.share, "triple", words.aligned),
    "sec5.triple.growing_until": partial(words.share, "triple", words.growing),
    "sec5.triple.steady_after": partial(words.share, "triple", words.reduced),
    "sec5.double.steady_after": partial(words.share, "double", words.steady),
}
