"""Links of the Markdown lead on in the site as they do in the project.

A link to a document becomes one to its page, which MyST does. What it cannot know: README.md is the page `overview`, an
example is its page in the gallery, and any other file of the project (source, schema) gets a page with its text.
"""

from pathlib import Path
from typing import Any
from urllib.parse import unquote

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

PROJECT = Path(__file__).resolve().parents[2]
README, OVERVIEW = "README.md", "overview"
EXAMPLES = "examples"
FOLDER = "source"  # of the pages with texts of files
LEXERS = {".py": "python", ".json": "json", ".toml": "toml", ".md": "markdown"}
FROM = "source_page"  # attribute of a link that still lacks its address


class Links(SphinxTransform):
    """Every link that MyST took for a download, or could not follow."""

    default_priority = 300  # before Sphinx collects downloads

    def apply(self, **more: Any) -> None:
        found = (addnodes.download_reference, addnodes.pending_xref)
        for node in list(self.document.findall(lambda node: isinstance(node, found))):
            if node.get("reftype") == "myst" and (link := self._followed(node)) is not None:
                node.replace_self(link)

    def _followed(self, node: nodes.Element) -> nodes.Element | None:
        """What stands for the link; None where MyST's own is right."""
        path, _, anchor = unquote(node["reftarget"]).partition("#")
        if node.get("refdomain") == "doc":
            if path in self.env.found_docs:
                return None
            anchor = node.get("reftargetid") or ""
        here = Path(self.env.doc2path(self.env.docname)).parent
        places = [PROJECT / path] if path == EXAMPLES else [here / path, here / f"{path}.md", PROJECT / path]
        file = next((place.resolve() for place in places if path and place.exists()), None)
        if file is None or not file.is_relative_to(PROJECT):
            return None
        name = file.relative_to(PROJECT)
        if str(name) == README:
            return _to_document(node, OVERVIEW, anchor)
        if name.parts[0] == EXAMPLES:
            return _to_document(node, f"{EXAMPLES}/{name.stem if file.is_file() else 'index'}", "")
        if file.is_dir():
            return None
        named(self.env).setdefault(self.env.docname, set()).add(str(name))
        return nodes.reference("", "", *node.children, internal=True, **{FROM: f"{FOLDER}/{name}"})


def _to_document(node: nodes.Element, name: str, anchor: str) -> nodes.Element:
    target = {"reftarget": name, "reftargetid": anchor or None, "refdoc": node["refdoc"], "refexplicit": True}
    return addnodes.pending_xref("", *node.children, refdomain="doc", reftype="myst", **target)


def named(env: Any) -> dict[str, set[str]]:
    """Files that get a page, by the document that links to them; kept with Sphinx's environment."""
    if not hasattr(env, "source_pages"):
        env.source_pages = {}
    found: dict[str, set[str]] = env.source_pages
    return found


def address(app: Sphinx, doctree: nodes.document, name: str) -> None:
    """Links to pages with texts get their addresses, which only the builder knows."""
    for node in doctree.findall(nodes.reference):
        if FROM in node:
            node["refuri"] = app.builder.get_relative_uri(name, node[FROM])


def forget(app: Sphinx, env: Any, name: str) -> None:
    """A document that is read anew names its files anew."""
    named(env).pop(name, None)


def pages(app: Sphinx) -> Any:
    """Name, content and template of each page with a text."""
    for name in sorted(set().union(*named(app.env).values())):
        text = (PROJECT / name).read_text(encoding="utf-8")
        title = f'<h1 class="file">{name}</h1>'
        shown = app.builder.highlighter.highlight_block(text, LEXERS.get(Path(name).suffix, "text"))
        yield f"{FOLDER}/{name}", {"title": name, "body": title + shown, "parents": []}, "page.html"


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_transform(Links)
    app.connect("env-purge-doc", forget)
    app.connect("doctree-resolved", address)
    app.connect("html-collect-pages", pages)
    return {"parallel_read_safe": False}
