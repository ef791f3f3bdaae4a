"""``python -m pendlab``: recompute the paper without a screen."""

import argparse
import sys
from importlib import import_module
from pathlib import Path

from . import __version__
from .classroom.files import command, writable

# Modules that offer commands, by ``add_commands(commands)``.
COMMANDS = (
    "classroom.doctor",
    "classroom.release",
    "classroom.course",
    "classroom.leaderboard",
    "classroom.bundle",
)


def main(arguments=None):
    """Run one command; the exit code is 0 unless something that should hold does not."""
    parser = argparse.ArgumentParser(
        prog="python -m pendlab",
        description="Without a command: the report. `COMMAND --help` tells more of each.",
    )
    parser.add_argument("--version", action="version", version=f"pendlab {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    add_own(commands)
    for name in COMMANDS:
        import_module(f".{name}", __package__).add_commands(commands)
    parser.set_defaults(run=report, folder=Path("pendlab-report"))
    options = parser.parse_args(arguments)
    try:
        return options.run(options)
    except ModuleNotFoundError as problem:
        if str(problem.name).split(".")[0] == "pendlab":
            raise
        reason = f"{options.command} needs the package {problem.name}: pip install {problem.name}"
    except (ValueError, OSError) as problem:
        reason = problem
    print(f"pendlab: {reason}", file=sys.stderr)
    return 2


def add_own(commands):
    """The commands of this module."""
    about = "Every printed number recomputed, and all figures (the default command)."
    command(commands, "report", report, about, "--folder figures", folder="figures")
    about = "The pendulums to touch: a page for each rig, for any browser."
    parser = command(commands, "live", live, about, "--folder pendlab-live", folder="pages")
    parser.description = (
        "Writes one HTML page for each rig: the simulated pendulum, live, to push and pull. "
        "It needs no network and no Python: open it, project it, or send it to a phone."
    )
    about = "Compile the simulator for the rigs, so that nobody waits for it in class."
    parser = command(commands, "warm", warm, about, "/srv/pendlab-seed")
    parser.add_argument(
        "folder",
        nargs="?",
        metavar="DIR",
        type=Path,
        help="where to keep it, to be the PENDLAB_SEED of a class (default: your own cache)",
    )


def live(options):
    """A page for each of the paper's rigs."""
    from .widgets.live import live_rig

    writable("folder", options.folder).mkdir(parents=True, exist_ok=True)
    for name in ("double", "triple"):
        page = options.folder / f"{name}.html"
        page.write_text(str(live_rig(name)), encoding="utf-8")
        print(page)
    return 0


def warm(options):
    """Compiled kernels of the paper's rigs in a folder."""
    from .bench.warm import warm
    from .parameters import load

    for path in warm([load("double"), load("triple")], options.folder):
        print(path)
    return 0


def report(options):
    """Scoreboard on the screen, figures as PNG and SVG in a folder."""
    from .figures import figure, numbers, save
    from .figures.moving import animate_svg
    from .paper.experiment import bench_run
    from .paper.scoreboard import DIFFERS, scoreboard

    writable("folder", options.folder)
    print("Recomputing every printed number ...", flush=True)
    board = scoreboard()
    print(board, flush=True)
    print()
    for number in numbers():
        drawn = figure(number)
        save(drawn, options.folder, f"fig{number:02d}")
        print(f"{number} of {max(numbers())}  {drawn.caption}", flush=True)
    run = bench_run("triple", 12.0)
    moving = animate_svg(run.rig, run.t, run.angles, width=420, height=340)
    (options.folder / "bench.svg").write_text(moving, encoding="utf-8")
    print(f"\nFigures are in {options.folder.resolve()} as PNG and SVG, and bench.svg moves.")
    wrong = board.totals[DIFFERS]
    if wrong:
        print(f"{wrong} printed numbers that should hold do not: see {DIFFERS} above.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
