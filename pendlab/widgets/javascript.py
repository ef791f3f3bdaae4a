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
CALLS = {"len": "{}.length", "int": "Math.trunc({})", "range": "Array({}).keys()"} | {
    name: f"Math.{name}({{}})" for name in "abs cos exp floor max min sin sqrt".split()
}


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
    lines = []
    for node in ast.parse(source).body:
        if getattr(node, "name", None) not in skip:
            constant = "const " if isinstance(node, ast.Assign) else ""
            lines += [constant + line for line in _statement(node)]
    return "\n".join(lines)


def _statement(node):
    """Lines of one statement."""
    match node:
        case ast.ImportFrom() | ast.Expr(value=ast.Constant(value=str())):
            return []
        case ast.FunctionDef(name=name, args=ast.arguments(args=args), body=body):
            given = [arg.arg for arg in args]
            names = [one for one in ast.walk(node) if isinstance(one, ast.Name)]
            local = {one.id for one in names if isinstance(one.ctx, ast.Store)} - set(given)
            first = f"let {', '.join(sorted(local))};" if local else ""
            return _block(f"function {name}({', '.join(given)})", body, first)
        case ast.Assign(targets=[target], value=value):
            return [f"{_value(target)} = {_value(value)};"]
        case ast.AugAssign(target=target, op=op, value=value) if type(op) in OPERATORS:
            return [f"{_value(target)} {OPERATORS[type(op)]}= {_value(value)};"]
        case ast.For(target=ast.Name(id=i), iter=ast.Call(args=[count]), body=body):
            return _block(f"for ({i} = 0; {i} < {_value(count)}; {i}++)", body)
        case ast.If(test=test, body=body, orelse=other):
            lines = _block(f"if ({_value(test)})", body)
            return [*lines[:-1], *_block("} else", other)] if other else lines
        case ast.Return(value=value):
            return [f"return {_value(value)};"]
        case ast.Expr(value=value):
            return [f"{_value(value)};"]
    raise _no_counterpart(node)


def _block(head, statements, first=""):
    """Statements in braces behind a head."""
    lines = [line for statement in statements for line in _statement(statement)]
    return [f"{head} {{", *(f"  {line}" for line in [first, *lines] if line), "}"]


def _value(node):
    """One expression, or what is assigned to."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Constant(value=number) if type(number) in (int, float):
            return repr(number)
        case ast.Attribute(value=owner, attr=name):
            return f"{_value(owner)}.{name}"
        case ast.Subscript(value=row, slice=ast.Slice(lower=first, upper=None)):
            return f"{_value(row)}.subarray({_value(first)})"
        case ast.Subscript(value=row, slice=index):
            return f"{_value(row)}[{_value(index)}]"
        case (
            ast.BinOp(left=left, op=op, right=right)
            | ast.Compare(left=left, ops=[op], comparators=[right])
            | ast.BoolOp(op=op, values=[left, right])
        ) if type(op) in OPERATORS:
            return f"({_value(left)} {OPERATORS[type(op)]} {_value(right)})"
        case ast.UnaryOp(op=op, operand=value) if type(op) in OPERATORS:
            return f"{OPERATORS[type(op)]}({_value(value)})"
        case ast.IfExp(test=test, body=value, orelse=other):
            return f"({_value(test)} ? {_value(value)} : {_value(other)})"
        case ast.Tuple(elts=values):
            return f"[{', '.join(map(_value, values))}]"
        case ast.Call(func=ast.Name(id=name), args=values, keywords=[]):
            return CALLS.get(name, name + "({})").format(", ".join(map(_value, values)))
    raise _no_counterpart(node)


def _no_counterpart(node):
    return ValueError(
        f"source: line {node.lineno} has {type(node).__name__}, which has no counterpart in "
        f"JavaScript here; write it with loops and numbers ({ast.unparse(node)[:60]})."
    )
