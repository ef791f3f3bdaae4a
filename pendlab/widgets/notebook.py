"""What a panel needs to know of its notebook: cells, callbacks that hold nothing, closing."""

from weakref import WeakMethod

KEYS = (
    "Keyboard: Tab to a control; arrow keys, Page Up and Page Down, Home and End move a slider. ▲ marks "
    "where it starts; a short line a power of ten."
)


def weakly(method):
    """`method(event)` as a callback that does not keep the panel alive."""
    reference = WeakMethod(method)

    def called(event=None):
        method = reference()
        if method is not None:
            method(event)

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
    """Close a widget with the layout that belongs to it."""
    for part in (widget.layout, widget):
        part.close()
