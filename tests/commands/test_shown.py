"""Names in titles."""

from pathlib import Path

import pytest

from fusion.commands.options.shown import shown_name


@pytest.mark.parametrize(
    ("path", "name"),
    [("/a/my_box", "my_box"), ("/a/owl/scan", "owl/scan"), ("/a/owl/Recording/", "owl/Recording"), ("/scan", "scan")],
)
def test_a_folder_that_is_only_called_scan_is_told_with_the_one_above(path, name):
    """ "Turntable scan scan" stood over a page."""
    assert shown_name(Path(path)) == name


def test_here_has_a_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert shown_name(Path()) == tmp_path.name
