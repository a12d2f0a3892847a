"""Sphinx configuration: Markdown by MyST, nothing fetched from the network while building."""

import importlib.util
import sys
from pathlib import Path

from sarrus import __version__

sys.path.insert(0, str(Path(__file__).parent))  # for the modules named below


def _mathjax() -> Path:
    """The folder of MathJax 3.2.2 in its Python package."""
    found = importlib.util.find_spec("sphinx-mathjax-offline")
    if found is None or found.origin is None:
        raise RuntimeError('formulas need MathJax: pip install "sarrus[docs]"')
    return Path(found.origin).parent / "static" / "mathjax"


project = "Sarrus"
author = "The Sarrus developers"
copyright = "2026, the Sarrus developers"
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.mathjax", "api_pages", "printed_outputs", "redirects"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
nitpicky = True

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

html_theme = "furo"
html_title = f"Sarrus {release}"
# One file in the site typesets formulas in the reader's browser, without a network.
html_static_path = [str(_mathjax() / "tex-svg.js"), "site.css"]
html_css_files = ["site.css"]
html_search_scorer = str(Path(__file__).with_name("search_weights.js"))
mathjax_path = "tex-svg.js"
