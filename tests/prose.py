"""Numerals of Markdown cells, and the known numbers that may stand behind them.

A numeral is *held* if a known number, in the same unit or one that is converted, is

* an output or a number typed in the code of its own section (from heading to heading): an output
  may be rounded to the numeral's last digit, what is typed must be equal;
* an output or a typed number anywhere in its notebook, if the numeral has three digits or more;
* a constant of the checks of its notebook, a printed number of the paper or a parameter of data/.

What a homework task asks for is a constant of its check, or a number of the paper. Small counts,
years, minutes, exponents, and the numbers of sections, figures and equations need no source.
"""

import importlib
import io
import re
import tokenize
import tomllib
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from html import unescape
from math import pi
from pathlib import Path

ROOT = Path(__file__).parent.parent
SMALL = 12  # whole numbers up to here, without a unit, are counts

# unit -> the unit that it is a part of, and the factor
PARTS = {
    "ms": ("s", 1e-3), "µs": ("s", 1e-6), "seconds": ("s", 1), "kHz": ("Hz", 1e3), "MHz": ("Hz", 1e6),
    "mV": ("V", 1e-3), "mrad": ("rad", 1e-3), "degrees": ("rad", pi / 180), "°": ("rad", pi / 180),
    "mm": ("m", 1e-3), "cm": ("m", 1e-2), "g": ("kg", 1e-3), "Nm": ("N m", 1), "mN m": ("N m", 1e-3),
    "kg per metre": ("kg/m", 1), "per second": ("1/s", 1), "%": ("1", 1e-2), "per cent": ("1", 1e-2), r"^\circ": ("rad", pi / 180),
}  # fmt: skip
_NAMES = sorted(
    [*PARTS, "s", "Hz", "V/rad", "V", "rad/s", "rad", "m", "kg", "kg/m", "N m", "A"], key=len
)
UNIT = re.compile(
    r"(?:\\[,;! ]|[\s$~{}\\]|mathrm\{|text\{)*("
    + "|".join(re.escape(name) for name in reversed(_NAMES))
    + r")(?![A-Za-z])"
)
NUMBER = re.compile(
    r"(?<![\w.])(\d{1,3}(?:(?:\{,\}|\\,)\d{3})+|\d+)(\.\d+)?"
    r"(?:\s*\\(?:times|cdot)\s*10\^\{?(-?\d+)\}?|\.?[eE]([-+]?\d+))?(?![\w]|\.\d)"
)

_SECTION = r"\d{1,2}(?:\.\d{1,2})?(?!\d)"
_ITEM = r"\(?\d{1,2}(?![.\d]\d)\)?(?:\([a-f]\)|[a-f]\b)?"
_JOIN = r"(?:,\s*|\s*(?:and|or|to|-|–)\s*)"
NOT_NUMBERS = [
    re.compile(pattern, re.M | re.S if "```" in pattern else re.M)
    for pattern in (
        r"```.*?```",
        r"\]\([^)]*\)|<[^>]*>",  # where links lead, marks of HTML
        r"^#+ \d+(?:\.\d+)*\.?(?= )|^\s*\d+\. ",  # headings and lists
        r"\[\d\d\]|\*\*\d\d\*\*|\\tag\{[^}]*\}",  # notebooks and equations by number
        r"\*\*Time:?\*\*.*|\d+(?= min\b)|^\| \[.*\| [\d +]+ \|$",  # minutes have tests of their own
        r"(?s:Things to try.*?(?=\*\*Where next|\Z))|^Try: .*",  # any number does
        r"(?:90|180|270|360)(?: degrees|°|\^\\circ)",  # quarters of a turn
        rf"(?i:\b(?:sections?|exercises?|tasks?|notebooks?|homework))[~ ]{_SECTION}(?:{_JOIN}{_SECTION})*",
        rf"(?i:\b(?:fig(?:ure)?s?\.?|tables?|equations?|appendix|observers?|motors?|links?|inputs?|outputs?|steps?|loops?|pages?))[~ ]\$?{_ITEM}(?:{_JOIN}{_ITEM})*",
        r"\(\d{1,2}\)",
        r"\b(?:19|20)\d\d\b",
        r"(?<!10)(?:_|\^(?!\\circ|\{\\circ))(?:\{[^{}]*\}|\d)",  # indices and exponents
    )
]


@dataclass(frozen=True)
class Numeral:
    """A numeral as written: its value in its unit, half of its last digit, and where it stands."""

    text: str
    value: float
    half: float
    unit: str = ""
    cell: str = ""
    around: str = ""

    def held_by(self, known, rounded):
        """Whether `known` is this number; if `rounded`, after rounding to the last digit written."""
        mine, factor = PARTS.get(self.unit, (self.unit, 1))
        other, part = PARTS.get(known.unit, (known.unit, 1))
        if mine and other and mine != other:
            return False
        # Code and constants are in SI; a number in a table may stand under its unit's name.
        scales = {part / factor, 1.0} if rounded and not (mine and other) else {part / factor}
        if any(self._equals(known, scale, rounded) for scale in scales):
            return True
        # 30 % less is a factor of 0.7.
        return mine == "1" and abs(abs(1 - known.value) - factor * self.value) < 1e-9

    def _equals(self, known, scale, rounded):
        if scale == 1 and known.half > self.half * 1.001:
            return False  # digits that the source does not have
        # A single digit stands for itself, not for all that would round to it.
        width = min(self.half, 0.05 * self.value) if rounded else 0
        return abs(known.value * scale - self.value) <= width + 1e-9 * self.value

    @property
    def digits(self):
        """Number of significant digits, zeros at the end included."""
        return len(re.sub(r"\D", "", self.text).lstrip("0"))

    def __str__(self):
        return f"{self.text} {self.unit}".strip()


