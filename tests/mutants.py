"""Single-token mutants of a numerical module, each against the module's own tests.

    python tests/mutants.py controllability pushes --count 20

makes 20 mutants of each in a copy of the repository (an operator, comparison, number or name turned
into its neighbour), runs the tests that belong to the module, and prints the survivors. The choice
follows from ``--seed``. A survivor is a missing test, or a change that makes no difference.
"""

import argparse
import io
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tokenize
from pathlib import Path

ROOT = Path(__file__).parent.parent
TESTS = {
    "loop": ["tests/test_loop.py", "pendlab/loop.py"],
    "nyquist": ["tests/test_loop.py"],
    "gain": ["tests/test_gain.py", "tests/cases/test_scaling.py"],
    "observers": ["tests/test_observers.py"],
    "sampled": ["tests/test_sampled.py"],
    "models": ["tests/test_models.py"],
    "controllers": ["tests/test_controllers.py"],
    "design": ["tests/test_design.py"],
    "studies/controllability": ["tests/test_controllability.py"],
    "studies/structured": ["tests/test_transmission.py"],
    "studies/transmission": ["tests/test_transmission.py"],
    "studies/pushes": ["tests/test_pushes.py", "tests/cases/test_searches_end.py"],
    "studies/code_export": ["tests/test_c_export.py"],
    "bench/plant": ["tests/test_simulation_plant.py"],
    "bench/kernel": ["tests/test_simulation.py", "tests/test_simulation_plant.py"],
}
NEIGHBOURS = {
    "+": "-", "-": "+", "*": "/", "/": "*", "@": "*", "<": "<=", "<=": "<", ">": ">=", ">=": ">",
    "==": "!=", "!=": "==", "and": "or", "or": "and", "min": "max", "max": "min", "True": "False",
    "False": "True", "any": "all", "all": "any", "argmin": "argmax", "argmax": "argmin",
    "real": "imag", "imag": "real", "zeros": "ones", "hstack": "vstack", "sin": "cos", "floor": "ceil",
}  # fmt: skip


def neighbour(token):
    """What the token is turned into, or None."""
    if token.type == tokenize.NUMBER:
        if token.string.isdigit():
            return str(int(token.string) + 1)
        value = complex(token.string)
        # A tolerance moves by a factor that a test on both of its sides must notice.
        return None if value.imag else repr(value.real * (1.3 if value.real > 1e-5 else 1e3))
    if token.type in (tokenize.OP, tokenize.NAME):
        return NEIGHBOURS.get(token.string)
    return None


def mutants(source):
    """(line number, line before, source) of every mutant, messages left alone."""
    lines, quiet = source.splitlines(keepends=True), -1
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.string == "raise":
            quiet = len(token.line) - len(token.line.lstrip())
        elif token.type == tokenize.NEWLINE:
            quiet = -1
        new = neighbour(token)
        if (
            new is None
            or quiet >= 0
            or token.line.lstrip().startswith(("from ", "import ", "@", "def "))
        ):
            continue
        (row, start), (_, stop) = token.start, token.end
        line = lines[row - 1]
        changed = line[:start] + new + line[stop:]
        if line[start:stop] == "*" and line[:start].rstrip().endswith(("(", ",", "[", "=")):
            continue  # unpacking
        yield (
            row,
            line.strip(),
            changed.strip(),
            "".join([*lines[: row - 1], changed, *lines[row:]]),
        )


def killed(copy, tests, seconds):
    """Whether a test fails (or does not end) in the copy."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, *tests], cwd=copy, capture_output=True, timeout=seconds,
            env={**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return True
    return done.returncode != 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "modules", nargs="*", default=[], help=f"of {', '.join(TESTS)}; all if none"
    )
    parser.add_argument("--count", type=int, default=15)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=300.0, help="for one mutant's tests")
    options = parser.parse_args()
    modules = [m for m in TESTS if not options.modules or m.split("/")[-1] in options.modules]
    total = dead = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "repository"
        unwanted = shutil.ignore_patterns(".git", "__pycache__", "notebooks", ".*cache")
        shutil.copytree(ROOT, copy, ignore=unwanted)
        for module in modules:
            path = copy / "pendlab" / f"{module}.py"
            source = path.read_text(encoding="utf-8")
            if killed(copy, TESTS[module], options.seconds):
                raise SystemExit(f"{module}: its tests fail without a mutant.")
            every = list(mutants(source))
            chosen = random.Random(f"{options.seed} {module}").sample(
                every, min(options.count, len(every))
            )
            alive = []
            for row, before, after, text in sorted(chosen):
                path.write_text(text, encoding="utf-8")
                if not killed(copy, TESTS[module], options.seconds):
                    alive.append(f"  line {row}: {before}\n         -> {after}")
            path.write_text(source, encoding="utf-8")
            total, dead = total + len(chosen), dead + len(chosen) - len(alive)
            print(f"{module}: {len(chosen) - len(alive)} of {len(chosen)} killed", flush=True)
            print("\n".join(alive), end="\n" if alive else "", flush=True)
    print(f"{dead} of {total} mutants killed")


if __name__ == "__main__":
    main()
