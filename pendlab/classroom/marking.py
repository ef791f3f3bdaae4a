"""Collect and mark a folder of submissions without trusting them.

    python -m pendlab mark submissions --against notebooks/02_system_and_models.ipynb --csv marks.csv

A submission is ``FOLDER/student/any.ipynb`` (deeper folders too, as nbgrader makes them) or
``FOLDER/student.ipynb``. Each is judged in processes of its own (`judge` and `pupil`), so that an
endless loop, an exit, a flood of output, a damaged file or a hostile notebook costs that student's
rows only. The check cells are the original's; a submission hands in values, never verdicts.

Limits, honestly. Where `confinement.can_confine` is false (Windows, macOS, some servers) a notebook
runs with the rights of whoever marks: time, memory, processes and disk are bounded, but it could
read and write that user's files and use the network; mark on an account that holds nothing else.
Where it is true, it can still read what all users of the machine can. A function or object that a
student hands in stays in the student's process and may answer what it likes each time it is called.
And a student who copies an answer, or computes it with the package, has the answer.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from . import exercises as paper

COLUMNS = ("student", "notebook", "exercise", "points", "max", "verdict", "reason")
Row = namedtuple("Row", (*COLUMNS, "score", "claimed"), defaults=(None, None))
LARGEST_REPORT = 10_000_000  # bytes


def mark(folder, originals, limits=None, jobs=1, each=None):
    """Mark every submission below a folder.

    Parameters
    ----------
    folder : of the submissions
    originals : paths of the solved notebooks
    limits : confinement.Limits for each submission
    jobs : submissions marked at the same time
    each : called with (student, notebook) as each is done

    Returns
    -------
    list of Row, by student, notebook and exercise, whatever the number of jobs
    """
    from .confinement import Limits

    limits = limits or Limits()
    known = {Path(path): paper.read(path) for path in originals}
    handed_in, unknown = collect(folder, known)
    students = sorted({student for student, _ in (*handed_in, *unknown)})

    def one(task):
        student, path = task
        hidden = (folder, path.parent)
        rows = _mark_one(student, path, known[path], handed_in.get(task), hidden, limits)
        if each:
            each(student, path.stem)
        return rows

    with ThreadPoolExecutor(jobs) as pool:
        marked = list(pool.map(one, [(student, path) for student in students for path in known]))
    rows = [row for rows in marked for row in rows]
    for (student, path), reason in unknown.items():
        rows.append(Row(student, path.name, "", 0, 0, "unreadable", _one_line(reason)))
    return sorted(rows, key=lambda row: row.student)


def collect(folder, originals):
    """({(student, original): submission}, {(student, path): why not}) of all notebooks below.

    A file belongs to the original with which it shares most cell ids; one that cannot be read, to
    the original after which it is named, or to the only one. Of several the last name counts.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ValueError(f"folder: expected a folder of submissions, found {str(folder)!r}.")
    handed_in, unknown = {}, {}
    for path in sorted(folder.rglob("*.ipynb"), key=lambda path: path.as_posix()):
        inside = path.relative_to(folder)
        if ".ipynb_checkpoints" in inside.parts:
            continue
        original, reason = _belongs_to(path, originals)
        student = inside.parts[0] if len(inside.parts) > 1 else _named(inside.stem, original)
        if original is None:
            unknown[student, path] = reason
        else:
            handed_in[student, original] = path
    return handed_in, unknown


def _belongs_to(path, originals):
    try:
        ids = {cell["id"] for cell in paper.read(path)["cells"]}
    except (ValueError, OSError) as problem:
        ids, reason = set(), str(problem)
    else:
        reason = f"{path.name}: belongs to none of the given notebooks"
    shared = {key: len(ids & {c["id"] for c in book["cells"]}) for key, book in originals.items()}
    best = max(shared, key=shared.get)
    if shared[best]:
        return best, None
    named = [key for key in originals if key.stem in path.stem]
    if named or len(originals) == 1:
        return (named or list(originals))[0], None
    return None, reason


def _named(stem, original):
    """The student in a file name such as ``smith_02_system_and_models``."""
    rest = stem.replace(original.stem, "").strip("_- ") if original else stem
    return rest or stem


def _mark_one(student, path, original, submission, hidden, limits):
    """One row per exercise, whatever the submission does."""
    if submission is None:
        messages, reason = [], "not handed in"
    else:
        messages, reason = _run_judge(path, submission, hidden, limits)
    judged = {m["exercise"]: m for m in messages if "exercise" in m}
    claimed = next((m["claimed"] for m in messages if "claimed" in m), None)
    rows = []
    for exercise in paper.exercises(original):
        found = judged.get(exercise.name) or {
            "exercise": exercise.name,
            "points": 0,
            "max": exercise.points,
            "verdict": "missing" if submission is None else "stopped",
            "reason": reason,
        }
        found["reason"] = _one_line(found["reason"])
        rows.append(Row(student, path.stem, **found, claimed=claimed))
    return rows


