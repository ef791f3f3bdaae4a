"""What a panel needs to know of its notebook: cells, callbacks that hold nothing, closing, legends."""

from html import escape
from weakref import WeakMethod


def weakly(method, name):
    """`method(name, event)` as a callback that does not keep the panel alive."""
    reference = WeakMethod(method)

    def called(event):
        method = reference()
        if method is not None:
            method(name, event)

    return called


def running_cell():
    """What tells the running notebook cell from others: its id, or its text where none is sent."""
    try:
        from IPython import get_ipython

        shell = get_ipython()
        return shell.get_parent()["metadata"].get("cellId") or shell.user_ns["In"][-1]
    except (ImportError, AttributeError, KeyError, IndexError, TypeError):
        return None


def close_all(widget):
    """Close a widget with all that belongs to it: children, layouts, styles."""
    for child in getattr(widget, "children", ()):
        close_all(child)
    for part in (getattr(widget, "style", None), widget.layout, widget):
        if part is not None:
            part.close()


def legend_html(lines):
    if not lines:
        return ""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    keys = "Keyboard: Tab to a control; arrow keys, Page Up and Page Down move a slider."
    return f"<details><summary>What is what</summary><ul>{items}<li>{keys}</li></ul></details>"
