"""Block diagrams: the apparatus (Fig 4), the observer-based controller (Fig 5), two loops (Fig 9).

Axes are in inches, so that a position below is a position on the page.
"""

from itertools import pairwise

import numpy as np
from matplotlib.patches import Circle

from .._arguments import number
from .apparatus import limit_of
from .frequency import filter_lag
from .moving import check_rig
from .sketch import INK, arrow, box, canvas, line, note
from .style import COLORS, angle_label, describe, styled

CUT = COLORS["vermillion"]
PLANT, COMPUTER = "#FBE9DC", "#DCEBF7"  # faces of boxes


class Diagram:
    """Boxes and sums with names, and the wires between them."""

    def __init__(self, width, height):
        self.fig, self.ax = canvas(width, height)
        self._places = {}  # name -> centre, half of width and height

    def box(self, name, x, y, text, width=0.7, height=0.5, face=COLORS["pale"], **style):
        """A block centred at (x, y)."""
        self._places[name] = np.array([x, y]), np.array([width, height]) / 2
        box(self.ax, x, y, width, height, face, 0.06, **{"linewidth": 1.4, **style})
        note(self.ax, x, y, text, zorder=4)

    def sum(self, name, x, y, signs):
        """A summing point; signs maps an offset (dx, dy) to its sign."""
        self._places[name] = np.array([x, y]), np.array([0.12, 0.12])
        self.ax.add_patch(
            Circle((x, y), 0.12, facecolor="white", edgecolor=INK, linewidth=1.4, zorder=3)
        )
        for (dx, dy), sign in signs.items():
            note(self.ax, x + dx, y + dy, sign, fontsize=13)

    def wire(self, *stops, **style):
        """A signal through straight pieces, from a name or point to the edge of the last name."""
        points = [self._places[s][0] if isinstance(s, str) else np.array(s) for s in stops]
        if isinstance(stops[-1], str):
            centre, half = self._places[stops[-1]]
            points[-1] = centre + half * np.sign(np.round(points[-2] - centre, 9))
        arrow(self.ax, *points, **style)

    def branches(self, *points):
        """Dots where a signal goes two ways."""
        line(self.ax, *points, linestyle="none", marker="o", markersize=5, zorder=3)

    def cut(self, x, y, name):
        """The mark where a loop is broken, on a white gap of the line."""
        size = 0.085
        line(self.ax, (x - size, y), (x + size, y), color="white", linewidth=6, zorder=2.5)
        at = x + 0.19 * (np.arange(len(name)) - (len(name) - 1) / 2)
        cross = dict(marker="x", markersize=14, markeredgewidth=2.6, color=CUT)
        self.ax.plot(at, np.full(len(at), y), linestyle="none", zorder=4, **cross)
        note(self.ax, x, y + 0.27, name, color=CUT, fontweight="bold")

    def names(self, *notes, **style):
        """Words at (x, y), each given as (x, y, text)."""
        for x, y, text in notes:
            note(self.ax, x, y, text, **style)


def _of_first_order(filters, which):
    """Distinct cut-offs in words: first order, 10.26 Hz."""
    if not filters:
        return "none in this rig"
    each = " and ".join(f"{hz:g}" for hz in sorted(set(getattr(filters, which))))
    return f"first order, {each} Hz"


