"""Keeping a process that is not trusted in bounds: time, memory, children, files, network.

Everywhere: a folder of its own as working folder and home, an environment without the marker's
variables, a watch over time, memory, number of processes and disk, and an end for the whole family
of processes. On POSIX also hard limits. On Linux, where the kernel lets users make namespaces: no
network, no sight of other processes, a file system that is read-only but for its own folder, and
with the marker's own folders hidden.
"""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

import psutil

MOST_PROCESSES = 40
REFUSED = 96  # exit code of the wrapper where the kernel refuses a step

# Own folder bound on itself, so that it stays writable when the rest becomes read-only; then the
# hidden folders; then all rights over the namespace are given up for good.
WRAPPER = """
mount --bind "$1" "$1" || exit 96
mount -t proc proc /proc || exit 96
while read -r _ place _; do
    case "$place" in "$1" | /proc | /proc/* | /dev | /dev/*) continue ;; esac
    mount -o remount,bind,ro "$place" 2>/dev/null
done </proc/self/mounts
[ -w "$0" ] && exit 96
mount -t tmpfs -o size=64m tmpfs /dev/shm 2>/dev/null
cd "$1" && shift
while [ "$1" != -- ]; do mount -t tmpfs -o ro tmpfs "$1" || exit 96; shift; done
shift
exec setpriv --no-new-privs --bounding-set=-all --inh-caps=-all "$@"
"""


@dataclass(frozen=True)
class Limits:
    """What a submission may use: wall time and CPU time (s), memory and disk (MB)."""

    seconds: float = 120.0
    memory: float = 4000.0
    disk: float = 200.0

    def __post_init__(self):
        for name, value in asdict(self).items():
            if not value > 0:
                raise ValueError(f"{name}: expected a limit above 0, found {value}.")


def restrict(limits):
    """Hard limits on this process and its children, before foreign code runs (POSIX)."""
    try:
        import resource
    except ImportError:  # Windows: the watch alone
        return
    seconds, megabyte = int(limits.seconds) + 1, 1_000_000
    _lower(resource, "RLIMIT_CPU", seconds)
    _lower(resource, "RLIMIT_AS", int(limits.memory * megabyte))
    _lower(resource, "RLIMIT_FSIZE", int(limits.disk * megabyte))
    _lower(resource, "RLIMIT_CORE", 0)


def _lower(resource, name, value):
    limit = getattr(resource, name)
    _, hard = resource.getrlimit(limit)
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    try:
        resource.setrlimit(limit, (value, value))
    except (ValueError, OSError):  # macOS refuses some; the watch remains
        pass


def environment(folder):
    """Variables for a process that lives in `folder` and knows nothing of its marker."""
    kept = ("PATH", "LANG", "LC_ALL", "SYSTEMROOT", "PATHEXT", "COMSPEC", "LD_LIBRARY_PATH")
    own = ("HOME", "USERPROFILE", "TMPDIR", "TEMP", "TMP", "IPYTHONDIR", "MPLCONFIGDIR")
    threads = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    return {
        **{name: os.environ[name] for name in kept if name in os.environ},
        **dict.fromkeys(own, str(folder)),
        **dict.fromkeys(threads, "1"),
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "PYTHONHASHSEED": "0",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONUTF8": "1",
        "MPLBACKEND": "agg",
        "PENDLAB_CACHE": str(Path(folder) / "cache"),
    }


def confined(command, folder, hidden=()):
    """The command, wrapped in namespaces of its own where this machine can."""
    if not can_confine():
        return list(command)
    needed = [Path(folder), Path(sys.prefix), Path(sys.base_prefix), Path(__file__).parents[1]]
    masks = [
        str(place.resolve())
        for place in map(Path, hidden)
        if not any(own.resolve().is_relative_to(place.resolve()) for own in needed)
    ]
    return [*_namespaces(), str(Path(__file__)), str(folder), *masks, "--", *command]


def _namespaces():
    unshare = ["unshare", "--user", "--map-root-user", "--mount", "--net", "--pid"]
    return [*unshare, "--fork", "--kill-child", "sh", "-c", WRAPPER]


@lru_cache
def can_confine():
    """Whether this machine lets its users make namespaces (Linux, most distributions)."""
    if not all(map(shutil.which, ("unshare", "setpriv", "mount", "sh"))):
        return False
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        trial = [*_namespaces(), str(Path(__file__)), folder, "--", "true"]
        done = subprocess.run(trial, capture_output=True, check=False)
    return done.returncode == 0


def adopt_orphans():
    """Make this process the parent of descendants whose parent ends, so that none gets away."""
    if sys.platform == "linux":
        from ctypes import CDLL

        CDLL(None).prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER


def family(pid):
    """The process and all its descendants."""
    try:
        head = psutil.Process(pid)
        return [head, *head.children(recursive=True)]
    except psutil.Error:
        return []


def end(pid, head_too=True):
    """Stop, then kill, a process and its descendants, until none is left.

    Parents are stopped before their children, so that none forks while others die, and the head
    goes last: as long as it is there, it is the parent of every orphan (`adopt_orphans`).
    """
    head = family(pid)[:1]
    if head_too:
        _each(head, "suspend")
    for _ in range(500):
        below = [member for member in family(pid)[1:] if _alive(member)]
        if not below:
            break
        _each(below, "suspend")
        _each(below, "kill")
        time.sleep(0.01)
    if head_too:
        _each(head, "kill")


def _each(members, act):
    for member in members:
        try:
            getattr(member, act)()
        except psutil.Error:
            pass


def _alive(member):
    try:
        return member.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def watch(process, folder, limits):
    """Wait for a process; the sentence on why it must end, or None when it ended by itself."""
    start = time.monotonic()
    while True:
        try:
            process.wait(timeout=0.1)
            return None
        except subprocess.TimeoutExpired:
            pass
        if time.monotonic() - start > limits.seconds:
            return f"stopped after {limits.seconds:g} s"
        members = family(process.pid)
        if len(members) > MOST_PROCESSES:
            return "stopped: it started too many processes"
        if sum(map(_resident, members)) > limits.memory * 1e6:
            return f"stopped: more than {limits.memory:g} MB of memory"
        if _occupied(folder) > limits.disk * 1e6:
            return f"stopped: it wrote more than {limits.disk:g} MB"


def _resident(member):
    try:
        return member.memory_info().rss
    except psutil.Error:
        return 0


def _occupied(folder):
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            try:
                total += os.lstat(os.path.join(place, name)).st_size
            except OSError:
                pass
    return total
