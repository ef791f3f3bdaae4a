"""``python -m pendlab``: recompute the paper without a screen."""

import argparse
import sys
from importlib import import_module
from pathlib import Path

from . import __version__

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
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=Command)
    add_report(commands)
    add_live(commands)
    add_warm(commands)
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


class Command(argparse.ArgumentParser):
    """A command's parser, whose help ends with an example."""

    def __init__(self, epilog=None, **options):
        shown = f"example:\n  {epilog}" if epilog else None
        kind = argparse.RawDescriptionHelpFormatter
        super().__init__(epilog=shown, formatter_class=kind, **options)


def add_report(commands):
    about = "Every printed number recomputed, and all figures (the default command)."
    example = "python -m pendlab report --folder figures"
    parser = commands.add_parser("report", help=about, description=about, epilog=example)
    parser.add_argument(
        "--folder",
        type=Path,
        default=Path("pendlab-report"),
        help="where the figures go (default: %(default)s)",
    )
    parser.set_defaults(run=report)


def add_live(commands):
    parser = commands.add_parser(
        "live",
        help="The pendulums to touch: a page for each rig, for any browser.",
        epilog="python -m pendlab live --folder pendlab-live",
        description="Writes one HTML page for each rig: the simulated pendulum, live, to push and "
        "pull. It needs no network and no Python: open it, project it, or send it to a phone.",
    )
    parser.add_argument(
        "--folder",
        type=Path,
        default=Path("pendlab-live"),
        help="where the pages go (default: %(default)s)",
    )
    parser.set_defaults(run=live)


def live(options):
    """A page for each of the paper's rigs."""
    from .classroom.files import writable
    from .widgets.live import live_rig

    writable("folder", options.folder).mkdir(parents=True, exist_ok=True)
    for name in ("double", "triple"):
        page = options.folder / f"{name}.html"
        page.write_text(str(live_rig(name)), encoding="utf-8")
        print(page)
    return 0


def add_warm(commands):
    about = "Compile the simulator for the rigs, so that nobody waits for it in class."
    example = "python -m pendlab warm /srv/pendlab-seed"
    parser = commands.add_parser("warm", help=about, description=about, epilog=example)
    parser.add_argument(
        "folder",
        nargs="?",
        metavar="DIR",
        type=Path,
        help="where to keep it, to be the PENDLAB_SEED of a class (default: your own cache)",
    )
    parser.set_defaults(run=warm)


def warm(options):
    """Compiled kernels of the paper's rigs in a folder."""
    from .bench.warm import warm
    from .parameters import load

    for path in warm([load("double"), load("triple")], options.folder):
        print(path)
    return 0


def report(options):
    """Scoreboard on the screen, figures as PNG and SVG in a folder."""
    from .classroom.files import writable
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
