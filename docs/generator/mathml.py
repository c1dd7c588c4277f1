"""Equations as MathML, which browsers set by themselves: no script, nothing fetched."""

# Sphinx, matplotlib and latex2mathml are in .venv-docs alone.
# pyright: reportMissingImports=false, reportMissingModuleSource=false

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.writers.html5 import HTML5Translator


def inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write an equation within a line; Sphinx calls it."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block(translator: HTML5Translator, node: nodes.math_block) -> None:
    """Write an equation on a line of its own; Sphinx calls it."""
    translator.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode
