"""The trusted side of marking: judges one submission against the original notebook.

Started by `marking` as ``python -m pendlab.classroom.judge`` for each submission. It runs the check cells of
the *original*, and those given cells of the original on which they depend, in this process. The
submission's cells run in another process (`pupil`), which is asked for the values that the solution
cells are to define, as plain data. So nothing that a submission prints, replaces or pretends can
make a verdict; it can only hand in answers. Functions and objects stay in the other process and are
called there, one call at a time.
"""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pendlab as pl

from . import exercises as paper
from .answers import decode, encode
from .confinement import Limits, adopt_orphans, confined, end, environment
from .pupil import describe

LONGEST_REPLY = 64_000_000  # bytes


class Gone(Exception):
    """The student's process ended or sent what is no reply."""


class Pupil:
    """The other process: runs cells of the submission and gives values of names."""

    def __init__(self, cells, folder, hidden, limits):
        arguments = [str(limits.seconds), str(limits.memory), str(limits.disk)]
        command = [sys.executable, "-P", "-m", "pendlab.classroom.pupil", *arguments]
        self.process = subprocess.Popen(
            confined(command, folder, hidden),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=environment(folder),
        )
        self.cells, self.at, self.cell, self.errors = cells, 0, None, {}

    def ask(self, **request):
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline(LONGEST_REPLY)
            reply = json.loads(line) if line.endswith(b"\n") else None
        except (OSError, ValueError, RecursionError):
            reply = None
        if not isinstance(reply, dict) or not reply.keys() & {"error", "value", "missing"}:
            raise Gone(f"the notebook ended its process or disturbed its channel{self.where()}")
        return reply

    def where(self):
        return f" (in cell {self.cell})" if self.cell else ""

    def run_to(self, position, checks, report):
        """Run the submission's cells before `position` that have not run yet, but no checks."""
        for cell in self.cells[self.at : position]:
            self.at += 1
            if cell.get("cell_type") != "code" or cell["id"] in checks:
                continue
            self.cell = cell["id"]
            report({"running": self.cell})
            error = self.ask(do="run", source=cell["source"]).get("error")
            if error:
                self.errors[self.cell] = str(error)

    def value(self, **request):
        """The value asked for, or None and False where there is none."""
        reply = self.ask(**request)
        if "error" in reply:
            raise RuntimeError(str(reply["error"]))
        if "value" not in reply:
            return None, False
        return decode(reply["value"], lambda number: Remote(self, number)), True


class Remote:
    """An object that stays in the student's process: attributes and calls go there and back."""

    def __init__(self, pupil, number):
        self._pupil, self._number = pupil, number

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        value, found = self._pupil.value(do="attribute", of=self._number, name=name)
        if not found:
            raise AttributeError(f"the student's object has no {name!r}")
        return value

    def __call__(self, *args, **keywords):
        args = encode(args, _number_of)
        keywords = {name: encode(value, _number_of) for name, value in keywords.items()}
        return self._pupil.value(do="call", of=self._number, args=args, keywords=keywords)[0]


def _number_of(value):
    if isinstance(value, Remote):
        return value._number
    raise TypeError(f"a {type(value).__name__} cannot be handed to the student's process")


def judge(original, submission, pupil, report):
    """Judge all exercises; `report` gets one dictionary per verdict and per cell begun."""
    found = paper.exercises(original)
    owner = {cell: e for e in found for cell in (*e.solutions, *e.checks)}
    places = {cell["id"]: number for number, cell in enumerate(submission["cells"])}
    checks = {cell for exercise in found for cell in exercise.checks}
    plan = slice_for_checks(original, checks)
    changes = changed_cells(original, submission)
    verdicts, outcomes = [], {}
    namespace = {"__name__": "__main__", "display": lambda *_, **__: None}
    _record_verdicts(verdicts)
    for cell in original["cells"]:
        exercise = owner.get(cell["id"])
        if cell["id"] in checks:
            outcome = run_check(plan[cell["id"]][0], namespace, verdicts)
            outcomes.setdefault(exercise.name, []).append(outcome)
            if cell["id"] == exercise.checks[-1]:
                report(row(exercise, outcomes[exercise.name], pupil, places, changes))
        elif cell["id"] in plan:
            given, names = plan[cell["id"]]
            problem = execute(given, namespace)
            if problem is not None:
                pupil.errors[f"given {cell['id']}"] = describe(problem)
            if names is not None:
                pupil.run_to(where_answered(cell["id"], exercise, places), checks, report)
                bind(names, namespace, pupil)
    for exercise in found:
        if not exercise.checks:
            report(_row(exercise, 0, "by hand", "has no check: read and mark it"))


def slice_for_checks(original, checks):
    """What the judge runs: {cell id: (source, names to ask the student for or None)}.

    Walks back from the checks and takes in each given cell that binds a name used further on; of a
    cell with a solution, what stands before the solution is given.
    """
    plan, needed = {}, set()
    for cell in reversed(original["cells"]):
        if cell.get("cell_type") != "code":
            continue
        source, names = cell["source"], None
        if cell["id"] not in checks:
            try:
                if paper.has_solution(cell):
                    source, names = paper.split(source)
                    names = [name for name in names if name in needed]
                body = ast.parse(source).body
            except SyntaxError:  # a given cell with shell or magic commands
                continue
            wanted = paper.bound(body) & needed or _imports_all(body)
            if not wanted and names is None:
                continue
            source = source if wanted else ""
        needed |= paper.used(ast.parse(source).body)
        plan[cell["id"]] = source, names
    return plan


