"""Block diagrams: the apparatus (Fig 4), the observer-based controller (Fig 5), two loops (Fig 9).

Axes are in inches, so that a position below is a position on the page.
"""

import math

from matplotlib.patches import Circle, FancyBboxPatch

from .._arguments import number
from .moving import check_rig
from .style import COLORS, angle_name, describe, look, new_figure, styled

INK = "#222222"
CUT = COLORS["vermillion"]


def canvas(width, height):
    """A figure and axes without frame whose units are inches."""
    fig = new_figure(width, height, layout=None)
    ax = fig.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, width), ylim=(0, height))
    ax.set_axis_off()
    return fig, ax


def _box(ax, x, y, text, width=1.4, height=0.6, face=COLORS["pale"], **line):
    """A block centred at (x, y)."""
    ax.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - height / 2),
            width,
            height,
            boxstyle="round,pad=0,rounding_size=0.06",
            facecolor=face,
            **{"edgecolor": INK, "linewidth": 1.4, "zorder": 3, **line},
        )
    )
    ax.text(x, y, text, ha="center", va="center", zorder=4)


def _path(ax, *points, head=True, **line):
    """A signal along straight pieces, with an arrow head at its end."""
    line = {"color": INK, "linewidth": 1.5, **line}
    xs, ys = zip(*points)
    ax.plot(xs, ys, solid_joinstyle="miter", zorder=2, **line)
    if head:
        style = dict(arrowstyle="-|>", color=line["color"], shrinkA=0, shrinkB=0, mutation_scale=15)
        # An arrow needs some length to know its direction; the line below it is already drawn.
        (x0, y0), (x1, y1) = points[-2:]
        part = min(1.0, 0.1 / math.hypot(x1 - x0, y1 - y0))
        start = (x1 - part * (x1 - x0), y1 - part * (y1 - y0))
        ax.annotate("", points[-1], start, arrowprops=style, zorder=2)


def _note(ax, x, y, text, **more):
    ax.text(x, y, text, **{"ha": "center", "va": "center", "zorder": 5, **more})


def chain(ax, left, right, y, signal, blocks):
    """Blocks in a row at height y: `signal` enters the first, each names the signal behind it."""
    gap = 0.75
    pitch = (right - left - gap) / len(blocks)
    _path(ax, (left, y), (left + gap, y))
    _note(ax, left + gap / 2, y + 0.14, signal)
    for k, (text, after) in enumerate(blocks):
        end = left + gap + (k + 1) * pitch
        _box(ax, end - (pitch + gap) / 2, y, text, width=pitch - gap, height=0.52)
        _path(ax, (end - gap, y), (end, y))
        _note(ax, end - gap / 2, y + 0.14, after)


def _sum(ax, x, y, signs):
    """A summing point; signs maps an offset (dx, dy) to its sign."""
    ax.add_patch(Circle((x, y), 0.12, facecolor="white", edgecolor=INK, linewidth=1.4, zorder=3))
    for (dx, dy), sign in signs.items():
        _note(ax, x + dx, y + dy, sign, fontsize=13)


def _branch(ax, x, y):
    ax.plot([x], [y], marker="o", markersize=5, color=INK, zorder=3)


def _cut(ax, x, y, name, above):
    """The mark where a loop is broken, on a white gap of the line."""
    size = 0.085
    ax.plot([x - size, x + size], [y, y], color="white", linewidth=6, zorder=2.5)
    for start in range(len(name)):
        at = x + 0.19 * (start - (len(name) - 1) / 2)
        for sign in (-1, 1):
            ax.plot(
                [at - size, at + size],
                [y - sign * size, y + sign * size],
                color=CUT,
                linewidth=2.6,
                zorder=4,
            )
    _note(ax, x, y + 0.27, above, color=CUT, fontweight="bold")


def _hertz(values):
    """Distinct cut-offs in words: 10.26 Hz, or 10 and 12 Hz."""
    distinct = sorted(set(values))
    return " and ".join(f"{value:g}" for value in distinct) + " Hz"


def _filter_lag(filters, hz):
    """Phase lag in degrees of the slowest input and output filter together at a frequency."""
    slowest = min(filters.input_hz), min(filters.output_hz)
    return math.degrees(sum(math.atan(hz / cut_off) for cut_off in slowest))


