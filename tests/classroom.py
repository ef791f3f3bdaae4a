"""A small solved notebook and what students make of it, for the tests of the classroom's tools."""

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

NOTES = {"exercise": "90.1", "minutes": 5, "points": 3}
MARKING = {
    "90.1": {"mistakes": ["forgets the factor"]},
    "90.3": {
        "criteria": ["names the cause"],
        "full": "It rubs.",
        "half": "Something is lost.",
        "none": "It is so.",
    },
}
SOLUTION = {"jupyter": {"source_hidden": True}, "tags": ["solution"]}


def original():
    """Three exercises: a number that a given cell uses further on, a function, a text."""
    return new_notebook(
        metadata={
            "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
            "language_info": {"name": "python"},
        },
        cells=[
            new_markdown_cell("# Small\n\nThe gain is $k = 2$.", id="90-title"),
            new_code_cell("import numpy as np\nk = 2.0", id="90-given"),
            new_markdown_cell("### Exercise 1", id="90-ex1-task", metadata={"pendlab": NOTES}),
            new_code_cell(
                "offset = 1.0\n### BEGIN SOLUTION\nanswer = k * 3\nrow = np.array([answer, 1j])\n"
                "### END SOLUTION",
                id="90-ex1-solution",
                metadata=SOLUTION,
                outputs=[nbformat.v4.new_output("stream", text="secret\n")],
            ),
            new_code_cell("doubled = 2 * np.asarray(answer) + 0 * offset", id="90-between"),
            new_code_cell(
                "assert abs(doubled - 12) < 1e-9, 'hint: the gain multiplies'\n"
                "### BEGIN HIDDEN TESTS\nassert row.shape == (2,), 'hint: two entries'\n"
                "### END HIDDEN TESTS",
                id="90-ex1-check",
                metadata={"tags": ["check"]},
            ),
            new_markdown_cell("### Exercise 2", id="90-ex2-task"),
            new_code_cell(
                "def square(x):\n    ### BEGIN SOLUTION\n    return x * x\n    ### END SOLUTION",
                id="90-ex2-solution",
                metadata=SOLUTION,
            ),
            new_code_cell(
                "assert square(7) == 49, 'hint: times itself'",
                id="90-ex2-check",
                metadata={"tags": ["check"]},
            ),
            new_markdown_cell("### Exercise 3: why?", id="90-ex3-task"),
            new_markdown_cell(
                "<!-- BEGIN SOLUTION -->\nBecause of friction.\n<!-- END SOLUTION -->",
                id="90-ex3-solution",
            ),
        ],
    )


def write(notebook, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    text = notebook if isinstance(notebook, str) else nbformat.writes(notebook)
    path.write_text(text, encoding="utf-8")
    return path
