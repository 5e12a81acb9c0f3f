"""The documentation site: `make docs` builds it into out/site, without a network and with warnings as errors."""

import os
from pathlib import Path

import fusion

os.environ.setdefault("MPLBACKEND", "agg")

project = "fusion"
copyright = "the authors of fusion; Apache-2.0"
release = version = fusion.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "tools.documentation.links",
    "tools.documentation.galleries",
    "tools.documentation.docstrings",
    "tools.documentation.names",
    "tools.documentation.console",
    "tools.documentation.run",
]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # types in signatures: those of numpy, and ours that are not public
exclude_patterns = ["examples/*.ipynb", "examples/*.py", "examples/README.rst"]

# Markdown stays what it is elsewhere: headings have GitHub's anchors, and what is not a document is left to links.py
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4

# single quotes in docstrings mean code
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "none"  # the signature says names alone: shapes and units stand in the text

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "examples",
    "filename_pattern": r"/\d\d_",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "default_thumb_file": str(Path(__file__).parent / "pictures" / "scan.png"),
    "show_memory": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "capture_repr": ("_repr_html_", "__repr__"),
    "image_scrapers": ("matplotlib", "tools.documentation.notebook_pictures.scrape"),
    "ignore_repr_types": "matplotlib",
    "remove_config_comments": True,
}

html_theme = "pydata_sphinx_theme"
html_title = "fusion"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_sidebars = {"index": [], "tutorial": []}
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {"text": "fusion"},
    "show_prev_next": True,
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
