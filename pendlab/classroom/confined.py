"""A process that sees little and may do little: Linux with bubblewrap.

What is bound below is all that it finds on the disk: the system, Python, this package and one
folder, all read-only. No home, no other hand-in, no solutions, no network; an own temporary folder;
bounded memory, files and processor time. ``python -m pendlab.classroom.confined FILE`` is the
kernel of a course made with ``course --confined``, FILE its connection file.
"""

import functools
import json
import os
import shutil
import site
import subprocess
import sys
from pathlib import Path

MEMORY, FILES, SECONDS = 4 << 30, 64 << 20, 600  # bytes for each process and file; of a processor
OWN = "/tmp/own"  # the only folder to write to, gone with the process
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/sbin", "/etc/ld.so.cache", "/etc/fonts")
SYSTEM += ("/etc/alternatives", "/etc/localtime", "/etc/passwd")
KEPT = ("LANG", "NBGRADER_EXECUTION", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")


@functools.cache
def available():
    """Whether this machine confines: bubblewrap is there, and the system lets it work."""
    if not (sys.platform == "linux" and shutil.which("bwrap")):
        return False
    tried = subprocess.run([*command(["true"], Path("/usr"))], capture_output=True, check=False)
    return tried.returncode == 0


def command(arguments, folder, writable=(), readable=()):
    """The arguments, run by bubblewrap in a folder; `writable` folders are shared with the world."""
    from ..bench.cache import cache_folders

    binds = [part for path in SYSTEM for part in ("--ro-bind-try", path, path)]
    binds += ["--proc", "/proc", "--dev", "/dev", "--tmpfs", "/tmp", "--size", str(4 * FILES)]
    binds += ["--tmpfs", OWN]
    caches = [path for path in cache_folders() if path.is_dir()][:1]
    for path in [*_python(), *caches, *readable, folder]:
        binds += ["--ro-bind", str(path), str(path)]
    for path in writable:
        binds += ["--bind", str(path), str(path)]
    binds += ["--remount-ro", "/tmp", "--remount-ro", "/"]
    variables = {name: os.environ[name] for name in KEPT if name in os.environ}
    variables |= {
        "PATH": "/usr/bin:/bin",
        "HOME": OWN,
        "TMPDIR": OWN,
        "PYTHONPATH": str(_package().parent),
    }
    variables |= {"PENDLAB_SEED": str(caches[0])} if caches else {}
    for name, value in variables.items():
        binds += ["--setenv", name, value]
    world = ["--unshare-all", "--die-with-parent", "--new-session", "--clearenv"]
    return ["bwrap", *world, *binds, "--chdir", str(folder), *map(str, arguments)]


def _package():
    return Path(__file__).parents[1]


def _python():
    """Folders of Python and of this package, without those that hold another one."""
    places = {Path(sys.prefix), Path(sys.base_prefix), Path(site.getusersitepackages())}
    from ..parameters import DATA  # here, so that commands load with nothing but Python

    places |= {_package(), DATA.resolve()}
    return sorted(path for path in places if path.is_dir() and not path.is_relative_to("/usr"))


def limit():
    """Bound memory, size of files and processor time of this process and its children (not on
    Windows)."""
    try:
        import resource
    except ImportError:
        return
    bounds = {"RLIMIT_AS": MEMORY, "RLIMIT_FSIZE": FILES, "RLIMIT_CPU": SECONDS, "RLIMIT_CORE": 0}
    for name, bound in bounds.items():
        resource.setrlimit(getattr(resource, name), (bound, bound))


def bound_output(characters=1_000_000):
    """In a kernel: a cell that prints more ends with an error, before it floods who marks it."""
    written, left = {}, {}

    def bounded(write):
        def send(text):
            left["now"] -= len(text)
            if left["now"] < 0:
                raise RuntimeError(f"This cell printed more than {characters} characters.")
            return write(text)

        return send

    def begin(*_):
        left["now"] = characters
        for stream in (sys.stdout, sys.stderr):
            written[stream] = stream.write
            stream.write = bounded(stream.write)

    def end(*_):  # IPython puts its own in place for each cell
        for stream, write in written.items():
            stream.write = write
        written.clear()

    events = get_ipython().events  # noqa: F821
    events.register("pre_run_cell", begin)
    events.register("post_run_cell", end)


def main(connection):
    """Become the kernel that a connection file describes; its sockets are files, in one folder."""
    sockets = Path(json.loads(Path(connection).read_text(encoding="utf-8"))["ip"]).parent
    first = f"import {__package__}.confined as _; _.bound_output(); del _"
    kernel = [sys.executable, "-m", "ipykernel_launcher", "-f", connection]
    kernel.append(f"--IPKernelApp.exec_lines={first}")
    limit()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the kernel's greeting, once for every hand-in
    line = command(kernel, Path.cwd(), writable=[sockets], readable=[connection])
    os.execvp(line[0], line)


if __name__ == "__main__":
    main(sys.argv[1])
