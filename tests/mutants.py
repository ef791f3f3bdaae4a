"""Single-token mutants of numerical modules, each against the tests of its module.

    python tests/mutants.py loop pushes --count 15 --seed 1

draws mutants of each module (an operator, comparison, number or name turned into its neighbour;
error messages left alone) and prints those that no test notices: a missing test, or a change that
makes no difference. Nothing is written: one process imports the libraries and forks for each mutant,
where the module is read as changed. Tests that came past the line come first, the quick ones
before the others. `--line N` tries every mutant of one line. Needs fork, so Linux or macOS.
"""

import argparse
import importlib.util
import io
import json
import os
import random
import signal
import sys
import tempfile
import time
import tokenize
from contextlib import suppress
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
# Tests beside test_<module>.py and the module's own examples; "cases/..." stands for cases/test_...
TESTS = {
    "loop": "cases/narrow_resonances cases/multiple_poles cases/scaling",
    "nyquist": "loop cases/multiple_poles", "gain": "cases/scaling", "observers": "",
    "sampled": "cases/builders_twice", "models": "cases/builders_twice", "controllers": "",
    "design": "", "lagrange": "models", "parameters": "cases/rig_files",
    "bench/kernel": "simulation simulation_plant",
    "bench/plant": "simulation simulation_plant cases/runs_end",
    "bench/inputs": "simulation cases/bad_arguments_bench",
    "bench/imperfections": "inputs simulation simulation_plant cases/bad_arguments_bench",
    "bench/gearbox": "inputs simulation cases/bad_arguments_bench",
    "bench/stepping": "simulation simulation_plant cases/bad_arguments_bench",
    "bench/many": "simulation cases/bad_arguments_bench",
    "studies/controllability": "cases/searches_end",
    "studies/structured": "transmission cases/narrow_resonances",
    "studies/transmission": "cases/narrow_resonances", "studies/pushes": "cases/searches_end",
    "studies/code_export": "c_export", "studies/describing": "", "studies/timing": "",
    "studies/unknown_input": "cases/unknown_input_observer",
    "paper/experiment": "", "paper/alignment": "sampled",
}  # fmt: skip
NEIGHBOURS = {
    "+": "-", "-": "+", "*": "/", "/": "*", "@": "*", "**": "*", "//": "/", "%": "*", "+=": "-=",
    "-=": "+=", "*=": "/=", "/=": "*=", "&": "|", "~": "", "<": "<=", "<=": "<", ">": ">=",
    ">=": ">", "==": "!=", "!=": "==", "and": "or", "or": "and", "not": "", "is": "is not",
    "True": "False", "False": "True", "min": "max", "max": "min", "minimum": "maximum",
    "maximum": "minimum", "argmin": "argmax", "argmax": "argmin", "any": "all", "all": "any",
    "real": "imag", "imag": "real", "zeros": "ones", "ones": "zeros", "hstack": "vstack",
    "vstack": "hstack", "sin": "cos", "cos": "sin", "floor": "ceil", "abs": "", "break": "continue",
    "cumsum": "cumprod",
}  # fmt: skip
# What SymPy takes long for stays in memory, unless it is what changes.
KEPT = ("_arguments", "parameters", "lagrange")


def neighbour(token):
    """What the token is turned into, or None."""
    if token.type != tokenize.NUMBER:
        named = token.type in (tokenize.OP, tokenize.NAME)
        return NEIGHBOURS.get(token.string) if named else None
    if token.string.isdigit():
        return str(int(token.string) + 1)
    value = complex(token.string)
    # A tolerance moves by a factor that a test on both of its sides must notice.
    moved = value.real * (1.3 if value.real > 1e-5 else 1e3) or 1.0
    return None if value.imag else repr(moved)


def mutants(source):
    """(line number, line before, line after, source) of every mutant."""
    lines, message = source.splitlines(keepends=True), False
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        (row, start), (_, stop) = token.start, token.end
        message = token.type != tokenize.NEWLINE and (message or token.string == "raise")
        if (new := neighbour(token)) is None or message:
            continue
        line = lines[row - 1]
        head = line.lstrip().startswith(("def ", "@")) and token.type != tokenize.NUMBER
        unpacking = token.string in "**" and line[:start].rstrip().endswith(("(", ",", "[", "="))
        if head or unpacking or line.lstrip().startswith("from "):
            continue
        changed = line[:start] + new + line[stop:]
        text = "".join([*lines[: row - 1], changed, *lines[row:]])
        with suppress(SyntaxError):
            compile(text, "", "exec")
            yield row, line.strip(), changed.strip(), text


