"""Write the minutes of the lab sheets' steps wherever a total stands: ``python tests/refresh_minutes.py``.

The table of steps of each sheet in notebooks/labs is the one place where minutes are planned. Totals on
the sheet, in the course map, in the paths, on the start page and in the notebooks' titles follow.
"""

import re
from pathlib import Path

import nbformat

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
LABS = NOTEBOOKS / "labs"
STEP = re.compile(r"^\| (\d+) \| (\d+) \| ", re.M)


def minutes():
    """Minutes of each step of each sheet, by the sheet's stem."""
    return {
        path.stem: {int(k): int(m) for k, m in STEP.findall(path.read_text(encoding="utf-8"))}
        for path in sorted(LABS.glob("*_*.md"))
    }


def refreshed():
    """(file, new text) for every file that tells minutes."""
    steps = minutes()
    total = {stem: sum(times.values()) for stem, times in steps.items()}
    for stem in steps:
        path = LABS / f"{stem}.md"
        text = path.read_text(encoding="utf-8")
        yield path, re.sub(r"\*\*Total: \d+ minutes\*\*", f"**Total: {total[stem]} minutes**", text)
        notebook = nbformat.read(NOTEBOOKS / f"{stem}.ipynb", as_version=4)
        title = notebook.cells[0]
        title.source = re.sub(r"(Time\W+)\d+ minutes", rf"\g<1>{total[stem]} minutes", title.source)
        for cell in notebook.cells:
            if cell.id == "00-map-text":
                cell.source = re.sub(
                    r"\((\w+)\.ipynb\)(.*\| )\d+ \|",
                    lambda row: f"({row[1]}.ipynb){row[2]}{total[row[1]]} |",
                    cell.source,
                )
        yield NOTEBOOKS / f"{stem}.ipynb", nbformat.writes(notebook) + "\n"
    yield LABS / "README.md", _kit((LABS / "README.md").read_text(encoding="utf-8"), steps, total)


def _kit(text, steps, total):
    stems = {stem.split("_")[0]: stem for stem in steps}

    def planned(row):
        parts = re.findall(r"(\w+) steps (\d+)-(\d+)", row[2])
        spent = sum(
            time
            for unit, first, last in parts
            for k, time in steps[stems[unit]].items()
            if int(first) <= k <= int(last)
        )
        return f"{row[1]}{row[2]} | {spent} |"

    text = re.sub(r"(\]\((\w+)\.md\) \| [^|]+\| )\d+ \|", lambda r: f"{r[1]}{total[r[2]]} |", text)
    return re.sub(r"^(\| \d+ \| )(\w+ steps [^|]+?) \| \d+ \|", planned, text, flags=re.M)


def main():
    for path, text in refreshed():
        if text != path.read_text(encoding="utf-8"):
            path.write_text(text, encoding="utf-8")
            print(path.name)


if __name__ == "__main__":
    main()
