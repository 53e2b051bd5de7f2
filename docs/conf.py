"""How the pages are built: `sphinx-build -W --keep-going -b html docs build/docs`."""

import sys
from pathlib import Path

from motionmend import __version__

sys.path.insert(0, str(Path(__file__).parent))

project, author, release = "motionmend", "the motionmend developers", __version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "house",  # before napoleon: it puts docstrings as napoleon reads them
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["templates"]
exclude_patterns = ["templates"]
default_role = "code"
myst_heading_anchors = 3

html_theme = "furo"
html_title = "motionmend"
html_show_copyright = False
html_theme_options = {"light_css_variables": {"code-font-size": "75%"}}

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_custom_sections = ["Source"]
napoleon_use_rtype = False
python_maximum_signature_line_length = 100

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "copyfile_regex": "",
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "within_subsection_order": "house.InOrder",
    "reset_modules": ("matplotlib", "house.figures_as_in_reports"),
}
