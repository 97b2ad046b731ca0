# SPDX-License-Identifier: Apache-2.0
"""How Sphinx makes the pages and the reference of this folder into HTML: `make docs`, without a network."""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import reference_pages

project = "robotskin"
author = "The robotskin authors"
release = importlib.metadata.version("robotskin")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon"]
exclude_patterns = ["README.md", "results", "living"]
html_theme = "furo"
html_title = f"robotskin {release}"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
# Pages link to files of the checkout, which are no pages; tests/test_pages.py says that they are there.
suppress_warnings = ["myst.xref_missing", "myst.header"]

default_role = "code"
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"show-inheritance": True}


def setup(app):
    """Write the pages of the reference before the sources are read."""
    app.connect("builder-inited", lambda app: reference_pages.write(Path(app.srcdir) / "reference"))
