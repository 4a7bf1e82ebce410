"""Configuration of the documentation site: python -m sphinx -W --keep-going -b html docs build/docs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer

sys.path.insert(0, str(Path(__file__).parents[1]))

from splinebba_cli import __version__

project = "splinebba"
author = "The splinebba developers"
version = release = __version__
copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "docs.extensions.anchors",
    "docs.extensions.error_pages",
    "docs.extensions.navigation",
    "docs.extensions.public_api",
    "docs.extensions.repository_links",
]
exclude_patterns = ["*.intro.md", "*.words.md", "extensions"]
suppress_warnings = ["myst.header"]  # README pages of samples begin where they like

myst_heading_anchors = 4
myst_url_schemes = {"http": None, "https": None, "mailto": None, "repository": None}

napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False
autodoc_typehints = "none"  # docstrings say shapes and units
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = "splinebba"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1f5f8b", "color-brand-content": "#1f5f8b"},
    "dark_css_variables": {"color-brand-primary": "#7db8dc", "color-brand-content": "#7db8dc"},
}


def setup(app: Any) -> None:
    """Tables are shown as they are."""
    app.add_lexer("csv", TextLexer)
