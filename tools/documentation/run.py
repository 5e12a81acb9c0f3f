"""The directive `run`: what a page shows was run while it was built, and what came out stands below it.

    ```{run}
    fusion info my_scan
    ```

    ```{run} python
    :picture: owl.png
    ...
    ```

Lines are commands, run one after the other without a shell; with `python` the whole is one program, and `picture` a
file that it writes, shown below. All of a page's run in one folder of its own, which is empty when the page is begun.
With `hidden` only the picture is
shown. A command that fails ends the build.
"""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

PROJECT = Path(__file__).resolve().parents[2]
LONGEST = 300  # [s] of a command; the tutorial's longest takes 35 on two busy cores


class Run(SphinxDirective):
    """Code, what it printed, the picture that it made."""

    optional_arguments, has_content = 1, True
    option_spec = {  # noqa: RUF012 - docutils' own form
        "picture": directives.unchanged,
        "alt": directives.unchanged,
        "hidden": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        place = folder(self.env, self.env.docname)
        text = "\n".join(self.content)
        if self.arguments == ["python"]:
            made: list[nodes.Node] = [nodes.literal_block(text, text, language="python")]
            if told := output([sys.executable, "-c", text], place):
                made.append(nodes.literal_block(told, told, language="text", classes=["printed"]))
        else:
            shown = "".join(f"$ {line}\n{output(shlex.split(line), place)}" for line in self.content).rstrip()
            made = [nodes.literal_block(shown, shown, language="console")]
        if "hidden" in self.options:
            made = []
        if name := self.options.get("picture"):
            page = Path(self.env.doc2path(self.env.docname)).parent
            uri = os.path.relpath(place / name, page)
            made.append(nodes.image(uri=uri, alt=self.options.get("alt", "what the lines above draw")))
        return made


def output(command: list[str], place: Path) -> str:
    """What it printed on standard output. Raises ExtensionError where it fails."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    modules = os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PATH": path, "PYTHONPATH": modules, "COLUMNS": "100"}
    done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True, timeout=LONGEST)
    if done.returncode:
        raise ExtensionError(f"{shlex.join(command)} ended with {done.returncode}: {done.stderr or done.stdout}")
    return done.stdout


def folder(env: Any, name: str) -> Path:
    """Where a page's commands run."""
    place = Path(env.doctreedir).parent / "run" / name
    place.mkdir(parents=True, exist_ok=True)
    return place


def begin(app: Sphinx, env: Any, name: str) -> None:
    """A page that is read anew finds nothing of the last time."""
    shutil.rmtree(Path(env.doctreedir).parent / "run" / name, ignore_errors=True)


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("run", Run)
    app.connect("env-purge-doc", begin)
    return {"parallel_read_safe": False}