@styled()
def apparatus_blocks(rig, dt=0.01):
    """Fig 4: the signals' way from the computer through filters, amplifiers and pendulum and back.

    Cut-off frequencies and voltage limits are those of the rig; `dt` is the sampling time, s.
    """
    check_rig(rig)
    number("dt", dt, above=0)
    n, m, filters = rig.n_links, rig.n_motors, rig.filters
    fig, ax = canvas(7, 4.5)
    left, right, middle = 1.55, 5.45, 3.5
    bottom, low, high, top = 0.62, 1.62, 2.62, 3.72
    limits = [f"$|u_{i}|$ ≤ {u:g} V" for i, u in enumerate(rig.u_max, 1) if math.isfinite(u)]
    limit = ("\n" + ",  ".join(limits)) if limits and m <= 2 else ""
    into = f"first order, {_hertz(filters.input_hz)}" if filters else "none in this rig"
    out = f"first order, {_hertz(filters.output_hz)}" if filters else "none in this rig"
    missing = {} if filters else {"linestyle": "--"}
    tall = dict(width=2.2, height=0.66)
    _box(ax, middle, bottom, f"Computer\nevery {1000 * dt:g} ms", **tall, face="#DCEBF7")
    _box(ax, left, low, "D/A\n12 bit", **tall)
    _box(ax, left, high, f"Input filters\n{into}", **tall, **missing)
    _box(ax, left, top, "Power amplifiers" + limit, **tall)
    _box(
        ax,
        right,
        top,
        f"Inverted pendulum\n{n} links, {m} motor{'s' * (m > 1)}",
        **tall,
        face="#FBE9DC",
    )
    _box(ax, right, high, f"Output amplifiers, filters\n{out}", **tall, **missing)
    _box(ax, right, low, "A/D, multiplexer\n12 bit", **tall)
    half = 0.33
    _path(ax, (middle - 1.1, bottom), (left, bottom), (left, low - half))
    _path(ax, (left, low + half), (left, high - half))
    _path(ax, (left, high + half), (left, top - half))
    _path(ax, (left + 1.1, top), (right - 1.1, top))
    _path(ax, (right, top - half), (right, high + half))
    _path(ax, (right, high - half), (right, low + half))
    _path(ax, (right, low - half), (right, bottom), (middle + 1.1, bottom))
    inputs = "$u_1$" if m == 1 else "$u_1, u_2$" if m == 2 else rf"$u_1 \ldots u_{m}$"
    _note(ax, middle, top + 0.19, inputs)
    _note(ax, left - 0.12, (bottom + low) / 2 - 0.3, f"{m} output{'s' * (m > 1)}", ha="right")
    angles = [look(angle_name(i))["label"] for i in range(1, n + 1)]
    shown = angles if n <= 3 else [angles[0], "…", angles[-1]]
    _note(
        ax,
        middle,
        (low + high) / 2 + 0.2,
        "measured:\n" + "\n".join([*shown, r"$\dot\theta_1$"]),
        linespacing=1.35,
    )
    _note(ax, right + 0.12, (bottom + low) / 2 - 0.3, f"{n + 1} inputs", ha="left")
    if filters:
        hz = 2.0
        claim = (
            f"The design neglects the filters, yet at {hz:g} Hz an input and an output filter "
            f"together cost {_filter_lag(filters, hz):.1f} degrees of phase."
        )
    else:
        claim = "Without filters nothing stands between converters and pendulum but amplifiers."
    return describe(
        fig,
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
    fig, ax = canvas(7, 3.9)
    top, mid, low = 3.1, 1.62, 0.55
    sum_x, obs_sum, y_x = 0.75, 3.62, 6.35
    _box(ax, 4.75, top, r"$C(zI-A)^{-1}B$", width=1.6, face="#FBE9DC")
    _box(ax, sum_x, 2.42, "$F$", width=0.7, height=0.5)
    _box(ax, 1.5, mid, "$L_2$", width=0.7, height=0.5)
    _box(ax, 2.68, mid, r"$(zI-E)^{-1}$", width=1.12, height=0.5)
    _box(ax, obs_sum, 2.32, "$H$", width=0.7, height=0.46, linestyle="--", face="white")
    _box(ax, 4.75, mid, "$K$", width=0.7, height=0.5)
    _box(ax, 4.75, low, "$L_1$", width=0.7, height=0.5)
    _path(ax, (sum_x, 2.67), (sum_x, top - 0.12))
    _sum(ax, sum_x, top, {(-0.2, -0.27): "$-$"})
    _path(ax, (sum_x + 0.12, top), (3.95, top))
    _branch(ax, 2.2, top)
    hint = dict(color=COLORS["grey"], linestyle="--")
    _path(ax, (2.2, top), (2.2, 2.72), (obs_sum, 2.72), (obs_sum, 2.55), **hint)
    _path(ax, (obs_sum, 2.09), (obs_sum, mid + 0.12), **hint)
    _cut(ax, 2.92, top, "X", "X")
    _path(ax, (5.55, top), (6.85, top))
    _branch(ax, y_x, top)
    _path(ax, (y_x, top), (y_x, low), (5.1, low))
    _branch(ax, y_x, mid)
    _path(ax, (y_x, mid), (5.1, mid))
    _path(ax, (4.4, mid), (obs_sum + 0.12, mid))
    _sum(ax, obs_sum, mid, {(0.22, 0.2): "+", (-0.2, 0.22): "+"})
    _path(ax, (obs_sum - 0.12, mid), (3.24, mid))
    _path(ax, (2.12, mid), (1.85, mid))
    _path(ax, (1.15, mid), (sum_x + 0.12, mid))
    _path(ax, (4.4, low), (sum_x, low), (sum_x, mid - 0.12))
    _sum(ax, sum_x, mid, {(0.22, 0.2): "+", (-0.22, -0.24): "+"})
    _path(ax, (sum_x, mid + 0.12), (sum_x, 2.17))
    for x, y, text in [
        (1.5, top + 0.19, "$u_r$"),
        (3.5, top + 0.19, "$u$"),
        (6.0, top + 0.19, "$y$"),
        (2.0, mid + 0.19, "$v$"),
        (sum_x - 0.2, 1.97, r"$\hat x$"),
    ]:
        _note(ax, x, y, text, fontsize=13)
    _note(
        ax, 4.1, 2.32, "vanishes when\n$H = TB = 0$", ha="left", fontsize=10, color=COLORS["grey"]
    )
    _note(ax, 4.75, top + 0.47, "plant $G(z)$", fontsize=10)
    return describe(
        fig,
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
    fig, ax = canvas(7, 3.9)
    row1, row2, inner, outer = 3.2, 2.4, 1.4, 0.55
    col1, col2, block, total, y_x = 0.5, 1.15, 4.1, 5.5, 6.3
    for i, (row, cut, col, name) in enumerate([(row1, 2.2, col1, "X"), (row2, 2.2, col2, "XX")], 1):
        _sum(ax, col, row, {(-0.2, -0.27): "$-$"})
        _path(ax, (col + 0.12, row), (block - 0.5, row))
        _cut(ax, cut, row, name, name)
        _note(ax, 1.65, row + 0.2, f"$u_{{{i}r}}$", fontsize=13)
        _note(ax, 2.85, row + 0.2, f"$u_{i}$", fontsize=13)
        _box(ax, block, row, f"$g_{i}(z)$", width=1.0, height=0.5, face="#FBE9DC")
    _path(ax, (block + 0.5, row1), (total, row1), (total, row2 + 0.12))
    _path(ax, (block + 0.5, row2), (total - 0.12, row2))
    _sum(ax, total, row2, {(-0.25, 0.18): "+", (0.2, 0.25): "+"})
    _path(ax, (total + 0.12, row2), (6.85, row2))
    _note(ax, 6.6, row2 + 0.2, "$y$", fontsize=13)
    _branch(ax, y_x, row2)
    _branch(ax, y_x, inner)
    _box(ax, block, inner, "$p_2(z)$", width=1.0, height=0.5)
    _box(ax, block, outer, "$p_1(z)$", width=1.0, height=0.5)
    _path(ax, (y_x, row2), (y_x, outer), (block + 0.5, outer))
    _path(ax, (y_x, inner), (block + 0.5, inner))
    _path(ax, (block - 0.5, inner), (col2, inner), (col2, row2 - 0.12))
    _path(ax, (block - 0.5, outer), (col1, outer), (col1, row1 - 0.12))
    _note(ax, 2.3, inner + 0.2, "loop of motor 2", fontsize=10)
    _note(ax, 2.3, outer + 0.2, "loop of motor 1", fontsize=10)
    return describe(
        fig,
        "Fig 9. The triple's two loops share the plant, so each is judged with the other closed: "
        "broken at X alone it has the return difference (33), at XX alone (34), and at both the "
        "matrix of (35).",
        "Block diagram with two inputs. u1 passes g1(z) and u2 passes g2(z); their sum is y. y goes "
        "back through p1(z) with a minus sign to u1r, and through p2(z) with a minus sign to u2r. "
        "The mark X lies between u1r and u1, the mark XX between u2r and u2.",
    )
