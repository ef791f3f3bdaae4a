"""A course for nbgrader, laid out from the solved notebooks.

    python -m pendlab course DIR --confined

nbgrader releases, collects, marks, keeps the gradebook and gives feedback. What it cannot know
comes from here: source notebooks whose checks count points and whose answers in words carry sample
answers, what the marker reads beside them, and kernels that run hand-ins confined (`confined`).
"""

import argparse
import ast
import hashlib
import json
import sys
from pathlib import Path
from string import Template

from . import confined as prison
from . import exercises as paper
from .editions import stamp, student, told
from .files import as_text, command, notebooks, opened, writable

MANIFEST = ".pendlab-course.json"
CELL_SECONDS = 120

CONFIG = Template('''"""nbgrader's configuration of this course; `nbgrader --help-all` lists what else there is."""

import os
import sysconfig
from pathlib import Path

# nbgrader calls alembic by name, which stands beside this Python, activated or not.
os.environ["PATH"] = sysconfig.get_path("scripts") + os.pathsep + os.environ.get("PATH", "")

c = get_config()
c.CourseDirectory.root = str(Path(__file__).resolve().parent)
c.CourseDirectory.course_id = "pendlab"
# The gaps themselves are `name = ...` in the sources, so that a released notebook runs to its end.
c.ClearSolutions.code_stub = {"python": "# YOUR CODE HERE"}
c.OverwriteCells.add_missing_cells = True  # a deleted check comes back
c.Execute.timeout = $seconds  # of each cell
c.Execute.raise_on_iopub_timeout = False  # late output costs its own cell
c.LimitOutput.max_lines = 300
''')

CONFINED = """
# Kernels run confined: python -m pendlab.classroom.confined.
import atexit, shutil, tempfile

folder = tempfile.mkdtemp(prefix="pendlab-")
atexit.register(shutil.rmtree, folder, ignore_errors=True)
os.environ["JUPYTER_PATH"] = str(Path(__file__).resolve().parent / "jupyter")
c.Execute.kernel_name = "confined"
c.KernelManager.transport = "ipc"
c.KernelManager.ip = folder + "/k"
"""

SAFE = """**Hand-ins run confined** (bubblewrap): they see the system, Python and their own folder, all read-only, no network and no other hand-in, with 4 GB of memory and 120 s for each cell. What they cannot be kept from: a hand-in that replaces `pl.check` gives itself full points, and its feedback shows it."""
UNSAFE = """**Hand-ins run as you**: they can read and write your files, other hand-ins, these sources and the gradebook, and use your network; only the time of a cell is bounded. Read them first, or mark on a machine that holds nothing else. On Linux with bubblewrap, `python -m pendlab course DIR --confined` shuts them in."""
UNAVAILABLE = (
    "`--confined` was asked for, but this machine has no working bubblewrap (Linux only). "
)


def course(sources, folder, confined=False):
    """Lay out a course from solved notebooks, or folders of them; what a teacher has changed stays.

    Returns
    -------
    (written, kept) : paths of new or renewed files, and of files with a teacher's changes
    """
    folder = writable("DIR", folder)
    wanted = files([path for path, _ in notebooks(sources, folder)], confined)
    manifest = folder / MANIFEST
    sums = json.loads(manifest.read_text(encoding="utf-8")) if manifest.exists() else {}
    written, kept = [], []
    for name, text in wanted.items():
        path = folder / name
        there = path.read_text(encoding="utf-8") if path.exists() else None
        if there is not None and there != text and _checksum(there) != sums.get(name):
            kept.append(path)
            continue
        sums[name] = _checksum(text)
        if there != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            written.append(path)
    folder.mkdir(parents=True, exist_ok=True)
    manifest.write_text(json.dumps(sums, indent=1) + "\n", encoding="utf-8")
    return written, kept


def _checksum(text):
    return hashlib.sha256(text.encode()).hexdigest()


def files(paths, confined=False):
    """Relative path -> text of everything that a course holds."""
    found = {}
    for path in paths:
        notebook = opened(path)
        if path.stem == "template" or not paper.exercises(notebook):
            continue
        name, marking = assignment(path), paper.marking(path)
        if f"source/{name}/{path.name}" in found:
            raise ValueError(f"notebooks: two of them are called {path.name}; rename one.")
        found[f"source/{name}/{path.name}"] = as_text(source(notebook, marking))
        found[f"marking/{name}.md"] = sheet(name, paper.exercises(notebook), marking)
    if not found:
        raise ValueError("notebooks: none of them has an exercise to mark.")
    safe = confined and prison.available()
    names = ", ".join(f"`{Path(file).stem}`" for file in found if file.startswith("marking/"))
    safety = SAFE if safe else (UNAVAILABLE if confined else "") + UNSAFE
    readme = Template(Path(__file__).with_suffix(".md").read_text(encoding="utf-8"))
    found["README.md"] = readme.substitute(names=names, safety=safety)
    found["nbgrader_config.py"] = CONFIG.substitute(seconds=CELL_SECONDS) + CONFINED * safe
    if safe:
        found["jupyter/kernels/confined/kernel.json"] = json.dumps(KERNEL, indent=1) + "\n"
    return found