class Changed(SourceFileLoader):
    """Imports a module from other text than its file holds."""

    def __init__(self, name, path, text):
        super().__init__(name, str(path))
        self.text, read = text, Path.read_text  # the kernel is read as text
        Path.read_text = lambda p, *a, **k: text if p == path else read(p, *a, **k)
        sys.meta_path.insert(0, self)

    def find_spec(self, name, path=None, target=None):
        if name == self.name:
            return importlib.util.spec_from_file_location(name, self.path, loader=self)

    def get_code(self, name):
        return compile(self.text, self.path, "exec")


class Order:
    """Sorts the tests by what an earlier run noted: seconds, and the lines it came past."""

    def __init__(self, path, row=None, known=None):
        self.path, self.row, self.known, self.seen = path, row, known, {}

    def pytest_collection_modifyitems(self, items):
        if self.known:
            items.sort(key=self.rank)

    def rank(self, item):
        seconds, rows = self.known.get(item.nodeid, (0, []))
        return self.row not in rows, seconds

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        if self.known:
            return (yield)
        begin, rows = time.perf_counter(), set()

        def trace(frame, event, argument):
            if frame.f_code.co_filename == str(self.path):
                rows.add(frame.f_lineno)
                return trace

        sys.settrace(trace)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            self.seen[item.nodeid] = time.perf_counter() - begin, sorted(rows)


def tested(module, text, order, seconds, notes=None):
    """Whether the tests pass (in a fork) with `text` in the module's place."""
    if child := os.fork():
        return os.waitpid(child, 0)[1] == 0
    signal.alarm(int(seconds))
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    kept = () if module in KEPT else [f"pendlab.{name}" for name in KEPT]
    for name in [n for n in sys.modules if n.startswith("pendlab") and n not in kept]:
        del sys.modules[name]
    Changed(f"pendlab.{module.replace('/', '.')}", order.path, text)
    names = dict.fromkeys([module.split("/")[-1], *TESTS[module].split()])
    files = [ROOT / "tests" / Path(n).parent / f"test_{Path(n).name}.py" for n in names]
    # Plain assertions, or pytest would read the module by itself, from its file.
    options = "-x -q -o addopts= --doctest-modules --assert=plain -p no:cacheprovider -p no:xdist"
    paths = [str(f) for f in [*files, order.path] if f.exists()]
    status = pytest.main([*options.split(), "-p", "no:nbval", *paths], plugins=[order])
    if notes:
        notes.write_text(json.dumps(order.seen), encoding="utf-8")
    os._exit(status)


def import_package():
    """Everything imported once, the equations of motion of all rigs in the tests derived."""
    import pendlab

    for name in pendlab.__all__:
        getattr(pendlab, name)
    for links, motors in [(2, 1), (3, 1), (3, 2), (4, 1), (4, 2), (4, 3)]:
        motion = pendlab.derive(links, motors)
        assert motion.linear and motion.nonlinear and motion.total_energy


def tried(module, folder, options):
    """(line number, before, after, whether no test noticed) of each mutant that is drawn."""
    path, notes = ROOT / f"pendlab/{module}.py", folder / "notes.json"
    source, begin = path.read_text(encoding="utf-8"), time.perf_counter()
    if not tested(module, source, Order(path), 900, notes):
        raise SystemExit(f"{module}: its tests fail without a mutant.")
    seconds, known = time.perf_counter() - begin, json.loads(notes.read_text())
    every = [m for m in mutants(source) if options.line in (None, m[0])]
    count = len(every) if options.line else min(options.count, len(every))
    chosen = random.Random(f"{options.seed} {module}").sample(every, count)
    for row, before, after, text in sorted(chosen):
        yield row, before, after, tested(module, text, Order(path, row, known), 3 * seconds + 30)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("modules", nargs="*", help=f"of {', '.join(TESTS)}; all if none")
    parser.add_argument("--count", type=int, default=15)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--line", type=int)
    options = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    import_package()
    total = dead = 0
    with tempfile.TemporaryDirectory() as folder:
        own = os.environ.get("PENDLAB_CACHE") or Path.home() / ".cache/pendlab"
        os.environ.update(PENDLAB_SEED=str(own), PENDLAB_CACHE=folder)
        for module in TESTS:
            if options.modules and not {module, module.split("/")[-1]} & {*options.modules}:
                continue
            before = total, dead
            for row, old, new, alive in tried(module, Path(folder), options):
                total, dead = total + 1, dead + (not alive)
                if alive:
                    print(f"  line {row}: {old}\n         -> {new}", flush=True)
            print(f"{module}: {dead - before[1]} of {total - before[0]} killed", flush=True)
    print(f"{dead} of {total} mutants killed")


if __name__ == "__main__":
    main()
