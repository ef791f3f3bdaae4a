"""The paper's computed figures: 6 to 8 and 10 to 14, from a design that can be changed.

Every function returns a `CaptionedFigure` with ``fig.update(design)``, which recomputes curves,
caption and description for another design and only changes the artists' data.
"""

import numpy as np

from .._checks import found
from ..design import Design
from ..ledger import published
from ..paper import paper_design
from .frequency import HZ, decibels, draw_nyquist, draw_sigma_min, nyquist, sigma_min
from .rootlocus import draw_root_locus, root_locus
from .style import describe, freeze_layout, look, new_figure, styled
from .turns import draw_contour, draw_turns, full_nyquist

__all__ = ["fig6", "fig7", "fig8", "fig10", "fig11", "fig12", "fig13", "fig14", "turns_figure"]

WITHOUT = "without filters"
ZOOM = (0.42, 0.6, 0.28, 0.36), 0.12  # the inset of Fig 11


@styled()
def fig6(design=None, kps=None):
    """Fig 6: eigenvalues of A - B2 k_p C_p C, equation (19), over the gains `kps` (V/rad)."""
    design = _given(design, "triple")
    if design.kp is None:
        raise ValueError(
            "design: expected one with k_p to mark in Fig 6, found kp=None; "
            "use dataclasses.replace(design, kp=10.0)."
        )
    kps = np.linspace(*published("fig6.k_p_range").values, 201) if kps is None else kps
    frame = published("fig6.frame").values
    fig = new_figure(7, 4.6)
    draw = lambda data: draw_root_locus(fig.subplots(), data, frame)  # noqa: E731
    return _live(fig, draw, lambda d: root_locus(d.model, kps, d.kp), _words6, design)


def _words6(data, design):
    at, n = int(np.argmin(np.abs(data.kps - data.kp))), len(data.marked)
    outside = data.outside(published("fig6.frame").values)
    gains = f"{data.kps[0]:g}, {data.kp:g} and {data.kps[-1]:g}"
    rest = "".join(
        f" Outside the frame one moves from {b[0].real:.4f} through {b[at].real:.4f} to "
        f"{b[-1].real:.4f} (k_p = {gains})."
        for b in outside
    )
    meets = " and ".join(f"{kp:.2f}" for kp in data.changes)
    paper = ""
    if _is(design, "triple"):
        paper = f" (paper {published('eq18.k_p_interval').values[0]:g})"
    changes = f" An eigenvalue meets the unit circle at k_p = {meets}{paper}." if meets else ""
    return (
        f"Fig 6. At k_p = {data.kp:g} the upper motor's position loop leaves {data.unstable} of "
        f"{n} eigenvalues outside the unit circle.{changes}{rest}",
        f"Root locus in the z-plane near z = 1 for k_p from {data.kps[0]:g} to {data.kps[-1]:g} "
        f"V/rad: {n - len(outside)} of {n} eigenvalues, the unit circle, starts as open circles and "
        f"crosses at k_p = {data.kp:g}: {_listed(data.marked)}.",
    )


@styled()
def fig7(design=None):
    """Fig 7: the full Nyquist curve of F (zI - A)^-1 B, turns counted."""
    design = _given(design, "double")
    return _turns(design, lambda d: d.state_feedback_loop, "Fig 7. F (zI - A)^-1 B")


@styled()
def fig13(design=None):
    """Fig 13: the full curve of det(I + P G), turns counted."""
    design = _several(_given(design, "triple"), 13)
    return _turns(design, lambda d: d.nominal_loop, "Fig 13. det(I + P G)")


@styled()
def turns_figure(loop, name="The loop"):
    """The whole Nyquist curve of any sampled loop with its contour, turns counted (Figs 7, 13).

    The figure's ``update`` takes another loop; `name` begins the caption.
    """
    return _turns(loop, lambda loop: loop, name)


