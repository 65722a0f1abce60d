"""Save the figures of examples that were drawn without pyplot, as by feasibee's functions."""

from __future__ import annotations

from typing import Any
from weakref import WeakSet

from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

_known: WeakSet[Figure] = WeakSet()


def _get_sg_image_scraper() -> Any:
    return save_figures


def save_figures(block: Any, variables: dict[str, Any], conf: dict[str, Any]) -> str:
    """Save the figures that a block of code has bound to names, and return the text that shows them.

    It must come before the scraper of pyplot's figures, which closes them.
    """
    _known.update(plt.figure(number) for number in plt.get_fignums())
    paths = []
    for value in variables["example_globals"].values():
        if isinstance(value, Figure) and value not in _known:
            _known.add(value)
            paths.append(next(variables["image_path_iterator"]))
            value.savefig(paths[-1], dpi=150)
    return figure_rst(paths, conf["src_dir"]) if paths else ""
