"""An archive that is asked again gives what is in it now."""

import zipfile

from fusion.errors import RecordingError
from fusion.files.tree import open_tree


def packed(path, **files):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)


def test_an_archive_that_was_replaced_is_listed_anew(tmp_path):
    path = tmp_path / "x.zip"
    packed(path, metadata="one")
    assert open_tree(path, RecordingError, "metadata").read("metadata") == b"one"
    assert open_tree(path, RecordingError, "metadata").read("metadata") == b"one"
    packed(path, metadata="three", more="x")
    tree = open_tree(path, RecordingError, "metadata")
    assert tree.read("metadata") == b"three" and tree.has("more")
