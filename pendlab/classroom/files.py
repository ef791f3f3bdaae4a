"""The classroom's commands and their files: which notebooks go in, where results go, pictures inside."""

import argparse
import base64
import mimetypes
import os
import re
import tempfile
from functools import partial
from pathlib import Path
from urllib.parse import quote, unquote

# A fenced block or inline code (left alone), a Markdown picture, one named elsewhere, or an HTML one.
PICTURE = re.compile(
    r"```.*?```|`[^`\n]*`"
    r"|!\[[^\]]*\]\(\s*(?:<(?P<wide>[^>\n]+)>|(?P<link>(?:[^()\s<]|\([^()\s]*\))+))"
    r"|^ {0,3}\[[^\]]+\]:\s*(?P<named>\S+\.(?:png|jpe?g|gif|svg|webp))\b"
    r"|<img\b[^>]*?\bsrc\s*=\s*[\"'](?P<tag>[^\"']+)",
    re.DOTALL | re.MULTILINE | re.IGNORECASE,
)


def command(commands, name, run, about, example="", folder=None):
    """The parser of one command; `folder` says what goes into the folder of its option --folder."""
    example = f"example:\n  python -m pendlab {name} {example}".rstrip()
    kind = argparse.RawDescriptionHelpFormatter
    texts = dict(help=about, description=about, epilog=example, formatter_class=kind)
    parser = commands.add_parser(name, **texts)
    parser.set_defaults(run=run)
    if folder:
        default, what = Path(f"pendlab-{name}"), f"where the {folder} go (default: %(default)s)"
        parser.add_argument("--folder", type=Path, default=default, help=what)
    return parser


def writable(name, folder):
    """The folder's absolute path; ValueError where nothing can be written there, before the work."""
    folder = Path(folder).resolve()
    above = next(path for path in (folder, *folder.parents) if path.exists())
    if not above.is_dir():
        raise ValueError(f"{name}: expected a folder, found the file {above.name!r} in its place.")
    try:
        tempfile.TemporaryFile(dir=above).close()
    except OSError:
        why = f"{name}: {above} cannot be written to; choose another folder."
        raise ValueError(why) from None
    return folder


def notebooks(paths, folder):
    """(notebook, its place below the paths' common folder) pairs.

    A folder stands for all notebooks in it, homework included, without those below the target
    `folder`: what a command wrote is never its own source.
    """
    found, tops = {}, []
    for path in map(Path, paths):
        full = path.resolve()
        if path.is_dir():
            inside = [p for p in full.rglob("*.ipynb") if ".ipynb_checkpoints" not in p.parts]
            found.update(dict.fromkeys(sorted(p for p in inside if folder not in p.parents)))
            tops.append(full)
        elif path.suffix == ".ipynb" and path.exists():
            found[full] = None
            tops.append(full.parent)
        else:
            raise ValueError(f"notebooks: expected a notebook or a folder, found {str(path)!r}.")
    if not found:
        raise ValueError("notebooks: the folders hold no notebook.")
    top = os.path.commonpath(tops)
    return [(path, path.relative_to(top)) for path in found]


def plan(paths, folder, suffix):
    """(notebook, file to write) pairs; ValueError where a file would replace its own source."""
    folder = writable("folder", folder)
    pairs = [(p, (folder / place).with_suffix(suffix)) for p, place in notebooks(paths, folder)]
    for path, target in pairs:
        if target in dict(pairs):
            raise ValueError(
                f"folder: {path.name} would be written over its original; choose a new folder."
            )
    return pairs


def opened(path):
    """The notebook of a file, its pictures inside."""
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    embed_pictures(notebook, path.parent)
    return notebook


def as_text(notebook):
    """The text of a notebook's file."""
    import nbformat

    return nbformat.writes(notebook) + "\n"


def pictures(source, change):
    """Markdown with `change(link)` in place of each picture's link; code stays as it is."""

    def changed(found):
        link = next(filter(None, found.groups()), None)
        return found[0].replace(link, change(link)) if link else found[0]

    return PICTURE.sub(changed, source)


def embed_pictures(notebook, folder):
    """Turn local pictures of Markdown cells into attachments, so that the notebook can move.

    Raises ValueError naming the cell and the file where a picture is missing.
    """
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            attached = cell.get("attachments", {})
            attach = partial(_attach, attached, Path(folder), cell["id"])
            cell["source"] = pictures(cell["source"], attach)
            if attached:
                cell["attachments"] = attached


def _attach(attached, folder, cell, link):
    known = unquote(link.removeprefix("attachment:")) in map(unquote, attached)
    if re.match(r"(?!attachment:)[a-z][a-z0-9+.-]*:|//|#", link, re.IGNORECASE) or known:
        return link
    file = folder / unquote(link)
    if not file.is_file():
        raise ValueError(f"cell {cell}: the picture {link} is missing; put it beside the notebook.")
    kind = mimetypes.guess_type(file.name)[0] or "image/png"
    name = quote(unquote(link).replace("/", "-"))
    attached[name] = {kind: base64.b64encode(file.read_bytes()).decode()}
    return f"attachment:{name}"
