"""The widgets of the notebooks: thin layers of controls round tested figures, one function each."""

from .bench import bench_panel
from .designs import kp_panel, observer_panel, triple_panel, weights_panel
from .models import bar_panel, sampling_panel

__all__ = [
    "bar_panel",
    "bench_panel",
    "kp_panel",
    "observer_panel",
    "sampling_panel",
    "triple_panel",
    "weights_panel",
]
