"""Sphinx builds the documentation from this folder; `make docs` calls it."""

# Sphinx, matplotlib and latex2mathml are in .venv-docs alone.
# pyright: reportMissingImports=false, reportMissingModuleSource=false

import sys
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from generator import mathml, site  # noqa: E402  found by the line above

from dr_lab import __version__  # noqa: E402

project = "dr_lab"
author = "the dr_lab developers"
release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4  # links to headings are checked
nitpicky = True
nitpick_ignore_regex = [(r"py:.*", r".*")]  # types of libraries have no page here
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
default_role = "code"  # what stands between single backticks in a docstring
smartquotes = False  # quotes in comments are the shell's
autodoc_member_order = "bysource"
exclude_patterns = ["generator"]
html_theme = "furo"
html_title = "dr_lab"
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
copybutton_prompt_text = "$ "
pygments_style = "friendly"
pygments_dark_style = "monokai"
linkcheck_timeout = 20  # s


def setup(app: Sphinx) -> None:
    """Write the generated pages before Sphinx looks for its sources, and set equations as MathML."""
    app.connect("config-inited", lambda app, _: site.write(Path(app.srcdir) / "generated", figures=True))
    app.add_html_math_renderer("mathml", (mathml.inline, None), (mathml.block, None))
    app.config.html_math_renderer_name = "mathml"
