"""Commands that write a solved notebook anew: for students, for teachers, and on paper."""

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
    """All is made before the first file is written, so that a refusal leaves nothing half done."""
    end = ".html" if options.edition == "handout" else ".ipynb"
    pairs = plan(options.notebooks, options.folder, end)
    made = [(_text(options, path), target) for path, target in pairs]
    for number, (text, target) in enumerate(made, 1):
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
        print(f"{number} of {len(made)}  {target}", flush=True)
        if options.edition == "handout" and options.pdf:
            from .handout import pdf

            options.pdf = pdf(target)
    return 0


def _text(options, path):
    """The edition of one notebook as the text of its file."""
    if options.edition == "handout":
        from .handout import html  # first, so that a package that it lacks is named
    notebook = opened(path)
    if options.edition == "student":
        return as_text(student(notebook))
    if options.edition == "teacher":
        return as_text(teacher(notebook, lab_sheet(path), paper.marking(path)))
    edition = notebook if options.solutions else without_solutions(notebook)
    return html(without_results(edition) if options.no_results else edition, path)
