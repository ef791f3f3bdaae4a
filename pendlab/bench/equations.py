"""The equations of motion as scalar code, generated from the derivation for the simulator."""

from itertools import combinations

import sympy as sp

from ..lagrange import derive


def acceleration_source(n_links, n_motors):
    """(source of the equations of motion as scalar Python code, number of its constants).

    Two functions: ``constants(p, c)`` combines the parameters p (order of `symbols`) into the few
    numbers c that the equations need, once per run; ``accelerate(q, v, Q, c, a)`` solves
    M(q) a + bias(q, v) = Q for the angular accelerations a under the torques Q on the links.
    Sines and cosines of differences come from those of the angles, common factors are computed
    once, and M = L D L' is factored in place.
    """
    motion = derive(n_links, n_motors)
    n, q, v = n_links, list(motion.q), list(motion.v)
    table = {}  # combined coefficient -> symbol c[k]
    rates = {v[i]: sp.Symbol(f"v{i}") for i in range(n)}
    squares = {v[i] ** 2: sp.Symbol(f"vv{i}") for i in range(n)}
    pairs = list(combinations(range(n), 2))
    sines = {sp.sin(q[i]): sp.Symbol(f"s{i}") for i in range(n)}
    sines |= {sp.sin(q[i] - q[j]): sp.Symbol(f"s{i}{j}") for i, j in pairs}
    sines |= {sp.cos(q[i] - q[j]): sp.Symbol(f"c{i}{j}") for i, j in pairs}

    def combined(expression):
        """The expression with each product of parameters summed into one constant."""
        groups = {}
        for term in sp.Add.make_args(sp.expand(expression)):
            factor, moving = term.as_independent(*q, *v)
            groups[moving] = groups.get(moving, 0) + factor
        total = 0
        for moving, factor in groups.items():
            sign = -1 if factor.could_extract_minus_sign() else 1
            symbol = table.setdefault(sign * factor, sp.Symbol(f"k{len(table)}"))
            total += sign * symbol * moving
        return total.subs({**squares, **sines, **rates})

    lower = [(i, j) for i in range(n) for j in range(i + 1)]
    entries = [combined(motion.mass_matrix[i, j]) for i, j in lower]
    entries += [combined(motion.bias[i]) for i in range(n)]
    shared, entries = sp.cse(entries, symbols=sp.numbered_symbols("x"), order="none")

    body = [f"q{i} = q[{i}]" for i in range(n)] + [f"v{i} = v[{i}]" for i in range(n)]
    body += [f"k{k} = c[{k}]" for k in range(len(table))]
    body += [f"vv{i} = v{i} * v{i}" for i in range(n)]
    body += [f"s{i} = sin(q{i})" for i in range(n)] + [f"c{i} = cos(q{i})" for i in range(n)]
    for i, j in pairs:
        body.append(f"s{i}{j} = s{i} * c{j} - c{i} * s{j}")
        body.append(f"c{i}{j} = c{i} * c{j} + s{i} * s{j}")
    body += [f"{name} = {sp.pycode(value)}" for name, value in shared]
    body += [f"m{i}{j} = {sp.pycode(e)}" for (i, j), e in zip(lower, entries)]
    body += [f"r{i} = Q[{i}] - ({sp.pycode(e)})" for i, e in enumerate(entries[len(lower) :])]
    body += _solve(n)
    combine = [f"c[{k}] = {sp.pycode(factor)}" for k, factor in enumerate(table)]
    unpack = ", ".join(str(symbol) for symbol in motion.symbols)
    lines = ["def constants(p, c):", f"    ({unpack}) = p", *(f"    {line}" for line in combine)]
    lines += ["", "", "def accelerate(q, v, Q, c, a):", *(f"    {line}" for line in body), ""]
    return "\n".join(lines), len(table)


def _solve(n):
    """Statements that solve m a = r for symmetric m by m = L D L', without square roots."""
    lines = []
    for j in range(n):
        for i in range(j + 1, n):
            lines.append(f"l{i}{j} = m{i}{j} / m{j}{j}")
            lines += [f"m{i}{k} -= l{i}{j} * m{k}{j}" for k in range(j + 1, i + 1)]
            lines.append(f"r{i} -= l{i}{j} * r{j}")
    for i in reversed(range(n)):
        known = "".join(f" - l{k}{i} * a{k}" for k in range(i + 1, n))
        lines.append(f"a{i} = r{i} / m{i}{i}{known}")
    return lines + [f"a[{i}] = a{i}" for i in range(n)]
