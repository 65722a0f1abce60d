"""Configuration of the documentation site: `make docs` builds it into docs/_build/html, without network."""

import os
import sys
import warnings
from importlib.metadata import version as installed
from pathlib import Path

from feasibee.base.cache import cache_root, own_folder

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_extensions"), str(HERE.parent)]  # our extensions, and claims/
os.environ.setdefault("MPLCONFIGDIR", str(own_folder(cache_root()) / "matplotlib"))  # not in the user's home
warnings.filterwarnings("error", module=r"(__main__|feasibee)")  # in an example
warnings.filterwarnings("ignore", module=r"(sphinx|myst)")  # not in our code

project = "feasibee"
author = "the feasibee maintainers"
project_copyright = f"{author}; Apache-2.0"
version = release = installed("feasibee")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "check",
    "claimed",
    "commands",
    "fields",
    "names",
    "outcomes",
    "page",
    "sessions",
    "speed",
]
exclude_patterns = ["_build", "_extensions", "made", "gallery/**/*.ipynb", "gallery/*.md5", "gallery/*.py"]
smartquotes = False  # it turns the two hyphens of an option into a dash
default_role = "py:obj"
nitpicky = True
nitpick_ignore = [("py:obj", "ANY"), ("py:obj", "PLACES")]
nitpick_ignore_regex = [  # inventories of other projects are not fetched
    ("py:.*", r"(xarray|xr|numpy|np|matplotlib|pandas|pydantic|concurrent|typing|collections|pathlib)\..*"),
]

myst_enable_extensions = ["attrs_inline", "deflist"]
myst_heading_anchors = 4

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

autodoc_typehints = "none"  # the docstrings have dtype, shape, unit
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/plot_",
    "thumbnail_size": (800, 560),  # pixels: twice as many as are shown
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("figures", "matplotlib"),
    "abort_on_example_error": False,  # report all failures; each is a warning, which is an error
    "only_warn_on_example_error": True,
    "download_all_examples": False,
    "notebook_extensions": set(),
    "show_memory": False,
    "capture_repr": (),
    "run_stale_examples": True,  # their output depends on the engine, too
    "show_signature": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "backreferences_dir": None,
}

html_theme = "furo"
html_title = f"feasibee {version}"
html_favicon = ICON = "../src/feasibee/live/static/icon.svg"
html_static_path = ["_static", ICON]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_logo": Path(ICON).name,
    "dark_logo": "icon-dark.svg",
    "light_css_variables": {"color-brand-primary": "#0060a0", "color-brand-content": "#0060a0"},
    "dark_css_variables": {"color-brand-primary": "#6cb8ee", "color-brand-content": "#6cb8ee"},
}
