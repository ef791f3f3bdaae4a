"""The side of marking that is not trusted: runs a submission's cells and hands out values.

Started by `judge` as ``python -m pendlab.classroom.pupil`` in a folder of its own. It obeys requests, one
JSON line each on its standard input, and answers on its standard output, which the notebook's own
output never reaches. A notebook that takes over this process can send what answers it likes and no
more: whether they are right is found out elsewhere.

    {"do": "run", "source": ...}                           -> {"error": null or a sentence}
    {"do": "get", "name": ...}                             -> {"value": ...} or {"missing": true}
    {"do": "attribute", "of": 3, "name": "step"}           -> the same
    {"do": "call", "of": 3, "args": ..., "keywords": ...}  -> {"value": ...} or {"error": ...}
"""

import json
import os
import sys

from .answers import decode, encode
from .confinement import Limits, restrict

LONGEST_MESSAGE = 300


def main(limits):
    requests, replies = _take_channel()
    restrict(limits)
    shell, objects = _shell(), []

    def keep(value):
        objects.append(value)
        return len(objects) - 1

    for line in requests:
        try:
            reply = _obey(json.loads(line), shell, objects, keep)
        except Exception as problem:  # whatever the student's objects do when looked at
            reply = {"error": describe(problem)}
        replies.write(json.dumps(reply).encode() + b"\n")
        replies.flush()


def _obey(request, shell, objects, keep):
    if request["do"] == "run":
        result = shell.run_cell(request["source"], store_history=False)
        problem = result.error_before_exec or result.error_in_exec
        return {"error": describe(problem) if problem is not None else None}
    if request["do"] == "get":
        if request["name"] not in shell.user_ns:
            return {"missing": True}
        return {"value": encode(shell.user_ns[request["name"]], keep)}
    thing = objects[request["of"]]
    if request["do"] == "attribute":
        if not hasattr(thing, request["name"]):
            return {"missing": True}
        return {"value": encode(getattr(thing, request["name"]), keep)}
    args, keywords = decode(request["args"], objects.__getitem__), request["keywords"]
    keywords = {name: decode(value, objects.__getitem__) for name, value in keywords.items()}
    return {"value": encode(thing(*args, **keywords), keep)}


def describe(problem):
    """An exception as one short line."""
    text = " ".join(f"{type(problem).__name__}: {problem}".split())
    return text if len(text) <= LONGEST_MESSAGE else text[:LONGEST_MESSAGE] + " ..."


def _take_channel():
    """The pipes to the judge, moved away from where notebooks read and print."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nothing, descriptor)
    return requests, replies


def _shell():
    from IPython.core.interactiveshell import InteractiveShell
    from traitlets.config import Config

    settings = Config()
    settings.HistoryManager.enabled = False
    shell = InteractiveShell.instance(config=settings)
    shell.display_formatter.active_types = ["text/plain"]
    return shell


if __name__ == "__main__":
    main(Limits(*map(float, sys.argv[1:])))
