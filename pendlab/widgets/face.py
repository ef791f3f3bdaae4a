"""What the browser shows of a panel: native controls, picture, verdict and words, as one widget.

One script instead of a widget for each slider and label: a panel opens with one message and moves with
one each way. The controls are the browser's own, so they have names, spoken values, a visible focus
and keys; positions of sliders are whole numbers, so nothing that the browser rounds comes back.
"""

from pathlib import Path

import anywidget
import traitlets

HERE = Path(__file__).parent
KEYS = (
    "Keyboard: Tab to a control; arrow keys, Page Up and Page Down, Home and End move a slider. ▲ marks "
    "where it starts; a short line a power of ten."
)


class Face(anywidget.AnyWidget):
    """One panel in the page.

    Attributes
    ----------
    face : what stays: title, groups of controls, buttons, legend
    state : what the kernel says: values, verdict, words, table; it alone writes it
    picture, beside : PNG, and HTML such as a moving drawing
    hand : what a hand did: a position, a text, a button; the browser alone writes it
    """

    _esm = (HERE / "face.js").read_text(encoding="utf-8")
    _css = (HERE / "face.css").read_text(encoding="utf-8")
    face = traitlets.Dict().tag(sync=True)
    state = traitlets.Dict().tag(sync=True)
    picture = traitlets.Bytes(b"").tag(sync=True)
    beside = traitlets.Unicode("").tag(sync=True)
    hand = traitlets.Dict().tag(sync=True)

    def close(self):
        """Close the widget with the layout that belongs to it."""
        self.layout.close()
        super().close()


def running_cell():
    """What tells the running notebook cell from others: its id, or its text where none is sent."""
    try:
        from IPython import get_ipython

        shell = get_ipython()
        return shell.get_parent()["metadata"].get("cellId") or shell.user_ns["In"][-1]
    except (ImportError, AttributeError, KeyError, IndexError, TypeError):
        return None
