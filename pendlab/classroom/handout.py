"""A notebook as one printable page that needs no network: formulas as MathML, pictures inside."""

import copy
import html as html_text
import re
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from urllib.parse import unquote

from latex2mathml.converter import convert

from .files import pictures

WIDGET_VIEW = "application/vnd.jupyter.widget-view+json"
PAGE_WIDTH = 72  # letters of a row that fit on a page, two for the rims of each cell included
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "msedge")


def html(notebook, path):
    """The page of a notebook that lies at `path` (for pictures and the title).

    Raises ValueError for a formula that cannot be shown.
    """
    from nbconvert import HTMLExporter
    from pygments.formatters import HtmlFormatter

    exporter = HTMLExporter(
        template_name="basic", embed_images=True, exclude_input_prompt=True, sanitize_html=False
    )
    exporter.register_filter("markdown2html", markdown)
    place = {"metadata": {"path": str(Path(path).parent), "name": path.stem}}
    body, _ = exporter.from_notebook_node(prepared(notebook), resources=place)
    body = re.sub(r"<(link|script)\b[^>]*https?://[^>]*>(</script>)?", "", body)
    body = re.sub(r"<(table|math)\b.*?</\1>", _fitted, body, flags=re.DOTALL)
    head = f"<meta charset='utf-8'><title>{html_text.escape(path.stem)}</title>"
    style = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")
    style += HtmlFormatter(style="bw").get_style_defs(".highlight")
    return (
        f"<!DOCTYPE html>\n<html lang='en'><head>{head}<style>{style}</style></head>\n"
        f"<body>\n{body}\n</body></html>\n"
    )


def _fitted(found):
    """A table or formula wider than the page in smaller letters: paper cannot be scrolled."""
    width = max(map(_letters, re.split(r"</m?tr>", found[0])))
    if width <= PAGE_WIDTH:
        return found[0]
    size = max(100 * PAGE_WIDTH // width, 30)
    return found[0].replace(f"<{found[1]}", f'<{found[1]} style="font-size: {size}%"', 1)


def _letters(row):
    """How wide a row is, its cells' rims included."""
    cells = re.findall(r"<(?:m?td|th)\b.*?</(?:m?td|th)>", row, re.DOTALL) or [row]
    texts = (html_text.unescape(re.sub(r"<[^>]+>|\s+", "", cell)) for cell in cells)
    return sum(len(text) + 2 for text in texts)


def prepared(notebook):
    """A copy that holds what paper can show: no live widgets, formulas as MathML, pictures inside."""
    notebook = copy.deepcopy(notebook)
    for cell in notebook["cells"]:
        if attached := cell.pop("attachments", None):
            cell["source"] = pictures(cell["source"], partial(_inside, attached, cell["id"]))
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            data.pop(WIDGET_VIEW, None)
            data.pop("application/javascript", None)
            if "text/latex" in data and "text/html" not in data:
                formula = "".join(data.pop("text/latex")).strip().strip("$")
                data["text/html"] = mathml(formula.replace(r"\displaystyle", ""), block=True)
    return notebook


def mathml(latex, block=False):
    """A formula as MathML; raises ValueError with the formula where it is not understood."""
    latex = latex.strip().replace(r"\lt", "<").replace(r"\gt", ">")
    # latex2mathml knows align, not aligned; inside a formula they look the same.
    latex = re.sub(r"\\(begin|end)\{(aligned|split|gathered)\}", r"\\\1{align}", latex)
    try:
        result = convert(latex, display="block" if block else "inline")
    except Exception as problem:
        raise ValueError(f"formula: expected LaTeX, found {latex!r} ({problem!r}).") from None
    unknown = re.search(r"<m\w+[^>]*>(\\\w+)</m", result)
    if unknown:
        raise ValueError(f"formula: {unknown[1]} cannot be shown, in {latex!r}.")
    return re.sub(r"&(?!#?\w+;)", "&amp;", result)


def _inside(attached, cell, link):
    """A picture's link, with the picture in it where it is attached."""
    name = unquote(link.removeprefix("attachment:"))
    for key, contents in attached.items():
        if link.startswith("attachment:") and unquote(key) == name:
            kind, data = next(iter(contents.items()))
            return f"data:{kind};base64,{data}"
    return link


def markdown(source):
    """Markdown with formulas as HTML that needs no script."""
    from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath

    class Renderer(IPythonRenderer):
        """Formulas as MathML in place of text that a script would typeset later."""

        def inline_math(self, text):
            return mathml(text)

        def block_math(self, text):
            return mathml(text, block=True)

        def latex_environment(self, name, text):
            return mathml(rf"\begin{{{name}}}{text}\end{{{name}}}", block=True)

    # Pictures inside are `data:` links, which are held to be harmful where they are SVG.
    renderer = Renderer(escape=False, allow_harmful_protocols=True)
    return MarkdownWithMath(renderer=renderer).render(source)


def pdf(page):
    """Print a page beside itself with Chromium; False where there is none."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print("No Chromium was found: open the HTML page and print it.", file=sys.stderr)
        return False
    target = page.with_suffix(".pdf")
    with tempfile.TemporaryDirectory() as profile:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu"]
        command += ["--disable-background-networking", f"--user-data-dir={profile}"]
        command += ["--no-pdf-header-footer", f"--print-to-pdf={target}", page.resolve().as_uri()]
        subprocess.run(command, capture_output=True, timeout=120, check=True)
    print(target)
    return True