def _turns(subject, loop_of, name):
    fig = new_figure(9, 5.95, layout=None)
    left, right = (fig.add_axes((x / 9, 1.3 / 5.95, 4.3 / 9, 4.3 / 5.95)) for x in (0.1, 4.6))

    def draw(data):
        updates = draw_contour(left, data), draw_turns(right, data)
        return lambda data: [update(data) for update in updates]

    def words(data, _):
        turns, poles, closed = data.count
        verdict = (
            f"one for each unstable open-loop pole ({_listed(data.unstable)}), so the closed loop is "
            "stable"
            if data.count.stable
            else f"but {poles} open-loop poles are unstable, so {closed} closed-loop poles are too"
        )
        arc = (
            " The contour passes the integrator at z = 1 on the outside; that small arc becomes the "
            "far one that closes the curve."
            if data.integrators
            else ""
        )
        return (
            f"{name} makes {_times(turns)} anticlockwise about {data.critical:g}, {verdict}.{arc}",
            f"Two panels on logarithmic distances. Left: the contour, once anticlockwise round the "
            f"unit circle seen from z = 1, with {poles} unstable open-loop poles outside it. Right: "
            f"its image round the critical point {data.critical:g}, both conjugate halves with "
            f"arrows; a ray from the critical point meets it at distances "
            f"{', '.join(f'{r:.3g}' for r in np.sort(data.ray[1]))}, net count {turns}.",
        )

    return _live(fig, draw, lambda s: full_nyquist(loop_of(s)), words, subject)


@styled()
def fig8(design=None, other=None):
    """Fig 8: loop gain at the input, nominal and with filters, near the critical point.

    `other` is a second design whose filtered loop is drawn dotted; without arguments the two
    observers of the paper are compared. ``fig.update(design, other)`` takes as many designs.
    """
    if design is None and other is None:
        other = paper_design("double", 2)
    designs = [_given(d, "double") for d in ((design,) if other is None else (design, other))]
    looks = [look("nominal"), look("filters", label="observer 1, with filters"), look("observer2")]
    looks = looks[: 1 + len(designs)]

    def compute(*designs):
        loops = [design.loop(0, filters=True) for design in designs]
        return [nyquist(loop) for loop in (designs[0].loop(0), *loops)]

    def paper(*designs):
        known = all(_is(design, "double", i) for i, design in enumerate(designs, 1))
        return _printed(8, ("nominal", "observer1", "observer2")[: len(looks)]) if known else None

    return _near("8", compute, _words8, looks, paper, *designs)


def _words8(curves, *designs):
    nominal, *filtered = curves
    each = [
        f"observer {i} crosses at {c.marked_omega[1] / HZ:.2f} Hz, bears {c.margins.gain_up:.1f} times "
        f"the gain and keeps {c.distance:.2f} from -1{_unstable(c)}"
        for i, c in enumerate(filtered, 1)
    ]
    return (
        f"Fig 8. Without filters the observer gives back the state feedback's loop, which bears "
        f"{nominal.margins.gain_up:.1f} times the gain{_unstable(nominal)}. With filters "
        f"{'; '.join(each)}.",
        f"Nyquist curves of the loop gain near -1 with the unit circle. State feedback: "
        f"{_seen(nominal)}. "
        + " ".join(f"Observer {i} with filters: {_seen(c)}." for i, c in enumerate(filtered, 1)),
    )


@styled()
def fig10(design=None):
    """Fig 10: rd1 - 1, equation (33), the loop broken at input 1, without and with filters."""
    design = _several(_given(design, "triple"), 10)
    return _pair("10", design, lambda d, filters: d.loop(0, filters), _words10)


def _words10(curves, design):
    return (
        f"Fig 10. Broken at input 1 the loop stays well away from -1: {_fall(curves)}. With filters "
        f"the gain may rise {curves[1].margins.gain_up:.3g} times or fall to "
        f"{curves[1].margins.gain_down:.2f} of itself{_unstable(curves[1])}.",
        _alt("rd1 - 1", curves),
    )


