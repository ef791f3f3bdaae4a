"""Python of the simulator's kernel as JavaScript: the same statements, one by one.

The kernel keeps to what numba compiles at once (numbers, arrays indexed one by one, loops, calls of
its own functions), so each node of its syntax tree has one counterpart in JavaScript. Numbers are
double precision in both, so equal statements give equal bits as far as sin, cos and exp do.
"""

import ast

OPERATORS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Mod: "%", ast.Pow: "**",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "===", ast.NotEq: "!==",
    ast.And: "&&", ast.Or: "||", ast.Not: "!", ast.USub: "-",
}  # fmt: skip
MATH = ("abs", "cos", "exp", "floor", "max", "min", "sin", "sqrt")


def to_javascript(source, skip=()):
    """JavaScript of a module of the kernel's kind.

    Parameters
    ----------
    source : text of the module: constants and functions
    skip : names of functions to leave out

    Raises
    ------
    ValueError : a statement or expression that has no counterpart here, with its line

    >>> print(to_javascript("def twice(x):\\n    return 2.0 * x"))
    function twice(x) {
      return (2.0 * x);
    }
    """
    return "\n".join(
        line
        for node in ast.parse(source).body
        if getattr(node, "name", None) not in skip
        for line in _statement(node, "")
    )


def _statement(node, indent):
    """Lines of one statement."""
    inner = indent + "  "
    if isinstance(node, (ast.ImportFrom, ast.Pass)) or _is_text(node):
        return []
    if isinstance(node, ast.ClassDef):
        return []  # a named tuple: an object with these fields, made by who calls
    if isinstance(node, ast.FunctionDef):
        head = f"{indent}function {node.name}({', '.join(a.arg for a in node.args.args)}) {{"
        declared = sorted(_bound(node) - {a.arg for a in node.args.args})
        names = [f"{inner}let {', '.join(declared)};"] if declared else []
        return [head, *names, *_block(node.body, inner), f"{indent}}}"]
    if isinstance(node, ast.Assign):
        target = _target(node.targets[0])
        declare = "const " if not indent else ""
        return [f"{indent}{declare}{target} = {_value(node.value)};"]
    if isinstance(node, ast.AugAssign):
        return [f"{indent}{_value(node.target)} {OPERATORS[type(node.op)]}= {_value(node.value)};"]
    if isinstance(node, ast.For):
        name, limits = node.target.id, [_value(a) for a in node.iter.args]
        first, last = limits if len(limits) == 2 else ("0", limits[0])
        head = f"{indent}for ({name} = {first}; {name} < {last}; {name}++) {{"
        return [head, *_block(node.body, inner), f"{indent}}}"]
    if isinstance(node, ast.If):
        lines = [f"{indent}if ({_value(node.test)}) {{", *_block(node.body, inner)]
        if node.orelse:
            lines += [f"{indent}}} else {{", *_block(node.orelse, inner)]
        return [*lines, f"{indent}}}"]
    if isinstance(node, ast.Return):
        return [f"{indent}return {_value(node.value)};"]
    if isinstance(node, ast.Expr):
        return [f"{indent}{_value(node.value)};"]
    raise _no_counterpart(node)


def _block(statements, indent):
    return [line for statement in statements for line in _statement(statement, indent)]


def _value(node):
    """One expression."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return repr(node.value)
    if isinstance(node, ast.Attribute):
        return f"{_value(node.value)}.{node.attr}"
    if isinstance(node, ast.Subscript):
        return _item(node)
    if isinstance(node, ast.BinOp):
        return f"({_value(node.left)} {OPERATORS[type(node.op)]} {_value(node.right)})"
    if isinstance(node, ast.UnaryOp):
        return f"{OPERATORS[type(node.op)]}({_value(node.operand)})"
    if isinstance(node, ast.BoolOp):
        return f"({f' {OPERATORS[type(node.op)]} '.join(map(_value, node.values))})"
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        return f"({_value(node.left)} {OPERATORS[type(node.ops[0])]} {_value(node.comparators[0])})"
    if isinstance(node, ast.IfExp):
        return f"({_value(node.test)} ? {_value(node.body)} : {_value(node.orelse)})"
    if isinstance(node, ast.Tuple):
        return f"[{', '.join(map(_value, node.elts))}]"
    if isinstance(node, ast.Call):
        return _call(node)
    raise _no_counterpart(node)


def _item(node):
    if isinstance(node.slice, ast.Slice):
        ends = [_value(end) for end in (node.slice.lower, node.slice.upper) if end]
        return f"{_value(node.value)}.subarray({', '.join(ends)})"
    return f"{_value(node.value)}[{_value(node.slice)}]"


def _call(node):
    name, arguments = _value(node.func), ", ".join(map(_value, node.args))
    if name == "len":
        return f"{arguments}.length"
    if name == "int":
        return f"Math.trunc({arguments})"
    if name == "range":  # a table of column numbers
        return f"Array({arguments}).keys()"
    return f"Math.{name}({arguments})" if name in MATH else f"{name}({arguments})"


def _target(node):
    return f"[{', '.join(map(_value, node.elts))}]" if isinstance(node, ast.Tuple) else _value(node)


def _bound(function):
    return {
        name.id
        for name in ast.walk(function)
        if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
    }


def _is_text(node):
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _no_counterpart(node):
    return ValueError(
        f"source: line {node.lineno} has {type(node).__name__}, which has no counterpart in "
        f"JavaScript here; write it with loops and numbers ({ast.unparse(node)[:60]})."
    )
