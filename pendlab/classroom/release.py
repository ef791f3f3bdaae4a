"""Commands that write a solved notebook anew: for students, for teachers, and on paper."""

import sys
from pathlib import Path

from . import exercises as paper
from .editions import lab_sheet, student, teacher, without_results, without_solutions
from .files import as_text, command, opened, plan

ABOUT = {
    "student": "Notebooks with gaps in place of solutions, checks kept, outputs cleared.",
    "teacher": "Notebooks with solutions in sight, minutes, marking notes and the lab sheet on top.",
    "handout": "Pages to print that need no network, with gaps in place of solutions.",
}


def add_commands(commands):
    for name, about in ABOUT.items():
        example = f"notebooks --folder pendlab-{name}" + " --pdf" * (name == "handout")
        parser = command(commands, name, _run, about, example, folder="files")
        parser.set_defaults(edition=name)
        parser.add_argument(
            "notebooks",
            nargs="*",
            type=Path,
            default=[Path("notebooks")],
            help="notebooks, or folders that stand for all in them (default: notebooks)",
        )
    for option, what in (
        ("--solutions", "keep solutions, and what they print (default: gaps)"),
        ("--no-results", "leave out what cells show, to predict it first (default: shown)"),
        ("--pdf", "PDF beside each page, with Chromium (default: HTML alone)"),
    ):
        parser.add_argument(option, action="store_true", help=what)  # of handout, the last one


def _run(options):
    """All editions are made before the first is written, so that a refusal leaves nothing half done."""
    write = _notebook
    if options.edition == "handout":
        from . import handout  # noqa: F401, a package that it lacks is named before the work

        write = _page
    pairs = plan(options.notebooks, options.folder, ".html" if write is _page else ".ipynb")
    made = [(_edition(options, path, opened(path)), path, target) for path, target in pairs]
    for number, (edition, path, target) in enumerate(made, 1):
        target.parent.mkdir(parents=True, exist_ok=True)
        write(options, edition, path, target)
        print(f"{number} of {len(made)}  {target}", flush=True)
    return 0


def _edition(options, path, notebook):
    if options.edition == "student":
        return student(notebook)
    if options.edition == "teacher":
        return teacher(notebook, lab_sheet(path), paper.marking(path))
    edition = notebook if options.solutions else without_solutions(notebook)
    return without_results(edition) if options.no_results else edition


def _notebook(options, edition, path, target):
    target.write_text(as_text(edition), encoding="utf-8")


def _page(options, edition, path, target):
    from . import handout

    target.write_text(handout.html(edition, path), encoding="utf-8")
    if options.pdf and not handout.pdf(target):
        print("No Chromium was found: open the HTML page and print it.", file=sys.stderr)
        options.pdf = False
