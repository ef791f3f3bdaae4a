"""What the computed figures claim: captions and descriptions, every number from the data drawn.

Each function returns (caption, alt). Words about the paper's numbers appear for its own designs only.
"""

import numpy as np

from ..paper.designs import paper_design
from ..paper.ledger import published
from .frequency import HZ, decibels


def of_locus(data, design):
    """Root locus over k_p."""
    at, n = int(np.argmin(np.abs(data.kps - data.kp))), len(data.marked)
    outside = data.outside(published("fig6.frame").values)
    gains = f"{data.kps[0]:g}, {data.kp:g} and {data.kps[-1]:g}"
    rest = "".join(
        f" Outside the frame one moves from {b[0].real:.4f} through {b[at].real:.4f} to "
        f"{b[-1].real:.4f} (k_p = {gains})."
        for b in outside
    )
    meets = " and ".join(f"{kp:.2f}" for kp in data.changes)
    paper = f" (paper {published('eq18.k_p_interval').values[0]:g})"
    paper = paper if is_papers(design, "triple") else ""
    changes = f" An eigenvalue meets the unit circle at k_p = {meets}{paper}." if meets else ""
    return (
        f"Fig 6. At k_p = {data.kp:g} motor 2's position loop leaves {data.unstable} of "
        f"{n} eigenvalues outside the unit circle.{changes}{rest}",
        f"Root locus in the z-plane near z = 1 for k_p from {data.kps[0]:g} to {data.kps[-1]:g} "
        f"V/rad: {n - len(outside)} of {n} eigenvalues, the unit circle, starts as open circles and "
        f"crosses at k_p = {data.kp:g}: {listed(data.marked)}.",
    )


def of_turns(data, name):
    """A full Nyquist curve."""
    turns, poles, closed = data.count
    each = f"one for each unstable open-loop pole ({listed(data.unstable)})"
    verdict = f"{each}, so the closed loop is stable"
    if closed:
        verdict = f"but {poles} open-loop poles are unstable, so {closed} closed-loop poles are too"
    arc = (
        " The contour passes the integrator at z = 1 on the outside; that small arc becomes the "
        "far one that closes the curve."
    )
    arc = arc if data.integrators else ""
    radii = ", ".join(f"{r:.3g}" for r in np.sort(data.ray[1]))
    return (
        f"{name} makes {times(turns)} anticlockwise about {data.critical:g}, {verdict}.{arc}",
        f"Two panels on logarithmic distances. Left: the contour, once anticlockwise round the unit "
        f"circle seen from z = 1, with {poles} unstable open-loop poles outside it. Right: its image "
        f"round the critical point {data.critical:g}, both conjugate halves with arrows; a ray from "
        f"the critical point meets it at distances {radii}, net count {turns}.",
    )


def _of_8(curves, *designs):
    """Loop gain at one input, nominal and with filters for one or two observers."""
    nominal, *filtered = curves
    each = "; ".join(
        f"observer {i} crosses at {c.marked_omega[1] / HZ:.2f} Hz, {_bears(c)} and keeps "
        f"{c.distance:.2f} from -1"
        if c.count.stable
        else f"observer {i} leaves the closed loop unstable"
        for i, c in enumerate(filtered, 1)
    )
    return (
        f"Fig 8. Without filters every observer with H = 0 gives back the state feedback's loop, "
        f"which {_bears(nominal)}. With filters {each}.",
        f"Nyquist curves of the loop gain near -1 with the unit circle. State feedback: "
        f"{_seen(nominal)}. "
        + " ".join(f"Observer {i} with filters: {_seen(c)}." for i, c in enumerate(filtered, 1)),
    )


def _of_10(curves, design):
    """rd1 - 1 without and with filters."""
    filtered = curves[1]
    far = ", the loop keeps well away from -1" if filtered.distance > 0.5 else ""
    bears = ""
    if filtered.count.stable:
        bears = f", and it {_bears(filtered)} or {filtered.margins.gain_down:.2f} of it"
    lead = f"Fig 10. Broken at input 1{far}: with the filters "
    return f"{lead}{_fall(curves)}{bears}{_verdict(curves)}.", _alt("rd1 - 1", curves)


