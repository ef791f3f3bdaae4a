"""Write the minutes of the lab sheets' steps wherever a total stands: ``python tests/refresh_minutes.py``.

The table of steps of each sheet in notebooks/labs is the one place where minutes are planned; a test
holds them to what ``minutes.py`` counts. Totals on the sheet, in the course map, in the paths, on the
start page and in the notebooks' titles follow, and so do the minutes of optional stretches.
"""

import re

import nbformat
from minutes import HEADING, LABS, NOTEBOOKS, OPTIONAL, at_home, optional, planned, stretches


def minutes():
    """Minutes of each step of each sheet, by the sheet's stem."""
    return {
        path.stem: {k: m for part in _parts(path.stem) for k, m in part.items()}
        for path in sorted(LABS.glob("*_*.md"))
    }


def _sheet(stem):
    return (LABS / f"{stem}.md").read_text(encoding="utf-8")


def _parts(stem):
    return planned(_sheet(stem))


def total(stem):
    """Minutes of a sheet as text, the parts of a long notebook one by one: ``70 + 75``."""
    return " + ".join(str(sum(part.values())) for part in _parts(stem))


def refreshed():
    """(file, new text) for every file that tells minutes."""
    steps = minutes()
    for stem in steps:
        notebook = nbformat.read(NOTEBOOKS / f"{stem}.ipynb", as_version=4)
        beside = dict(optional(notebook))
        yield LABS / f"{stem}.md", _told(_sheet(stem), stem, beside)
        for cell in notebook.cells:
            if cell.cell_type == "markdown":
                cell.source = _retitled(cell.source, beside)
            if cell.id == "00-map-text":
                cell.source = re.sub(
                    r"\((\w+)\.ipynb\)(.*\| )[\d +]+ \|",
                    lambda row: f"({row[1]}.ipynb){row[2]}{total(row[1])} |",
                    cell.source,
                )
        title = notebook.cells[0]
        title.source = re.sub(
            r"(\*\*Time:?\*\* )[^.\n]*\.",
            rf"\g<1>{_time(stem, notebook, beside)}.",
            title.source,
        )
        yield NOTEBOOKS / f"{stem}.ipynb", nbformat.writes(notebook) + "\n"
    yield LABS / "README.md", _kit((LABS / "README.md").read_text(encoding="utf-8"), steps)


def _time(stem, notebook, beside):
    """The line about time in a notebook's title."""
    parts = total(stem).split(" + ")
    session = f"{parts[0]} minutes in class"
    if len(parts) > 1:
        session = f"{', '.join(parts[:-1])} and {parts[-1]} minutes for {len(parts)} parts in class"
    known = {k: m for stretch in stretches(notebook) for k, m in stretch.exercises.items()}
    home = sum(known[k] for k in at_home(_sheet(stem)))
    more = f", {sum(beside.values())} for optional stretches" if beside else ""
    return session + more + (f", {home} for exercises at home" if home else "")


def _retitled(source, beside):
    """Markdown with the minutes of each optional stretch in its heading."""

    def heading(line):
        name = OPTIONAL.sub("", line[2])
        return f"{line[1]} {name} (optional, {beside[name]} min)" if name in beside else line[0]

    return HEADING.sub(heading, source)


def _told(text, stem, beside):
    """A sheet with its total and the list of optional stretches below its steps."""
    text = re.sub(r"\*\*Total: [\d +]+ minutes\*\*", f"**Total: {total(stem)} minutes**", text)
    text = re.sub(r"^Optional: .*\n\n", "", text, flags=re.M)
    if not beside:
        return text
    listed = "; ".join(f"{heading} ({time} min)" for heading, time in beside.items())
    return text.replace("\n## Checkpoints\n", f"\nOptional: {listed}.\n\n## Checkpoints\n")


def _kit(text, steps):
    stems = {stem.split("_")[0]: stem for stem in steps}

    def spent(row):
        parts = re.findall(r"(\w+) steps (\d+)-(\d+)", row[2])
        time = sum(
            time
            for unit, first, last in parts
            for k, time in steps[stems[unit]].items()
            if int(first) <= k <= int(last)
        )
        return f"{row[1]}{row[2]} | {time} |"

    text = re.sub(
        r"(\]\((\w+)\.md\) \| [^|]+\| )[\d +]+ \|", lambda r: f"{r[1]}{total(r[2])} |", text
    )
    return re.sub(r"^(\| \d+ \| )(\w+ steps [^|]+?) \| \d+ \|", spent, text, flags=re.M)


def main():
    for path, text in refreshed():
        if text != path.read_text(encoding="utf-8"):
            path.write_text(text, encoding="utf-8")
            print(path.name)


if __name__ == "__main__":
    main()