def _run_judge(original, submission, hidden, limits):
    """The judge's messages, and why there are no more of them."""
    from .confinement import end, watch

    try:
        paper.read(submission)
    except (ValueError, OSError) as problem:
        return [], str(problem)
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        tempfile.TemporaryFile() as output,
    ):
        task = {
            "original": str(Path(original).resolve()),
            "submission": str(Path(submission).resolve()),
            "folder": str(Path(folder).resolve()),
            "hidden": [str(Path(place).resolve()) for place in hidden],
            "limits": asdict(limits),
        }
        _lend_cache(folder)
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "pendlab.classroom.judge"],
            stdin=subprocess.PIPE,
            stdout=output,
            stderr=subprocess.DEVNULL,
            cwd=Path(original).resolve().parent,
            env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
            start_new_session=True,
        )
        process.stdin.write(json.dumps(task).encode() + b"\n")
        process.stdin.close()
        try:
            reason = watch(process, folder, limits)
        finally:
            end(process.pid)
            process.wait()
        output.seek(0)
        lines = output.read(LARGEST_REPORT).splitlines()
    return _sum_up(lines, reason)


def _lend_cache(folder):
    """Copy what is compiled already, so that each submission need not compile it anew.

    A copy, because nothing that a submission can write is ever run by the marker.
    """
    from ..generated import cache_folders

    cache = next((place for place in cache_folders() if place.is_dir()), None)
    if cache:
        shutil.copytree(cache, Path(folder) / "cache", ignore_dangling_symlinks=True)


def _sum_up(lines, reason):
    messages = []
    for line in lines:
        try:
            messages.append(json.loads(line))
        except ValueError:  # the last line of a judge that was killed
            break
    if reason is None:
        ended = [message["ended"] for message in messages if "ended" in message]
        reason = ended[0] if ended else "the judge ended before its time"
    else:
        running = [message["running"] for message in messages if "running" in message]
        reason += f" (in cell {running[-1]})" if running else ""
    return messages, reason


def _one_line(text):
    """Text that a spreadsheet shows and never runs: printable, short, no formula."""
    text = "".join(sign if sign.isprintable() else " " for sign in str(text))[:300]
    return f"'{text}" if text.lstrip()[:1] in ("=", "+", "-", "@") else text


def leaderboard(rows):
    """(student, exercise, score, claimed) of rows with a recomputed score, highest first."""
    scored = [row for row in rows if row.score is not None]
    scored.sort(key=lambda row: (row.exercise, -row.score, row.student))
    return [(row.student, row.exercise, row.score, row.claimed) for row in scored]


def write_csv(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([_cell(value) for value in row[: len(header)]] for row in rows)


def _cell(value):
    return "" if value is None else _one_line(value) if isinstance(value, str) else value


def totals(rows):
    """One line per student and notebook: points and what went wrong."""
    sums = {}
    for row in rows:
        entry = sums.setdefault((row.student, row.notebook), [0, 0, []])
        entry[0], entry[1] = entry[0] + row.points, entry[1] + row.max
        if row.verdict not in ("right", "by hand"):
            entry[2].append(f"{row.exercise} {row.verdict}".strip())
    for (student, notebook), (points, most, wrong) in sums.items():
        yield f"{student:20s} {notebook:32s} {points:g}/{most:g}  {', '.join(wrong)}".rstrip()


def add_commands(commands):
    parser = commands.add_parser("mark", help="mark a folder of submissions without trusting them")
    parser.add_argument("folder", type=Path, help="submissions: FOLDER/student/*.ipynb")
    parser.add_argument("--against", type=Path, nargs="+", required=True, help="solved notebooks")
    parser.add_argument("--csv", type=Path, default=Path("marks.csv"), help="default: %(default)s")
    parser.add_argument("--leaderboard", type=Path, help="CSV of recomputed scores")
    parser.add_argument("--seconds", type=float, default=120, help="for each submission")
    parser.add_argument("--memory", type=float, default=4000, help="MB for each submission")
    parser.add_argument("--jobs", type=int, default=1, help="submissions at the same time")
    parser.set_defaults(run=_run)


def _run(options):
    from .confinement import Limits, can_confine
    from .editions import expand

    limits = Limits(options.seconds, options.memory)
    originals = expand(options.against)
    if not can_confine():
        print(
            "This machine cannot confine processes: submissions run with your rights, within "
            "limits of time and memory. Mark on an account that holds nothing else."
        )
    problems = own_problems(originals, limits)
    if problems:
        print("The original does not pass its own checks; nothing was marked.", *problems, sep="\n")
        return 1
    rows = mark(
        options.folder, originals, limits, options.jobs, lambda *done: print(*done, flush=True)
    )
    write_csv(options.csv, COLUMNS, rows)
    print(*totals(rows), f"Marks are in {options.csv}.", sep="\n")
    if options.leaderboard:
        write_csv(
            options.leaderboard, ("student", "exercise", "score", "claimed"), leaderboard(rows)
        )
    return 0


def own_problems(originals, limits):
    """What an original would lose if it were handed in: its answers and checks must agree."""
    return [
        f"{row.notebook} {row.exercise}: {row.verdict}, {row.reason}"
        for path in originals
        for row in _mark_one("original", path, paper.read(path), path, (), limits)
        if row.verdict not in ("right", "by hand")
    ]