@styled()
def apparatus_blocks(rig, dt=0.01):
    """Fig 4: the signals' way from the computer through filters, amplifiers and pendulum and back.

    Cut-off frequencies and voltage limits are those of the rig; `dt` is the sampling time, s.
    """
    check_rig(rig)
    number("dt", dt, above=0)
    n, m, filters = rig.n_links, rig.n_motors, rig.filters
    limits = ",  ".join(filter(None, (limit_of(rig, i) for i in range(1, m + 1))))
    into, out = (_of_first_order(filters, which) for which in ("input_hz", "output_hz"))
    missing = {} if filters else {"linestyle": "--"}
    left, middle, right = 1.55, 3.5, 5.45
    bottom, low, high, top = 0.62, 1.62, 2.62, 3.72
    motors = f"{m} motor{'s' * (m > 1)}"
    diagram = Diagram(7, 4.5)
    for name, x, y, text, style in [
        ("computer", middle, bottom, f"Computer\nevery {1000 * dt:g} ms", {"face": COMPUTER}),
        ("D/A", left, low, "D/A\n12 bit", {}),
        ("input", left, high, f"Input filters\n{into}", missing),
        ("power", left, top, f"Power amplifiers\n{limits if m <= 2 else ''}".strip(), {}),
        ("plant", right, top, f"Inverted pendulum\n{n} links, {motors}", {"face": PLANT}),
        ("output", right, high, f"Output amplifiers, filters\n{out}", missing),
        ("A/D", right, low, "A/D, multiplexer\n12 bit", {}),
    ]:
        diagram.box(name, x, y, text, width=2.2, height=0.66, **style)
    diagram.wire("computer", (left, bottom), "D/A")
    for one, other in pairwise(["D/A", "input", "power", "plant", "output", "A/D"]):
        diagram.wire(one, other)
    diagram.wire("A/D", (right, bottom), "computer")
    inputs = "$u_1$" if m == 1 else "$u_1, u_2$" if m == 2 else rf"$u_1 \ldots u_{m}$"
    angles = [angle_label(i) for i in range(1, n + 1)]
    shown = angles if n <= 3 else [angles[0], "…", angles[-1]]
    measured = "\n".join(["measured:", *shown, r"$\dot\theta_1$"])
    note(diagram.ax, middle, top + 0.19, inputs)
    note(diagram.ax, middle, (low + high) / 2 + 0.2, measured, linespacing=1.35)
    below = (bottom + low) / 2 - 0.3
    note(diagram.ax, left - 0.12, below, f"{m} output{'s' * (m > 1)}", ha="right")
    note(diagram.ax, right + 0.12, below, f"{n + 1} inputs", ha="left")
    claim = "Without filters nothing stands between converters and pendulum but amplifiers."
    if filters:
        claim = (
            "The design neglects the filters, yet at 2 Hz an input and an output filter "
            f"together cost {filter_lag(filters, 2.0):.1f} degrees of phase."
        )
    return describe(
        diagram.fig,
        f"Fig 4. One loop through computer and {rig.name} pendulum. {claim}",
        f"Block diagram of a closed loop: computer every {1000 * dt:g} ms, 12 bit D/A converter "
        f"({m}), input filters ({into}), power amplifiers, inverted pendulum with {n} links, output "
        f"amplifiers and filters ({out}), 12 bit A/D converter with multiplexer ({n + 1} inputs), "
        f"and back to the computer.",
    )


