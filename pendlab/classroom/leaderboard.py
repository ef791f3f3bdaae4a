"""The leaderboard of homework 9: the contest played again for every class that was handed in.

    python -m pendlab leaderboard submitted --season 2

Each notebook's class ``Mine`` runs in a process of its own, with bounded memory and time, and shut in
where that can be had (`confined`). Scores are rounded to a tenth, less than which two machines may
differ by chaos alone; equal ones share a rank. The score that a student claims stands beside it.
"""

import contextlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from . import confined, gaps
from .files import command

CLASS = "Mine"


@dataclass(frozen=True)
class Entry:
    """One hand-in: who, the score played again, the claim, and why there is no score."""

    who: str
    score: float = 0.0
    claim: float | None = None
    falls: int | None = None
    reason: str | None = None


def leaderboard(folder, season=1, seconds=300):
    """Entries of all notebooks below a folder that define ``Mine``, the best first."""
    from .._arguments import number, whole  # here: the commands load with nothing but Python

    whole("season", season)
    number("seconds", seconds, least=1)
    folder = Path(folder)
    folder = folder / "submitted" if (folder / "submitted").is_dir() else folder
    paths = [p for p in sorted(folder.rglob("*.ipynb")) if ".ipynb_checkpoints" not in p.parts]
    found = [(path, _code(path)) for path in paths]
    found = [(path, code) for path, code in found if code is not None]
    if not found:
        raise ValueError(f"DIR: no notebook below {str(folder)!r} defines a class {CLASS}.")
    entries = []
    for count, (path, code) in enumerate(found, 1):
        who = path.relative_to(folder).parts[0].removesuffix(".ipynb")
        print(f"{count} of {len(found)}: {who}", file=sys.stderr, flush=True)
        entries.append(Entry(who, claim=_claim(path), **_play(code, season, seconds)))
    return sorted(entries, key=_place)


def _place(entry):
    return entry.reason is not None, -entry.score, entry.who


def _code(path):
    """Code cells up to the last one that makes the class; None where none does or it is no notebook."""
    import nbformat

    try:
        code = [c.source for c in nbformat.read(path, as_version=4).cells if c.cell_type == "code"]
    except Exception:  # whatever was handed in there
        return None
    cells = [_plain(source) for source in code if "pl.check(" not in source]
    makes = [k for k, source in enumerate(cells) if CLASS in gaps.names(source)[1]]
    return cells[: makes[-1] + 1] if makes else None


def _plain(source):
    """Python without IPython's magics."""
    return "\n".join(line for line in source.splitlines() if line.lstrip()[:1] not in ("%", "!"))


def _claim(path):
    """The score in the leaderboard.json beside a notebook, or None."""
    try:
        claim = json.loads((path.parent / "leaderboard.json").read_text(encoding="utf-8"))
        return round(float(claim["score"]), 1)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _play(code, season, seconds):
    """What the process of one class answers, as fields of an `Entry`."""
    line = [sys.executable, "-m", __name__]
    if confined.available():
        line = confined.command(line, Path("/usr"))
    work = json.dumps({"code": code, "season": season})
    try:
        done = subprocess.run(
            line, input=work, capture_output=True, text=True, timeout=seconds, check=False
        )
        answer = json.loads(done.stdout)
        return {name: answer[name] for name in ("score", "falls", "reason")}
    except subprocess.TimeoutExpired:
        return {"reason": f"longer than {seconds:g} s"}
    except (ValueError, KeyError, TypeError):
        return {"reason": "its process ended without a score"}


def _worker():
    """Run the cells, play the contest, answer on what was standard output."""
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what the cells print goes where nobody reads it
    confined.limit()
    work, names = json.load(sys.stdin), {"__name__": "__main__"}
    for source in work["code"]:
        with contextlib.suppress(Exception):  # a cell before the class may fail
            exec(source, names)
    if not callable(names.get(CLASS)):  # a gap, or nothing
        result = {"score": 0.0, "falls": None, "reason": f"no class {CLASS} came out of its cells"}
    else:
        from .contest import contest

        score = contest(names[CLASS], season=work["season"])
        result = {"score": round(score.total, 1), "falls": score.falls, "reason": score.reason}
    json.dump(result, answer)


def table(entries):
    """The entries as lines of text, ranked."""
    lines = ["rank  score  claim  falls  who"]
    for entry in entries:
        rank = 1 + sum(e.reason is None and e.score > entry.score for e in entries)
        rank = "-" if entry.reason else rank
        shown = ["-" if value is None else value for value in (entry.claim, entry.falls)]
        note = f"  ({entry.reason})" if entry.reason else ""
        lines.append(
            f"{rank:>4}  {entry.score:5.1f}  {shown[0]:>5}  {shown[1]:>5}  {entry.who}{note}"
        )
    return "\n".join(lines)


def add_commands(commands):
    about = "The contest of homework 9, played again for every class that was handed in."
    parser = command(commands, "leaderboard", _run, about, "submitted --season 2")
    parser.add_argument("folder", type=Path, metavar="DIR", help="hand-ins, a folder for each")
    parser.add_argument(
        "--season", type=int, default=1, help="of the contest (default: %(default)s)"
    )
    parser.add_argument(
        "--seconds", type=float, default=300, help="for each class (default: %(default)s)"
    )


def _run(options):
    print(table(leaderboard(options.folder, options.season, options.seconds)))
    return 0


if __name__ == "__main__":
    _worker()
