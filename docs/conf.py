"""Sphinx configuration: Markdown by MyST, nothing fetched from the network while building."""

import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # for api_pages

project = "Sarrus"
author = "The Sarrus developers"
copyright = "2026, the Sarrus developers"
pyproject = Path(__file__).parent.parent / "pyproject.toml"
release = version = tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]["version"]

extensions = ["myst_parser", "sphinx.ext.mathjax", "api_pages"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
nitpicky = True

myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

html_theme = "furo"
html_title = f"Sarrus {release}"
html_static_path: list[str] = []
# Formulas are typeset in the reader's browser. To read the pages without a network, set this to a local copy:
# mathjax_path = "mathjax/tex-mml-chtml.js"  (and list its folder in html_static_path)