@styled()
def observer_blocks():
    """Fig 5: state feedback through a reduced-order observer, equations (4) and (30).

    The loop is broken at X, between what the controller asks for, u_r = -F xhat, and the plant's
    input u; the observer is fed with u_r, as the proof in Appendix B has it.
    """
    diagram = Diagram(7, 3.9)
    top, mid, low = 3.1, 1.62, 0.55
    left, middle, y = 0.75, 3.62, 6.35
    grey = dict(color=COLORS["grey"])
    diagram.box("plant", 4.75, top, r"$C(zI-A)^{-1}B$", width=1.6, height=0.6, face=PLANT)
    diagram.box("F", left, 2.42, "$F$")
    diagram.box("L2", 1.5, mid, "$L_2$")
    diagram.box("E", 2.68, mid, r"$(zI-E)^{-1}$", width=1.12)
    diagram.box("H", middle, 2.32, "$H$", height=0.46, linestyle="--", face="white")
    diagram.box("K", 4.75, mid, "$K$")
    diagram.box("L1", 4.75, low, "$L_1$")
    diagram.sum("-F", left, top, {(-0.2, -0.27): "$-$"})
    diagram.sum("v", middle, mid, {(0.22, 0.2): "+", (-0.2, 0.22): "+"})
    diagram.sum("x", left, mid, {(0.22, 0.2): "+", (-0.22, -0.24): "+"})
    for stops in [
        ("F", "-F"), ("-F", "plant"), ("plant", (6.85, top)),
        ((y, top), (y, low), "L1"), ((y, mid), "K"), ("K", "v"), ("v", "E"), ("E", "L2"),
        ("L2", "x"), ("L1", (left, low), "x"), ("x", "F"),
    ]:  # fmt: skip
        diagram.wire(*stops)
    diagram.wire((2.2, top), (2.2, 2.72), (middle, 2.72), "H", **grey, linestyle="--")
    diagram.wire("H", "v", **grey, linestyle="--")
    diagram.branches((2.2, top), (y, top), (y, mid))
    diagram.cut(2.92, top, "X")
    diagram.names(
        (1.5, top + 0.19, "$u_r$"), (3.5, top + 0.19, "$u$"), (6.0, top + 0.19, "$y$"),
        (2.0, mid + 0.19, "$v$"), (left - 0.2, 1.97, r"$\hat x$"), fontsize=13,
    )  # fmt: skip
    note(diagram.ax, 4.1, 2.32, "vanishes when\n$H = TB = 0$", ha="left", fontsize=10, **grey)
    note(diagram.ax, 4.75, top + 0.47, "plant $G(z)$", fontsize=10)
    return describe(
        diagram.fig,
        "Fig 5. State feedback through a reduced-order observer, broken at X. The dashed path "
        "through H is the only way the controller's own output reaches its observer: with H = 0 "
        "the loop seen at X is that of full state feedback, equation (11).",
        "Block diagram. The plant C (zI - A)^-1 B turns u into y. The output y goes through K into "
        "a sum, then through (zI - E)^-1 to the observer state v and through L2; y also goes "
        "through L1; both add up to the estimate of x. F and a minus sign give u_r, which passes "
        "the mark X to become u. A dashed path leads from u_r through H into the sum after K.",
    )


@styled()
def triple_loops():
    """Fig 9: the triple's two feedback loops, u = -P y with P = [p1; p2] and y = g1 u1 + g2 u2.

    Broken at X alone the return difference is (33), at XX alone (34), at both (35).
    """
    diagram = Diagram(7, 3.9)
    block, total, y = 4.1, 5.5, 6.3
    row, back, column = {1: 3.2, 2: 2.4}, {1: 0.55, 2: 1.4}, {1: 0.5, 2: 1.15}
    diagram.sum("y", total, row[2], {(-0.25, 0.18): "+", (0.2, 0.25): "+"})
    for i in (1, 2):
        diagram.box(f"g{i}", block, row[i], f"$g_{i}(z)$", width=1.0, face=PLANT)
        diagram.box(f"p{i}", block, back[i], f"$p_{i}(z)$", width=1.0)
        diagram.sum(f"u{i}", column[i], row[i], {(-0.2, -0.27): "$-$"})
        diagram.wire(f"u{i}", f"g{i}")
        diagram.wire(f"p{i}", (column[i], back[i]), f"u{i}")
        diagram.cut(2.2, row[i], "X" * i)
        diagram.names(
            (1.65, row[i] + 0.2, f"$u_{{{i}r}}$"), (2.85, row[i] + 0.2, f"$u_{i}$"), fontsize=13
        )
        note(diagram.ax, 2.3, back[i] + 0.2, f"loop of motor {i}", fontsize=10)
    for stops in [
        ("g1", (total, row[1]), "y"), ("g2", "y"), ("y", (6.85, row[2])),
        ((y, row[2]), (y, back[1]), "p1"), ((y, back[2]), "p2"),
    ]:  # fmt: skip
        diagram.wire(*stops)
    diagram.branches((y, row[2]), (y, back[2]))
    note(diagram.ax, 6.6, row[2] + 0.2, "$y$", fontsize=13)
    return describe(
        diagram.fig,
        "Fig 9. The triple's two loops share the plant, so each is judged with the other closed: "
        "broken at X alone it has the return difference (33), at XX alone (34), and at both the "
        "matrix of (35).",
        "Block diagram with two inputs. u1 passes g1(z) and u2 passes g2(z); their sum is y. y goes "
        "back through p1(z) with a minus sign to u1r, and through p2(z) with a minus sign to u2r. "
        "The mark X lies between u1r and u1, the mark XX between u2r and u2.",
    )
