"""A page that simulates: one HTML file with the paper's world, compiled from C to WebAssembly."""

from __future__ import annotations

from feasibee.page.document import page_of, write_page

__all__ = ["page_of", "write_page"]
