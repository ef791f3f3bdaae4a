"""Benchmark of the widgets: ``python tests/benchmarks/widgets.py``.

Python's time from slider event to picture, for the first slider of each widget and, parted, for
design and words, drawing, and PNG. The kept background is compared with drawing the whole figure in
this one run; goals are those of a page of panels (60 ms), of k_p (20 ms) and of a simulation (100 ms).
"""

import time

import numpy as np

import pendlab as pl
from pendlab.figures.picture import Picture, png_bytes

WIDGETS = {  # maker, goal in ms
    "kp_panel()": (pl.kp_panel, 20),
    'weights_panel("double")': (lambda: pl.weights_panel("double"), 60),
    'weights_panel("triple")': (lambda: pl.weights_panel("triple"), 60),
    'observer_panel("double")': (lambda: pl.observer_panel("double"), 60),
    'observer_panel("triple")': (lambda: pl.observer_panel("triple"), 60),
    "triple_panel()": (pl.triple_panel, 100),
    'bench_panel("double")': (lambda: pl.bench_panel("double"), 100),
    'bench_panel("triple")': (lambda: pl.bench_panel("triple"), 100),
    "bar_panel()": (pl.bar_panel, 60),
    "sampling_panel()": (pl.sampling_panel, 60),
}


def median(function, repeats=9):
    """Median of several calls: wall-clock time and this process's own, ms."""
    times = []
    for _ in range(repeats):
        wall, own = time.perf_counter(), time.process_time()
        function()
        times.append((time.perf_counter() - wall, time.process_time() - own))
    return 1e3 * np.median(times, axis=0)


def mover(panel):
    """A function that moves the panel's first slider two positions, and back, as a hand would."""
    name, control = next(
        (name, c) for name, c in panel.controls.items() if isinstance(c, pl.Slider)
    )
    here = control.position_of(panel.values[name])
    there = here + 2 if here + 2 <= control.last else here - 2
    count = 0

    def move():
        nonlocal count
        count += 1
        panel._widget.hand = {
            "name": name,
            "position": there if count % 2 else here,
            "count": count,
        }

    return move


def parts(panel):
    """Own time of computing with its words, of drawing on the background, of PNG, and of all anew."""
    picture = panel._picture
    compute = median(lambda: panel.view.update(**panel.values))[1]
    both = median(picture.png)[1]
    pixels = np.asarray(picture.figure.canvas.buffer_rgba())[:, :, :3]
    encode = median(lambda: png_bytes(pixels))[1]
    for artist in picture.moving:
        artist.set_animated(False)
    whole = median(Picture(picture.figure).png)[1]
    return compute, both - encode, encode, whole / both


def main():
    print(
        f"{'':26s}{'goal':>6s}{'wall':>8s}{'own':>8s}   own time: compute  draw   PNG   whole/kept"
    )
    for call, (make, goal) in WIDGETS.items():
        panel = make()
        wall, own = median(mover(panel))
        compute, draw, encode, ratio = parts(panel)
        mark = "" if wall <= goal else "  over its goal"
        print(f"{call:26s}{goal:6d}{wall:8.1f}{own:8.1f}{compute:18.1f}{draw:8.1f}{encode:6.1f}{ratio:10.1f} x"
              f"{mark}")  # fmt: skip
        panel.close()
    print(
        "ms; goals are for wall-clock time on an idle machine; own time is that of all threads of this program"
    )


if __name__ == "__main__":
    main()
