"""The scripts that `fusion completion` prints, tried in the shells that are here."""

import shutil
import subprocess
from pathlib import Path

import pytest

from fusion.commands.main import main

# what is typed, and what the Tab key must offer, whatever else
TYPED = [
    ("turnt", "turntable"),
    ("turntable --vo", "--voxel"),
    ("turntable rec --strength c", "circle"),
    ("calibrate intr", "intrinsics"),
    ("calibrate depth --radial", "--radial-limit"),
    ("info here.t", "here.txt"),
]
BASH = """
source ./script
words=(fusion "$@"); last=$(($# - 1))
COMP_WORDS=("${words[@]}"); COMP_CWORD=$#; COMP_LINE="${words[*]}"; COMP_POINT=${#COMP_LINE}
_shtab_fusion fusion "${words[$#]}" "${words[$last]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


def asked(shell: str, typed: str, folder: Path) -> str:
    """What the shell offers."""
    if shell == "bash":
        command = ["bash", "-c", BASH, "bash", *typed.split(" ")]
    else:
        command = ["fish", "--no-config", "-c", f"source ./script; complete -C 'fusion {typed}'"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=30)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_offers_commands_options_values_and_files(shell, tmp_path, capsys):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    assert main(["completion", shell]) == 0
    (tmp_path / "script").write_text(capsys.readouterr().out)
    (tmp_path / "here.txt").write_text("")
    if shell == "zsh":  # completes on a terminal only: here it can but be read
        subprocess.run(["zsh", "-n", "script"], cwd=tmp_path, check=True, timeout=30)
        return
    for typed, meant in TYPED:
        assert meant in asked(shell, typed, tmp_path), f"{typed} in {shell}"
