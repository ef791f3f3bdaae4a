"""Run, store and check one notebook: ``python tests/try_notebook.py notebooks/own/my_pendulum.ipynb``.

Executed from a fresh kernel and stored, then run again with its outputs compared, then asked what the
tests ask of every notebook: nothing silenced, links that lead somewhere, public names alone, short
cells, complete exercises, numbers in the text that stand in an output. Other notebooks are left alone.
"""

import sys
from pathlib import Path

import pytest
from refresh_notebooks import ROOT, refresh

ASKED = ("test_notebooks.py", "test_exercise_cells.py", "test_prose.py")


def main(path):
    refresh(path)
    tests = [str(ROOT / "tests" / name) for name in ASKED]
    return pytest.main(
        ["-q", "-n", "0", "--rootdir", str(ROOT), str(path), *tests, "-k", path.stem]
    )


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_file():
        sys.exit("usage: python tests/try_notebook.py notebooks/own/my_pendulum.ipynb")
    sys.exit(main(Path(sys.argv[1]).resolve()))
