"""Equations as MathML, made while the pages are built: browsers show it without a network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.math import get_node_equation_number

LOGGER = logging.getLogger(__name__)


def mathml(node: nodes.Element, *, block: bool) -> str:
    """The MathML of a node; LaTeX that cannot be converted is a warning, and shown as it is.

    Args:
        node: The equation.
        block: Whether it stands on lines of its own.
    """
    text = node.astext().strip()
    source = text
    if block and (r"\\" in text) and not text.startswith(r"\begin"):
        source = rf"\begin{{aligned}}{text}\end{{aligned}}"
    try:
        return str(tex2mathml(source, as_block=block))
    except MathError as error:
        LOGGER.warning("equation %r: %s", text, error, location=node, type="math")
        return f"<code>{nodes.Text(text).astext()}</code>"


def visit_inline(translator: Any, node: nodes.math) -> None:
    """Write an equation in a line of text."""
    translator.body.append(mathml(node, block=False))
    raise nodes.SkipNode


def visit_block(translator: Any, node: nodes.math_block) -> None:
    """Write an equation on lines of its own, with its number when it has one."""
    translator.body.append(translator.starttag(node, "div", CLASS="math"))
    if node.get("number"):
        number = get_node_equation_number(translator, node)
        translator.body.append(f'<span class="eqno">({number})')
        translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append("</span>")
    translator.body.append(mathml(node, block=True))
    translator.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the renderer `mathml`."""
    app.add_html_math_renderer(
        "mathml", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None)
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