def numerals(text, cell=""):
    """All numbers of a text, signs left out."""
    for match in NUMBER.finditer(text):
        whole, fraction, power, exponent = match.groups()
        scale = 10.0 ** int(power or exponent or 0)
        unit = UNIT.match(text, match.end())
        around = text[max(0, match.start() - 30) : match.end() + 20]
        yield Numeral(
            match[0],
            float(re.sub(r"\D", "", whole) + (fraction or "")) * scale,
            0.5 * 10.0 ** -len((fraction or ".")[1:]) * scale,
            unit[1] if unit else "",
            cell,
            " ".join(around.split()),
        )


def claims(cell):
    """The numerals of a Markdown cell that need a source."""
    text = cell.source.replace(r"\%", "%").replace(r"\ ", " ")
    for pattern in NOT_NUMBERS:
        text = pattern.sub(" ", text)
    for numeral in numerals(text, cell.id):
        if numeral.value > SMALL or numeral.unit or "." in numeral.text:
            yield numeral


def printed(cell):
    """The numbers in the stored text outputs of a code cell."""
    for output in cell.outputs:
        texts = [text for kind, text in output.get("data", {}).items() if kind.startswith("text/")]
        for text in [output.get("text", ""), *texts]:
            yield from numerals(unescape(re.sub(r"<[^>]+>", " ", text)), cell.id)


def typed(cell):
    """The numbers in the code of a cell."""
    for token in tokenize.generate_tokens(io.StringIO(cell.source).readline):
        if token.type == tokenize.NUMBER:
            yield from numerals(token.string, cell.id)


@cache
def paper():
    """The ledger's printed numbers and the parameters in data/, with their units."""
    entries = tomllib.loads((ROOT / "data/published.toml").read_text(encoding="utf-8"))["entry"]
    pairs = [(entry["printed"], entry["unit"], entry["key"]) for entry in entries]
    for path in (ROOT / "data").rglob("*.toml"):
        pairs += [
            (text, unit, path.stem)
            for text, unit in re.findall(
                r'value = ([^"]*?), +unit = "([^"]*)"', path.read_text(encoding="utf-8")
            )
        ]
    return [
        Numeral(n.text, n.value, n.half, "" if unit.startswith("SI") else unit, key)
        for text, unit, key in pairs
        for n in numerals(text)
    ]


def constants(path):
    """The numbers among the constants of a notebook's checks."""
    stem = path.stem.split("_")[0]
    names = [f"checks.hw{int(stem)}" if path.parent.name == "homework" else f"checks.nb{stem}"]
    names += ["contest"] if names == ["checks.hw9"] else []
    found = []
    for name in names:
        with suppress(ModuleNotFoundError):
            module = importlib.import_module(f"pendlab.classroom.{name}")
            values = [repr(value) for key, value in vars(module).items() if key.isupper()]
            text = re.sub(r"(?<=\d)\.0\b", "", "; ".join(values))
            found += numerals(text, name)
    return found


class Sources:
    """What is known in a notebook, section by section."""

    def __init__(self, notebook, path):
        self.constants = constants(path)
        self.task = path.parent.name == "homework"
        self.sections, self.of, section = [], {}, None
        for cell in notebook.cells:
            if section is None or re.search(r"(?m)^##? ", cell.source * (cell.cell_type != "code")):
                section = ([], [])
                self.sections.append(section)
            self.of[cell.id] = section
            if cell.cell_type == "code":
                section[0].extend(printed(cell))
                section[1].extend(typed(cell))

    def hold(self, claim):
        if any(claim.held_by(known, False) for known in self.constants):
            return True
        if self.task and re.search(r"-ex\d+-task$", claim.cell):
            return False
        # Among a thousand printed numbers some fit by chance: units agree, or there are digits.
        if any(
            claim.held_by(known, False)
            for known in paper()
            if claim.digits >= 3 or bool(claim.unit) == (known.unit not in ("", "1"))
        ):
            return True
        far = claim.digits >= 3
        return any(
            claim.held_by(known, kind == 0)
            for section in (self.sections if far else [self.of[claim.cell]])
            for kind in (0, 1)
            for known in section[kind]
        )

    def nearest(self, claim, count=3):
        """The closest known numbers, as words for a message."""
        own = self.of[claim.cell]
        known = {(n.text, n.cell): n for n in [*own[0], *own[1], *self.constants, *paper()]}
        near = sorted(known.values(), key=lambda n: abs(n.value - claim.value))[:count]
        return ", ".join(f"{n.text} ({n.cell})" for n in near)


def unheld(notebook, path):
    """A sentence for every numeral of the notebook's prose that nothing holds."""
    sources = Sources(notebook, path)
    return [
        f"{path.stem} {claim.cell}: {claim} in '{claim.around}' is no output or input of its section, "
        f"no constant of a check and no number of the paper; nearest are {sources.nearest(claim)}"
        for cell in notebook.cells
        if cell.cell_type == "markdown"
        for claim in claims(cell)
        if not sources.hold(claim)
    ]
