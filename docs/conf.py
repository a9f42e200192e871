"""Configuration of the documentation; build it with ``sphinx-build -W --keep-going -b html docs docs/_build/html``."""

import sys
from pathlib import Path

import infinivar

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "infinivar"
author = "The infinivar developers"
copyright = "The infinivar developers"
release = version = infinivar.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "generated_pages",
    "house_docstrings",
]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
# What is generated is included by pages, not a page itself.
exclude_patterns = ["_build", "reference/generated"]

# A word between single backticks in a docstring is code.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Source", "notes_style"), ("Fields", "params_style")]

html_theme = "furo"
html_title = f"infinivar {release}"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["wrap.css"]