KERNEL = {
    "argv": [sys.executable, "-m", f"{prison.__name__}", "{connection_file}"],
    "display_name": "Python, confined",
    "language": "python",
    "interrupt_mode": "message",  # a signal would stop bubblewrap, not the cell
    "env": {"PYTHONPATH": str(Path(__file__).parents[2])},
}


def assignment(path):
    """The assignment's name: the notebook's own, with its folder's where that is not `notebooks`."""
    return path.stem if path.parent.name != "homework" else f"homework_{path.stem}"


def source(notebook, marking):
    """nbgrader's source of a solved notebook: gaps ready, solutions in place, points counted."""
    stamp(notebook)
    solved = {cell["id"]: cell["source"] for cell in notebook["cells"]}
    tasks = paper.exercises(notebook)
    samples = {n: marking.get(e.name, {}).get("full") for e in tasks for n in e.written}
    edition = student(notebook)
    for cell in edition["cells"]:
        for key in ("deletable", "editable"):  # nbgrader's to set; the source is the teacher's
            cell["metadata"].pop(key, None)
        if graded := cell["metadata"].get("nbgrader"):
            original = solved[cell["id"]]
            filled = refilled(original, cell["source"], samples.get(cell["id"]))
            cell["source"] = counted(filled, graded.get("points"))
    return edition


def refilled(original, gap, sample=None):
    """The solved cell with its gap beside each solution: before it, or after it in a function."""
    lines, regions = original.splitlines(), paper.region(original)
    if len(regions) != 1:
        return original
    first, last = regions[0]
    solution = lines[first : last + 1]
    if sample:
        solution[1:-1] = [sample]
    after = len(lines) - last - 1
    stub = gap.splitlines()[first:]
    stub = [line for line in stub[: len(stub) - after] if line.strip()[:1] not in "#*"]
    inside = lines[first][:1].isspace()
    middle = [*solution, *stub] if inside else [*stub, *solution]
    return "\n".join(lines[:first] + middle + lines[last + 1 :])


def counted(text, points):
    """A check cell that ends in ``pl.check(...)`` is told its points, which nbgrader takes from it."""
    if points is None or not text.rstrip().endswith(")"):
        return text
    try:
        last = ast.parse(text).body[-1]
    except SyntaxError:  # Markdown
        return text
    if not ast.unparse(last).startswith("pl.check("):
        return text
    return f"{text.rstrip()[:-1]}, points={points:g})"


def sheet(name, exercises, marking):
    """What the marker reads beside the answers in words."""
    lines = [f"# Marking {name}", "", "Not for students."]
    for exercise in exercises:
        lines += ["", f"## {exercise}", *told(marking.get(exercise.name, {}))]
    return "\n".join(lines) + "\n"


def add_commands(commands):
    about = "A course for nbgrader: source notebooks with points, configuration, marking sheets."
    parser = command(commands, "course", _run, about, "control-lab --confined")
    parser.description += " Run again, it renews what you have not changed."
    parser.add_argument("folder", type=Path, metavar="DIR", help="where the course goes")
    parser.add_argument(
        "--notebooks",
        nargs="+",
        type=Path,
        default=[Path("notebooks")],
        help="solved notebooks, or folders of them (default: notebooks)",
    )
    parser.add_argument(
        "--confined",
        action="store_true",
        help="run hand-ins shut in, on Linux with bubblewrap (default: as you)",
    )
    gone = command(commands, "mark", _gone, "Gone: nbgrader marks, see course.")
    gone.add_argument("anything", nargs=argparse.REMAINDER)


def _run(options):
    written, kept = course(options.notebooks, options.folder, options.confined)
    print(f"{len(written)} files written; {options.folder / 'README.md'} tells how to go on.")
    if options.confined and not prison.available():
        print("Not confined: this machine has no working bubblewrap.", file=sys.stderr)
    for path in kept:
        print(f"left alone, as it was changed: {path}", file=sys.stderr)
    if kept:
        print("Move them away and run this again to have them anew.", file=sys.stderr)
    return 1 if kept else 0


def _gone(options):
    raise ValueError(
        "mark is gone: `python -m pendlab course DIR` lays out a course in which nbgrader marks "
        "hand-ins, keeps the gradebook and gives feedback."
    )
