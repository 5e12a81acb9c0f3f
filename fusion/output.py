"""Where results go: names of `fusion.files`."""

from fusion.files.claim import MARK, Claim, claimed
from fusion.files.publish import atomic_file, output_folder

__all__ = ["MARK", "Claim", "atomic_file", "claimed", "output_folder"]