def _of_11(curves, design):
    """rd2 - 1 without and with filters, and where its turns come from."""
    nominal, filtered = curves
    lead = "Broken at input 2: with the filters "
    if filtered.distance < nominal.distance / 2:
        lead = "The filters cost input 2 its margins: "
    bears = ""
    if filtered.count.stable:
        phase = np.degrees(filtered.margins.phase)
        bears = f", and the loop {_bears(filtered)} and {phase:.1f} degrees of phase"
    turns = _turns_at_input_2(nominal, design)
    caption = f"Fig 11. {lead}{_fall(curves)}{bears}{_verdict(curves)}. {turns}"
    return caption, _alt("rd2 - 1", curves)


def _turns_at_input_2(nominal, design):
    """Turns that rd2 - 1 has to make, with those that integrators add."""
    opened = np.linalg.eigvals(design.loop(1).A)
    A, B, F = design.model.A, design.model.B, design.controller.F[:, : design.model.nstates]
    others = [i for i in range(len(F)) if i != 1]
    from_states = int(np.sum(np.abs(np.linalg.eigvals(A - B[:, others] @ F[others])) > 1))
    total = nominal.count.unstable_open
    paper = f" (the paper counts {published('fig11.encirclements').values:g})"
    text = f"Stability takes {times(total)} about -1{paper if is_papers(design, 'triple') else ''}"
    if total != from_states + 1:
        return f"{text}."
    slow = opened[np.argmin(np.abs(opened - 1))].real
    return (
        f"{text}: {from_states} for the poles that feeding the states back to input 1 leaves "
        f"unstable, and a slow one for the integrator, whose pole that loop moves out to {slow:.7f}."
    )


def _of_12(curves, design):
    """det(I + P G) without and with filters."""
    near = curves[1].distance < curves[0].distance
    lead = "the filters bring it nearer" if near else "with the filters"
    return (
        f"Fig 12. Both loops broken, det(I + P G) must make {times(curves[0].count.unstable_open)} "
        f"about 0, one for each unstable pole of the plant; {lead}: {_fall(curves)}{_verdict(curves)}.",
        _alt("det(I + P G)", curves),
    )


def of_sigma(curves, design):
    """Smallest singular value of I + P G without and with filters."""
    low = [f"{decibels(c.lowest):.1f} dB at {c.lowest_omega / HZ:.2f} Hz" for c in curves]
    return (
        f"Fig 14. With the filters the smallest singular value of I + P G goes from {low[0]} to "
        f"{low[1]}: there an unstructured change of P G of size {curves[1].lowest:.3f} already makes "
        f"I + P G singular.",
        f"Smallest singular value of I + P G in dB over frequency up to the Nyquist frequency "
        f"{0.5 / design.dt:g} Hz. Without filters the lowest point is {low[0]}, with filters "
        f"{low[1]}.",
    )


OF_FIGURE = {8: _of_8, 10: _of_10, 11: _of_11, 12: _of_12}  # near the critical point


def is_papers(design, name, observer=1):
    """Whether this is the paper's own design, whose printed numbers may stand beside ours."""
    return design == paper_design(name, observer)


def times(turns):
    return f"{turns} turn{'s' * (abs(turns) != 1)}"


def listed(values):
    """Eigenvalues in words, a conjugate pair once."""
    return ", ".join(
        f"{v.real:.6g}" if abs(v.imag) < 1e-9 else f"{v.real:.5g} ± {v.imag:.5g}j"
        for v in np.asarray(values, dtype=complex)
        if v.imag > -1e-9
    )


def _fall(curves):
    near = " to ".join(f"{c.distance:.{2 if c.distance >= 0.1 else 3}f}" for c in curves)
    return f"the smallest distance from {curves[0].critical:g} goes from {near}"


def _bears(curve):
    """The rise of gain that a stable loop bears."""
    up = curve.margins.gain_up
    return f"bears {up:.3g} times the gain" if np.isfinite(up) else "bears any rise of the gain"


def _verdict(curves):
    """What is unstable, if anything is."""
    where = [word for word, c in zip(("without", "with"), curves) if not c.count.stable]
    return f"; {' and '.join(where)} filters the closed loop is unstable" if where else ""


def _seen(curve):
    places = "meets the real axis", "meets the unit circle"
    at = [
        f"{place} at {omega / HZ:.2f} Hz"
        for place, omega in zip(places, curve.marked_omega, strict=True)
        if np.isfinite(omega)
    ]
    found = " and ".join(at) or "no crossing beside the critical point"
    return f"{found}; smallest distance {curve.distance:.3g} at {curve.distance_omega / HZ:.2f} Hz"


def _alt(name, curves):
    return (
        f"Nyquist curves of {name} near the critical point {curves[0].critical:g}. Without filters: "
        f"{_seen(curves[0])}. With filters: {_seen(curves[1])}."
    )
