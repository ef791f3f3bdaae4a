"""Execute notebooks and store their outputs: the one way in which stored outputs are made.

    python tests/refresh_notebooks.py                     all of notebooks/
    python tests/refresh_notebooks.py notebooks/02*.ipynb some of them

Each runs in a fresh kernel; an error stops with the cell's message and leaves the file as it was.
What changes from run to run (timing, widget state, ids) is dropped, so that diffs stay small.
"""

import re
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from pendlab.classroom.editions import stamp

ROOT = Path(__file__).parent.parent
MARK = re.compile("pendlab-[0-9a-f]{8}")
WIDGET_VIEW = "application/vnd.jupyter.widget-view+json"


def notebooks():
    """All notebooks of the series, in order."""
    found = (ROOT / "notebooks").rglob("*.ipynb")
    return sorted(path for path in found if ".ipynb_checkpoints" not in path.parts)


def refresh(path):
    """Execute one notebook in its folder and write it back; True if the file changed."""
    before = path.read_text(encoding="utf-8")
    notebook = nbformat.reads(before, as_version=4)
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    NotebookClient(
        notebook,
        timeout=300,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(path.parent)}},
    ).execute()
    settle(notebook)
    after = nbformat.writes(notebook) + "\n"
    path.write_text(after, encoding="utf-8")
    return after != before


def settle(notebook):
    """Drop what differs from run to run, and join the pieces in which a stream arrived."""
    notebook.metadata.pop("widgets", None)
    notebook.metadata["kernelspec"] = {
        "display_name": "Python 3 (ipykernel)",
        "language": "python",
        "name": "python3",
    }
    notebook.metadata["language_info"] = {"name": "python"}
    stamp(notebook)  # nbgrader's metadata on exercise cells
    for number, cell in enumerate(c for c in notebook.cells if c.cell_type == "code"):
        cell.execution_count = number + 1
        cell.outputs = joined(cell.outputs)
        for output in cell.outputs:
            if output.output_type == "execute_result":
                output.execution_count = number + 1
            # A live panel means nothing in a file; the picture that stands beside it stays.
            output.get("data", {}).pop(WIDGET_VIEW, None)
            if "text/html" in output.get("data", {}):
                output.data["text/html"] = MARK.sub("pendlab-00000000", output.data["text/html"])


def joined(outputs):
    """Outputs with the pieces of one stream that follow each other put together."""
    result = []
    for output in outputs:
        last = result[-1] if result else {}
        if output.output_type == "stream" and last.get("name") == output.name:
            last.text += output.text
        else:
            result.append(output)
    return result


def main(arguments):
    paths = [Path(argument).resolve() for argument in arguments] or notebooks()
    for path in paths:
        print(f"{path.name} ... ", end="", flush=True)
        print("changed" if refresh(path) else "unchanged")


if __name__ == "__main__":
    main(sys.argv[1:])