def _imports_all(body):
    return any(
        name.name == "*" for node in body if isinstance(node, ast.ImportFrom) for name in node.names
    )


def where_answered(solution, exercise, places):
    """How far the submission must run: to its own check cell, or past its solution cell."""
    for check in exercise.checks if exercise else ():
        if check in places:
            return places[check]
    return places.get(solution, -1) + 1


def bind(names, namespace, pupil):
    for name in names:
        try:
            value, found = pupil.value(do="get", name=name)
        except (ValueError, TypeError, LookupError, ArithmeticError, RuntimeError) as problem:
            found, pupil.errors[f"answer {name}"] = False, describe(problem)
        if found:
            namespace[name] = value


def execute(source, namespace):
    """Run trusted code on the student's values; what fails shows in the check that needs it."""
    try:
        exec(compile(source, "<given>", "exec"), namespace)
    except Gone:
        raise
    except Exception as problem:
        return problem
    return None


def run_check(source, namespace, verdicts):
    """(right, reason, score) of one check cell: its verdicts, or its plain asserts."""
    verdicts.clear()
    problem = execute(source, namespace)
    if isinstance(problem, AssertionError):
        return False, str(problem) or "the check's assertion does not hold", None
    if problem is not None:
        return False, describe(problem), None
    wrong = [str(verdict.message) for verdict in verdicts if not verdict]
    says_something = verdicts or "assert" in source
    score = next((v.score for v in verdicts if getattr(v, "score", None) is not None), None)
    return not wrong and bool(says_something), "; ".join(wrong), score


def _record_verdicts(verdicts):
    """Keep what the package's check returns in this process."""
    try:
        check = pl.check
    except AttributeError:
        return

    def recording(*args, **keywords):
        verdict = check(*args, **keywords)
        verdicts.append(verdict)
        return verdict

    pl.check = recording


def changed_cells(original, submission):
    """Ids of given and check cells that the student changed or took out."""
    theirs = {cell["id"]: cell["source"] for cell in submission["cells"]}
    return [
        cell["id"]
        for cell in original["cells"]
        if cell.get("cell_type") == "code"
        and not paper.has_solution(cell)
        and paper.fingerprint(theirs.get(cell["id"], "")) != paper.fingerprint(handed_out(cell))
    ]


def handed_out(cell):
    return paper.replace(cell["source"], paper.BEGIN_HIDDEN, paper.END_HIDDEN)


def row(exercise, outcomes, pupil, places, changes):
    right = all(outcome[0] for outcome in outcomes)
    reasons = [outcome[1] for outcome in outcomes if outcome[1]]
    scores = [outcome[2] for outcome in outcomes if outcome[2] is not None]
    missing = [cell for cell in exercise.solutions if cell not in places]
    errors = [pupil.errors[cell] for cell in exercise.solutions if cell in pupil.errors]
    verdict = "right" if right else "wrong"
    if missing and not right:
        verdict, reasons = "missing", [f"cell {missing[0]} is missing"]
    elif errors and not right:
        gap = errors[0].startswith("NotImplementedError")
        verdict, reasons = ("missing", ["not attempted"]) if gap else ("wrong", [errors[0]])
    if not right:
        other = [key for key in pupil.errors if key.startswith(("answer ", "given "))]
        reasons += [f"{key}: {pupil.errors[key]}" for key in other[:2]]
    tampered = [cell for cell in exercise.checks if cell in changes]
    if tampered:
        reasons.append(f"check cell changed or missing, the original was used: {tampered[0]}")
    given = [cell for cell in changes if not paper.PART.fullmatch(cell)]
    if given and not right:
        reasons.append(f"given cells changed or missing: {', '.join(given[:3])}")
    points = exercise.points if right else 0
    return _row(exercise, points, verdict, "; ".join(reasons), scores[0] if scores else None)


def _row(exercise, points, verdict, reason, score=None):
    return {
        "exercise": exercise.name,
        "points": points,
        "max": exercise.points,
        "verdict": verdict,
        "reason": reason,
        "score": score,
    }


def main():
    task = json.loads(sys.stdin.readline())
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

    def report(message):
        replies.write(json.dumps(message) + "\n")
        replies.flush()

    adopt_orphans()
    original, submission = paper.read(task["original"]), paper.read(task["submission"])
    pupil = Pupil(submission["cells"], task["folder"], task["hidden"], Limits(**task["limits"]))
    try:
        judge(original, submission, pupil, report)
    except Gone as problem:
        report({"ended": str(problem)})
    except Exception as problem:
        report({"ended": f"could not be judged: {describe(problem)}"})
    finally:
        report({"claimed": _claims(Path(task["folder"]))})
        end(os.getpid(), head_too=False)


def _claims(folder):
    """What a notebook wrote for the leaderboard; shown beside the recomputed score, never used."""
    path = folder / "leaderboard.json"
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > 10_000:
            return None
        return float(json.loads(path.read_bytes())["score"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


if __name__ == "__main__":
    main()
