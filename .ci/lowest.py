"""environment.txt with each version that pyproject.toml bounds from below put at that bound."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent


def bounds():
    """Package -> requirement at its lower bound."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project.get("optional-dependencies", {}).values()
    found = {}
    for requirement in [*project["dependencies"], *(r for extra in extras for r in extra)]:
        name, version, marker = re.fullmatch(
            r"([\w.-]+)(?:\[.*\])?\s*>=\s*([\w.]+)[^;]*(;.*)?", requirement
        ).groups()
        found[name] = f"{name}=={version}{marker or ''}"
    return found


def main():
    lowest = bounds()
    for line in (ROOT / "environment.txt").read_text(encoding="utf-8").splitlines():
        name = re.match(r"[\w.-]*", line)[0]
        if name and name not in lowest:
            print(line)
    print(*lowest.values(), sep="\n")


if __name__ == "__main__":
    main()