@styled()
def fig11(design=None):
    """Fig 11: rd2 - 1, equation (34), the loop broken at input 2, without and with filters."""
    design = _several(_given(design, "triple"), 11)
    return _pair("11", design, lambda d, filters: d.loop(1, filters), _words11, ZOOM)


def _words11(curves, design):
    m, count = curves[1].margins, curves[0].count
    words = (
        f"Fig 11. The filters cost input 2 its margins: {_fall(curves)}; with them the gain may rise "
        f"only {m.gain_up:.2f} times and the phase change {np.degrees(m.phase):.1f} "
        f"degrees{_unstable(curves[1])}. "
    )
    if _is(design, "triple"):
        slow = np.linalg.eigvals(design.loop(1).A)
        slow = slow[np.argmin(np.abs(slow - 1))].real
        words += (
            f"Stability takes {_times(count.unstable_open)} about -1, "
            f"{published('fig11.encirclements').values:g} in the paper: that counts the "
            f"{_unstable_without_integrator(design)} poles which state feedback alone leaves unstable "
            f"at input 1; the integrator adds one at {slow:.7f} and a slow turn outside the frame."
        )
    else:
        words += f"Stability takes {_times(count.unstable_open)} about -1."
    return words, _alt("rd2 - 1", curves)


def _unstable_without_integrator(design):
    """Unstable eigenvalues with input 1 fed back from the states alone and input 2 open."""
    A, B = design.model.A, design.model.B
    closed = A - np.outer(B[:, 0], design.controller.F[0, : len(A)])
    return int(np.sum(np.abs(np.linalg.eigvals(closed)) > 1))


@styled()
def fig12(design=None):
    """Fig 12: det(I + P G), both loops broken, without and with filters."""
    design = _several(_given(design, "triple"), 12)
    loop = lambda d, filters: d.filtered_loop if filters else d.nominal_loop  # noqa: E731
    return _pair("12", design, loop, _words12)


def _words12(curves, design):
    count = curves[0].count
    return (
        f"Fig 12. With both loops broken det(I + P G) must make {_times(count.unstable_open)} about 0, "
        f"the plant's unstable poles; the filters bring it nearer: {_fall(curves)}"
        f"{_unstable(curves[1])}.",
        _alt("det(I + P G)", curves),
    )


@styled()
def fig14(design=None):
    """Fig 14: smallest singular value of I + P G in dB over Hz, without and with filters."""
    design = _several(_given(design, "triple"), 14)
    fig, frame = new_figure(7, 4.2), published("fig14.frame").values
    draw = lambda data: draw_sigma_min(fig.subplots(), data, _two_looks(), frame)  # noqa: E731
    compute = lambda d: [sigma_min(loop) for loop in (d.nominal_loop, d.filtered_loop)]  # noqa: E731
    return _live(fig, draw, compute, _words14, design)


def _words14(curves, design):
    low = [f"{decibels(c.lowest):.1f} dB at {c.lowest_omega / HZ:.2f} Hz" for c in curves]
    return (
        f"Fig 14. The filters bring the smallest singular value of I + P G from {low[0]} down to "
        f"{low[1]}: there an unstructured change of P G of size {curves[1].lowest:.3f} is enough "
        f"to lose stability.",
        f"Smallest singular value of I + P G in dB over frequency up to the Nyquist frequency "
        f"{0.5 / design.dt:g} Hz. Without filters the lowest point is {low[0]}, with filters "
        f"{low[1]}.",
    )


# What the figures share


def _live(fig, draw, compute, words, *designs):
    """Draw once, and give the figure its ``update(*designs)``."""
    data = compute(*designs)
    redraw = draw(data)
    freeze_layout(fig)

    def update(*designs, data=None):
        data = compute(*designs) if data is None else data
        redraw(data)
        return describe(fig, *words(data, *designs))

    fig.update = lambda *designs: update(*designs)
    return update(*designs, data=data)


