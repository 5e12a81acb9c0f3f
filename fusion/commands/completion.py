"""`fusion completion SHELL`: what a shell needs to complete commands and options with the Tab key."""

import argparse
from pathlib import Path

EXAMPLE = "fusion completion bash > ~/.local/share/bash-completion/completions/fusion"

# shell: where it looks for the script when it starts
SHELLS = {
    "bash": "~/.local/share/bash-completion/completions/fusion      (needs the package bash-completion)",
    "zsh": "~/.zfunc/_fusion      (with fpath=(~/.zfunc $fpath) before compinit in ~/.zshrc)",
    "fish": "~/.config/fish/completions/fusion.fish",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    told = "\n".join(f"  {name:<5}{place}" for name, place in SHELLS.items())
    parser.epilog = f"{parser.epilog}\n\nwhere each shell looks for it when it starts:\n{told}"
    parser.add_argument("shell", choices=tuple(SHELLS), metavar="SHELL", help="bash, zsh or fish")


def run(options: argparse.Namespace) -> None:
    """Print the script."""
    import shtab

    print(shtab.complete(whole(), options.shell))


def whole() -> argparse.ArgumentParser:
    """One parser with all commands and their options inside, which completion needs and nothing else."""
    import shtab

    from fusion.commands.catalogue import COMMANDS, load
    from fusion.commands.main import overview
    from fusion.commands.parser import CommandParser

    parser = overview()
    parts = parser.add_subparsers(parser_class=CommandParser)
    for name, text in COMMANDS.items():
        command = load(name)
        part = parts.add_parser(name, help=text)
        command.add_arguments(part)
    _complete_files(parser, shtab.FILE)
    return parser


def _complete_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Where an option takes a path, or a path or a name, the shell offers files."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                _complete_files(inner, files)
        elif action.type is Path or action.dest in ("sensor", "camera", "poses", "scene"):
            action.complete = files  # type: ignore[attr-defined]
