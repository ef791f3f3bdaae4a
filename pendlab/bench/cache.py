"""Where generated and compiled code is kept: folders, a seed to copy from, and what is damaged.

Nothing here needs more than Python, so that the doctor can look.
"""

import hashlib
import os
import shutil
import sys
import tempfile
from contextlib import suppress
from functools import partial
from pathlib import Path

SEAL = "# sha256 "
TAG = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"  # as numba's


def cache_folders():
    """Where generated code may be kept, best first; PENDLAB_CACHE names another folder.

    No shared temporary folder: what another user could write must not be run.
    """
    yield from _named("PENDLAB_CACHE")
    for base in (os.environ.get("LOCALAPPDATA"), os.environ.get("XDG_CACHE_HOME")):
        if base and Path(base).is_absolute():
            yield Path(base) / "pendlab"
            return
    with suppress(RuntimeError):  # no home folder
        yield Path.home() / ".cache" / "pendlab"


def _named(variable):
    """The folder that an environment variable names, if it does."""
    text = os.environ.get(variable, "").strip()
    with suppress(RuntimeError):  # ~ of somebody who has no home
        if text:
            yield Path(text).expanduser().absolute()


def keep(name, write):
    """Path of the module `name` with the text `write()`; None where no folder can be written.

    What is damaged is written anew. Where nothing compiled lies in the folder, it is copied from the
    seed folder of PENDLAB_SEED, or from a cache folder that can only be read.
    """
    for folder in cache_folders():
        path = folder / f"{name}.py"
        try:
            make_writable(folder)
            if not (intact(path) and _compiled(folder, name)):
                _copy_seed(name, folder)
            if not intact(path):
                _put(path, lambda draft: draft.write_text(sealed(write()), "utf-8"))
            return path
        except OSError:
            continue
    return None


def sealed(text):
    """The text with a last line that tells whether it is whole."""
    return f"{text}\n{SEAL}{hashlib.sha256(text.encode()).hexdigest()}\n"


def intact(path):
    """Is the source there, and whole?"""
    try:
        text = path.read_bytes().decode("utf-8", "replace").replace("\r\n", "\n")
    except FileNotFoundError:
        return False
    body, _, _ = text.rpartition(f"\n{SEAL}")
    return text == sealed(body)


def _compiled(folder, name="*"):
    """Compiled files for this Python, data before the index that names them."""
    inside = folder / "__pycache__"
    return [*inside.glob(f"{name}.*.{TAG}.*.nbc"), *inside.glob(f"{name}.*.{TAG}.nbi")]


def _copy_seed(name, folder):
    for seed in (*_named("PENDLAB_SEED"), *cache_folders()):
        with suppress(OSError):
            source, compiled = seed / f"{name}.py", _compiled(seed, name)
            if seed != folder and intact(source) and compiled:
                (folder / "__pycache__").mkdir(exist_ok=True)
                for file in (source, *compiled):  # with their times, by which numba knows them
                    _put(folder / file.relative_to(seed), partial(shutil.copy2, file))
                return


def _put(path, fill):
    """Two sessions at once never see half a file, and a full disk leaves none."""
    handle, draft = tempfile.mkstemp(dir=path.parent, suffix=".draft")
    os.close(handle)
    try:
        fill(Path(draft))
        os.replace(draft, path)
    finally:
        Path(draft).unlink(missing_ok=True)


def cache_findings():
    """What the cache of compiled code looks like: a list of (well, what was found, what to do).

    >>> from pendlab.bench.cache import cache_findings
    >>> all(isinstance(well, bool) for well, found, advice in cache_findings())
    True
    """
    findings = []
    for folder in cache_folders():
        try:
            make_writable(folder)
        except OSError as problem:
            what = f"{folder} cannot be written ({problem.strerror or type(problem).__name__})"
            advice = "free some space or mend its rights, or set PENDLAB_CACHE to another folder."
            findings.append((False, what, advice))
            continue
        kernels = list(folder.glob("kernel_*.py"))
        damaged = sorted(file.name for file in kernels + _compiled(folder) if _damaged(file))
        if not damaged:
            return [*findings, (True, f"{folder}: {len(kernels)} kernels, none damaged", "")]
        what = f"{folder}: {len(damaged)} damaged, among them {damaged[0]}"
        advice = "nothing: they are made anew when they are needed; or delete that folder."
        return [*findings, (False, what, advice)]
    advice = "each session compiles anew (some seconds); set PENDLAB_CACHE to a folder of yours."
    return [*findings, (False, "no folder of yours can be written", advice)]


def make_writable(folder):
    """A folder that is there and takes a file; OSError otherwise."""
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()


def _damaged(file):
    """Source without its seal, or a pickle without its end."""
    try:
        if file.suffix == ".py":
            return not intact(file)
        return file.read_bytes()[-1:] != b"."
    except OSError:
        return True
