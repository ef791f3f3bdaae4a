"""Data files as tables to read: a rig's parameters, and what is assumed of the bench."""

from ..parameters import DATA, load, read_toml

SYMBOLS = {
    "links": dict(length="l_i", mass="m_i", inertia="I_i", com="a_i", friction="C_i"),
    "motors": dict(damping="c_{pi}", inertia="I_{pi}", gain="G_i", ratio="k_i"),
}


def parameter_table(name):
    """Markdown tables of a rig's file: symbol, unit, a column for each link or motor, source.

    Raises
    ------
    ValueError : a rig without a file, as `load` says it

    >>> "| $m_i$ | mass | kg |" in parameter_table("double").data
    True
    """
    load(name)
    data = read_toml(DATA / "rigs" / f"{name}.toml")
    text = f"**The {name} pendulum**\n"
    for kind, symbols in SYMBOLS.items():
        parts = data[kind]
        columns = [f"{kind[:-1]} {i}" for i in range(1, len(parts) + 1)]
        rows = [
            [f"${symbol}$", field, parts[0][field]["unit"]]
            + [f"{part[field]['value']:g}" for part in parts]
            + ["; ".join(dict.fromkeys(part[field]["source"] for part in parts))]
            for field, symbol in symbols.items()
        ]
        text += "\n" + _table(["symbol", "quantity", "unit", *columns, "source"], rows) + "\n"
    for field, entry in [*data["filters"].items(), *data["limits"].items()]:
        values = ", ".join(f"{value:g}" for value in entry["value"])
        text += f"\n{field}: {values} {entry['unit']} ({entry['source']})\n"
    return _markdown(text)


def bench_table():
    """Markdown table of ``data/gearbox.toml``: every value of the bench with unit and source."""
    data = read_toml(DATA / "gearbox.toml")
    parts = {f"gearbox {k}": part for k, part in enumerate(data["gearboxes"], 1)}
    parts |= {name: data[name] for name in ("hinges", "sensors")}
    parts |= {f"bench, {name}": part for name, part in data["benches"].items()}
    rows = [
        [part, name, str(entry["value"]), entry["unit"], entry["source"]]
        for part, entries in parts.items()
        for name, entry in entries.items()
    ]
    return _markdown(_table(["part", "entry", "value", "unit", "source"], rows))


def bench_notes():
    """What ``data/gearbox.toml`` says of its values before it lists them, as a quotation."""
    head = (DATA / "gearbox.toml").read_text(encoding="utf-8").split("[[")[0].strip()
    lines = (line.removeprefix("#").removeprefix(" ") for line in head.splitlines())
    return _markdown("\n".join(f"> {line}" for line in lines))


def _table(head, rows):
    return "\n".join(f"| {' | '.join(line)} |" for line in [head, ["---"] * len(head), *rows])


def _markdown(text):
    from IPython.display import Markdown

    return Markdown(text)
