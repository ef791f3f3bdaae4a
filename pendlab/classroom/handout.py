"""A notebook as one printable page that needs no network: formulas as MathML, pictures inside."""

import html as html_text
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from jinja2 import pass_context
from latex2mathml.converter import convert

WIDGET_VIEW = "application/vnd.jupyter.widget-view+json"
PAGE_WIDTH = 72  # letters of a row that fit on a page, two for the rims of each cell included
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "msedge")
STYLE = """
@page { size: A4; margin: 18mm 16mm; }
body { font: 11pt/1.45 "DejaVu Serif", Georgia, serif; max-width: 46em; margin: 2em auto; padding: 0 1em; }
h1, h2, h3 { font-family: "DejaVu Sans", Arial, sans-serif; line-height: 1.2; break-after: avoid; }
pre { font: 9pt/1.35 "DejaVu Sans Mono", Consolas, monospace; white-space: pre-wrap; overflow-wrap: anywhere; margin: 0; }
code { font: 0.9em "DejaVu Sans Mono", Consolas, monospace; }
.highlight { background: #f5f5f2; border-left: 3px solid #999; padding: .5em .8em; }
.jp-Cell, .cell { margin: .8em 0; }
.prompt, .jp-InputPrompt, .jp-OutputPrompt, .anchor-link { display: none; }
img, svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: .6em 0; }
td, th { border: 1px solid #bbb; padding: .15em .4em; text-align: left; overflow-wrap: anywhere; }
math[display=block] { margin: .6em 0; }
blockquote { border-left: 3px solid #bbb; margin-left: 0; padding-left: 1em; }
.output_stderr { color: #a00; }
math { font-family: "STIX Two Math", "Cambria Math", "Latin Modern Math", math; }
@media print { body { max-width: none; margin: 0; padding: 0; font-size: 10pt; } a { color: inherit; text-decoration: none; } img, table, .highlight { break-inside: avoid; } }
"""


def html(notebook, path):
    """The page of a notebook that lies at `path` (for pictures and the title).

    Raises ValueError for a formula that cannot be shown.
    """
    from nbconvert import HTMLExporter

    notebook = prepared(notebook)
    exporter = HTMLExporter(
        template_name="basic", embed_images=True, exclude_input_prompt=True, sanitize_html=False
    )
    exporter.register_filter("markdown2html", _cell_markdown)
    body, _ = exporter.from_notebook_node(
        notebook, resources={"metadata": {"path": str(Path(path).parent), "name": path.stem}}
    )
    body = re.sub(r"<(link|script)\b[^>]*https?://[^>]*>(</script>)?", "", body)
    body = re.sub(r"<(table|math)\b.*?</\1>", _fitted, body, flags=re.DOTALL)
    head = f"<meta charset='utf-8'><title>{html_text.escape(path.stem)}</title>"
    colours = _code_colours()
    return (
        f"<!DOCTYPE html>\n<html lang='en'><head>{head}<style>{STYLE}{colours}</style></head>\n"
        f"<body>\n{body}\n</body></html>\n"
    )


def _fitted(found):
    """A table or formula wider than the page in smaller letters: paper cannot be scrolled."""
    rows = re.split(r"</m?tr>", found[0])
    cells = [
        re.findall(r"<(?:m?td|th)\b.*?</(?:m?td|th)>", row, re.DOTALL) or [row] for row in rows
    ]
    texts = [
        [html_text.unescape(re.sub(r"<[^>]+>|\s+", "", cell)) for cell in row] for row in cells
    ]
    width = max(sum(len(text) + 2 for text in row) for row in texts)
    if width <= PAGE_WIDTH:
        return found[0]
    size = max(100 * PAGE_WIDTH // width, 30)
    return found[0].replace(f"<{found[1]}", f'<{found[1]} style="font-size: {size}%"', 1)


def prepared(notebook):
    """A copy whose outputs hold what paper can show: no live widgets, formulas as MathML."""
    import copy

    notebook = copy.deepcopy(notebook)
    for cell in notebook["cells"]:
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            data.pop(WIDGET_VIEW, None)
            data.pop("application/javascript", None)
            if "text/latex" in data and "text/html" not in data:
                data["text/html"] = _latex_output("".join(data.pop("text/latex")))
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


def _latex_output(text):
    inner = text.strip()
    while inner.startswith("$") and inner.endswith("$") and len(inner) > 1:
        inner = inner[1:-1]
    return mathml(inner.replace(r"\displaystyle", ""), block=True)


@pass_context
def _cell_markdown(context, source):
    return markdown(source, context.get("cell", {}).get("attachments", {}))


def markdown(source, attachments=None):
    """Markdown with formulas as HTML that needs no script; attached pictures stand inside."""
    from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath

    class Renderer(IPythonRenderer):
        """Formulas as MathML in place of text that a script would typeset later."""

        def inline_math(self, text):
            return mathml(text)

        def block_math(self, text):
            return mathml(text, block=True)

        def latex_environment(self, name, text):
            return mathml(rf"\begin{{{name}}}{text}\end{{{name}}}", block=True)

    attachments = attachments or {}
    for name, contents in attachments.items():  # in HTML tags the renderer leaves them alone
        for kind, data in contents.items():
            inside = f"data:{kind};base64,{data}"
            source = re.sub(
                rf"(src\s*=\s*[\"'])attachment:{re.escape(name)}", rf"\1{inside}", source
            )
    renderer = Renderer(escape=False, attachments=attachments)
    return MarkdownWithMath(renderer=renderer).render(source)


def _code_colours():
    from pygments.formatters import HtmlFormatter

    return HtmlFormatter(style="bw").get_style_defs(".highlight")


def pdf(page):
    """Print a page beside itself with Chromium; False where there is none."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        return False
    target = page.with_suffix(".pdf")
    with tempfile.TemporaryDirectory() as profile:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu"]
        command += ["--disable-background-networking", f"--user-data-dir={profile}"]
        command += ["--no-pdf-header-footer", f"--print-to-pdf={target}", page.resolve().as_uri()]
        subprocess.run(command, capture_output=True, timeout=120, check=True)
    print(target)
    return True
