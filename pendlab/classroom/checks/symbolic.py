"""How formulas are judged: SymPy matrices, and sums of products in which order matters.

Equal means equal in value, in whatever form it is written. Symbols count by their names, so that
it does not matter with which assumptions they were made anew.
"""

from itertools import product

import numpy as np


def formula_hint(name, answer, truth, mistakes, new=None):
    """What to say about a SymPy matrix that is not the truth for all values of symbols, or None.

    The opposite sign and the transpose are always among the (matrix, hint) pairs `mistakes`; `new`
    is the name of a symbol of the truth that may go by any name in the answer.
    """
    mistakes = list(mistakes)
    usual = [
        (-truth, f"{name} has the opposite sign; on which side of the equation does it stand?"),
        (truth.T, f"{name} is transposed."),
    ]
    known, (rows, columns) = [truth, *(matrix for matrix, _ in mistakes)], truth.shape
    shapes = {(columns, rows), *(matrix.shape for matrix in known)}
    if not hasattr(answer, "applyfunc") or answer.shape not in shapes:
        return f"{name} should be a {rows} x {columns} SymPy matrix of formulas."
    symbols = {s.name: s for matrix in known for s in matrix.free_symbols}
    unknown = [s for s in answer.free_symbols if s.name not in symbols]
    if new and len(unknown) == 1:
        symbols[unknown[0].name] = symbols[new]
    answer = answer.xreplace({s: symbols.get(s.name, s) for s in answer.free_symbols})
    if same(answer, truth):
        return None
    if truth.free_symbols and not answer.free_symbols:
        return f"{name} holds numbers only; leave the symbols in it."
    for wrong, hint in [*mistakes, *usual]:
        if same(answer, wrong):
            return hint
    if answer.shape != truth.shape:
        return f"{name} should have the shape {truth.shape}, found {answer.shape}."
    places = product(range(rows), range(columns))
    wrong = next(place for place in places if not _zero(answer[place] - truth[place]))
    return f"{name}: look again at entry {wrong}, counted from 0."


def same(a, b):
    """Whether two SymPy matrices agree for all values of their symbols."""
    return a.shape == b.shape and all(_zero(entry) for entry in a - b)


def _zero(entry):
    return entry.expand() == 0 or bool(entry.equals(0))


def is_product_sum(expression):
    """Whether it is an expression of non-commuting symbols (or a number)."""
    return hasattr(expression, "args_cnc") and hasattr(expression, "free_symbols")


def evaluate(expression, matrices, size):
    """Value of a sum of products of non-commuting symbols, each a matrix by its name.

    A number stands for that multiple of the identity of the given size, a commuting symbol for its
    number. KeyError, ValueError, TypeError or AttributeError where that is not possible.
    """
    total = np.zeros((size, size), dtype=complex)
    for term in expression.expand().as_ordered_terms():
        numbers, factors = term.args_cnc()
        value = np.eye(size, dtype=complex)
        for factor in factors:
            base, power = factor.as_base_exp()
            matrix = matrices[base.name]
            value = value @ (matrix if power == 1 else np.linalg.matrix_power(matrix, int(power)))
        for number in numbers:
            value = value * complex(number.subs({s: matrices[s.name] for s in number.free_symbols}))
        total = total + value
    return total
