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
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx.ext.mathjax",
    # Ships MathJax with the pages, so that formulas show without a network.
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "equation_index",
    "generated_figures",
    "generated_pages",
    "house_docstrings",
    "live_maps",
]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
# What is generated is included by pages, not a page itself.
exclude_patterns = ["_build", "reference/generated"]
templates_path = ["_templates"]

# A word between single backticks in a docstring is code.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Source", "notes_style"), ("Fields", "params_style")]

# Prompts and what commands print are not copied.
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "copyfile_regex": r".*\.(csv|toml)$",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
    "write_computation_times": False,
    "min_reported_time": 60,
    "reset_modules": ("matplotlib", "example_rules.reset"),
    "reset_modules_order": "both",
    # An example that is unchanged may show something else when the program has changed.
    "run_stale_examples": True,
    "image_srcset": ["2x"],
    "image_scrapers": ("example_rules", "matplotlib"),
}

html_theme = "furo"
html_title = f"infinivar {release}"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["wrap.css", "live-maps.css"]