def _near(number, compute, words, looks, paper, *designs, zoom=None):
    """A figure of Nyquist curves near the critical point, in the paper's frame, legend below."""
    frame = published(f"fig{number}.frame").values
    width, height = np.ptp(frame, axis=1)
    inch = min(6.0 / width, 4.5 / height)
    below = 0.12 * inch * height + 0.22 * (len(looks) + 3) + 0.1
    size = 7.0, inch * height + below + 0.15
    fig = new_figure(*size, layout=None)
    ax = fig.add_axes((0.8 / 7, below / size[1], inch * width / 7, inch * height / size[1]))

    def draw(pair):
        redraw = draw_nyquist(ax, pair[0], looks, frame, pair[1], zoom)
        return lambda pair: redraw(*pair)

    return _live(
        fig,
        draw,
        lambda *designs: (compute(*designs), paper(*designs)),
        lambda pair, *designs: words(pair[0], *designs),
        *designs,
    )


def _pair(number, design, loop_of, words, zoom=None):
    """Figs 10 to 12: one loop without and with filters."""
    compute = lambda d: [nyquist(loop_of(d, filters)) for filters in (False, True)]  # noqa: E731
    paper = lambda d: _printed(number, ("nominal", "filters")) if _is(d, "triple") else None  # noqa: E731
    return _near(number, compute, words, _two_looks(), paper, design, zoom=zoom)


def _two_looks():
    return [look("nominal", label=WITHOUT), look("filters")]


def _printed(number, curves):
    """The frequencies printed beside a figure's curves: (real axis, unit circle) in Hz for each."""
    known = {
        entry.key: float(entry.values) for entry in published() if ".frequencies." in entry.key
    }
    names = [f"fig{number}.frequencies.{curve}" for curve in curves]
    return [(known.get(f"{name}.lower"), known.get(f"{name}.upper")) for name in names]


def _given(design, name):
    if design is None:
        return paper_design(name)
    if not isinstance(design, Design):
        raise TypeError(
            f'design: expected a pl.Design, {found(design)}; try pl.paper_design("{name}").'
        )
    return design


def _several(design, number):
    if design.rig.n_motors < 2:
        raise ValueError(
            f"design: Fig {number} takes a rig with two motors or more, found {design.rig.n_motors}; "
            'try pl.paper_design("triple").'
        )
    return design


def _is(design, name, observer=1):
    """Whether this is the paper's own design, whose printed numbers may stand beside ours."""
    return design == paper_design(name, observer)


def _fall(curves):
    near = " to ".join(f"{c.distance:.3f}".rstrip("0") if c.distance < 0.1 else f"{c.distance:.2f}"
                       for c in curves)  # fmt: skip
    return f"the smallest distance from {curves[0].critical:g} goes from {near}"


def _unstable(curve):
    return "" if curve.count.stable else " (the closed loop is unstable)"


def _times(turns):
    return f"{turns} turn{'s' * (abs(turns) != 1)}"


def _listed(values):
    """Eigenvalues in words, a conjugate pair once."""
    return ", ".join(
        f"{v.real:.6g}" if abs(v.imag) < 1e-9 else f"{v.real:.5g} ± {v.imag:.5g}j"
        for v in np.asarray(values, dtype=complex)
        if v.imag > -1e-9
    )


def _seen(curve):
    at = [
        f"{where} at {omega / HZ:.2f} Hz"
        for where, omega in zip(("meets the real axis", "the unit circle"), curve.marked_omega)
        if np.isfinite(omega)
    ]
    words = " and ".join(at) or "no crossing beside the critical point"
    return f"{words}; smallest distance {curve.distance:.3g} at {curve.distance_omega / HZ:.2f} Hz"


def _alt(name, curves):
    return (
        f"Nyquist curves of {name} near the critical point {curves[0].critical:g}. Without filters: "
        f"{_seen(curves[0])}. With filters: {_seen(curves[1])}."
    )
