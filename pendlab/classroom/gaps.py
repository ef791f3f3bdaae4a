"""Gaps: what stands in place of a solution, and how the cells that need one wait for it.

A gap is ``name = ...``, or a function that returns ``...``. `gap` writes it into a student's cell;
`skip_unanswered` lets Run All reach the end of a notebook with gaps. Standard library only.
"""

import ast
import dis
import os
import re
from types import CodeType

from . import exercises as paper

INLINE_CODE, IDENTIFIER = re.compile(r"`([^`\n]+)`"), re.compile(r"[A-Za-z_]\w*")
CELL = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


def unanswered(value):
    """Whether a value is a gap: ``...``, a function that returns it, or a list that holds it.

    >>> unanswered(...), unanswered(0.0), unanswered((1, ...))
    (True, False, True)
    """
    return any(map(is_gap, value)) if isinstance(value, (list, tuple)) else is_gap(value)


def is_gap(value):
    if value is ...:
        return True
    code = getattr(value, "__code__", None)
    if not isinstance(code, CodeType) or ... not in code.co_consts:
        return False
    steps = list(dis.get_instructions(code))
    return any(
        step.argval is ... and (step.opname == "RETURN_CONST" or after.opname == "RETURN_VALUE")
        for step, after in zip(steps, [*steps[1:], *steps[-1:]])
    )


# ---- Writing gaps


def asked(notebook):
    """Names that given cells read, or that a task puts into its inline code."""
    found = set()
    for cell in notebook["cells"]:
        part = paper.PART.fullmatch(cell["id"])
        if part and part["role"] == "task":
            found.update(*map(IDENTIFIER.findall, INLINE_CODE.findall(cell["source"])))
        elif cell["cell_type"] == "code" and not paper.has_solution(cell):
            found |= names(cell["source"])[0]
    return found


def names(source):
    """Names that a code cell reads before it binds them, and those that it binds."""
    try:
        code = compile(source, "<cell>", "exec", CELL)
    except SyntaxError:  # a magic, or a cell that is broken on purpose
        return set(), set()
    return _reads(code), set(_stores(code))


def gap(cell, exercise, asked):
    """The source of a solution cell with a gap for each of its names that is `asked`.

    Raises ValueError for a marker without its partner, and SyntaxError for a solution that is none.
    """
    lines = cell["source"].splitlines()
    what = f"Exercise {exercise}: your" if exercise else "Your"
    for first, last in reversed(paper.region(cell["source"])):
        indent = lines[first][: len(lines[first]) - len(lines[first].lstrip())]
        if cell["cell_type"] != "code":
            stub = [f"*{what} answer here.*"]
        elif indent:
            stub = [f"# {what} solution here", "return ..."]
        else:
            solution = ast.parse("\n".join(lines[first + 1 : last])).body
            stub = [f"# {what} solution here", *_stubs(solution, asked)]
        lines[first : last + 1] = [indent + line for line in stub]
    return "\n".join(lines)


def _stubs(solution, asked):
    """``name = ...`` for each asked name that statements bind, in their order."""
    made = {}
    for statement in solution:
        if isinstance(statement, ast.FunctionDef) and statement.name in asked:
            arguments = ast.unparse(statement.args)
            made[statement.name] = f"def {statement.name}({arguments}):\n    return ..."
        elif not isinstance(statement, (ast.Import, ast.ImportFrom)):
            for name in _stores(_compiled(statement)):
                if name in asked:
                    made.setdefault(name, f"{name} = ...")
    return "\n".join(made.values() or ["..."]).splitlines()


# ---- Waiting for them


def skip_unanswered():
    """Let cells that need an unanswered exercise say so in one line, where they would fail.

    A statement that reads a gap is left out, and what it would have bound is a gap too; all the
    others run. ``pl.check`` is always asked. Outside Jupyter, and where nbgrader marks, nothing
    changes.
    """
    try:
        shell = get_ipython()
    except NameError:
        return
    others = [t for t in shell.ast_transformers if not isinstance(t, _Waiting)]
    marking = "NBGRADER_EXECUTION" in os.environ
    shell.ast_transformers = others if marking else [*others, _Waiting(shell.user_ns)]


class _Waiting:
    """Rewrites a cell before it runs (an IPython AST transformer)."""

    def __init__(self, names):
        self.names = names
        self.origins = {}  # of a gap that a left-out statement leaves: the gaps that it needs

    def visit(self, tree):
        gaps = {n for n, value in self.names.items() if n[:1] != "_" and is_gap(value)}
        kept, missing = [], set()
        for statement in tree.body:
            code = _compiled(statement)
            needed = self._needed(code, gaps, set())
            if needed and not _asks(statement):
                origins = set().union(*(self.origins.get(name, {name}) for name in needed))
                bound = {name for name in _stores(code) if name not in self.names or name in gaps}
                self.origins.update(dict.fromkeys(bound - origins, origins))
                kept += [_placed(f"{name} = ...", statement) for name in sorted(bound)]
                gaps, missing = gaps | bound, missing | origins
            else:
                kept.append(statement)
                gaps = gaps - set(_stores(code)) | _opened(statement)
        if missing:
            names = " and ".join(f"`{name}`" for name in sorted(missing))
            kept.insert(0, _placed(f"print({f'Not run yet: this needs your {names}.'!r})", tree))
        tree.body = kept
        return tree

    def _needed(self, code, gaps, seen):
        """Gaps that code reads, directly or through functions of the notebook."""
        reads = _reads(code)
        for name in reads - gaps - seen:
            inner = getattr(self.names.get(name), "__code__", None)
            if inner and getattr(self.names[name], "__globals__", None) is self.names:
                seen.add(name)
                reads |= self._needed(inner, gaps, seen)
        return reads & gaps


def _compiled(statement):
    return compile(ast.Module([statement], []), "<cell>", "exec", CELL)


def _placed(source, beside):
    return ast.fix_missing_locations(ast.copy_location(ast.parse(source).body[0], beside))


def _asks(statement):
    """Whether a statement is a call of ``pl.check``."""
    called = getattr(getattr(statement, "value", None), "func", None)
    return ast.unparse(called).split(".")[-1] == "check" if called else False


def _opened(statement):
    """The names that ``name = ...`` or a function returning ``...`` leaves open."""
    if isinstance(statement, ast.FunctionDef):
        ends = (part.value for part in ast.walk(statement) if isinstance(part, ast.Return))
        return {statement.name} if any(map(_dots, ends)) else set()
    if isinstance(statement, ast.Assign) and _dots(statement.value):
        return {target.id for target in statement.targets if isinstance(target, ast.Name)}
    return set()


def _dots(node):
    return isinstance(node, ast.Constant) and node.value is ...


def _stores(code):
    """Names that a cell's code binds, in order."""
    steps = dis.get_instructions(code)
    return list(dict.fromkeys(s.argval for s in steps if s.opname == "STORE_NAME"))


def _reads(code):
    """Global names that code reads before it binds them itself."""
    stored, found = set(), set()
    for step in dis.get_instructions(code):
        if step.opname == "STORE_NAME":
            stored.add(step.argval)
        elif step.opname in ("LOAD_NAME", "LOAD_GLOBAL") and step.argval not in stored:
            found.add(step.argval)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            found |= _reads(inner) - stored
    return found
