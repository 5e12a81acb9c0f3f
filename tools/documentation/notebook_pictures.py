"""Examples show what a notebook shows: the picture of the last value in a block, where it has one."""

from pathlib import Path
from typing import Any

DONE = "__shown__"  # the last value whose picture is on the page


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """sphinx-gallery's scraper: writes the picture beside the page, and returns the lines that show it."""
    from sphinx_gallery.scrapers import figure_rst

    names = block_vars["example_globals"]
    shown = names.get("___")  # what the last line of this block gave, or of one before
    picture = None if shown is names.get(DONE) else getattr(shown, "_repr_png_", lambda: None)()
    if picture is None:
        return ""
    names[DONE] = shown
    path = Path(next(block_vars["image_path_iterator"]))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(picture)
    return str(figure_rst([str(path)], gallery_conf["src_dir"]))
