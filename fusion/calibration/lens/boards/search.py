"""The board in all pictures of one camera, and why it was not found."""

import hashlib
from dataclasses import dataclass, field

import numpy as np

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.charuco import find_charuco
from fusion.calibration.lens.boards.detect import find_checkerboard, largest_board
from fusion.calibration.lens.boards.pictures import Picture, place_of, read_picture, usual_size
from fusion.calibration.lens.views import BoardView, view_of
from fusion.errors import RecordingError
from fusion.progress import each

EARLY = 4  # misses without a find, after which it is asked whether the board is another one
FEWEST = 3  # views that a camera needs
ASKED = 4  # pictures that are searched for a board of any size


@dataclass(frozen=True)
class Search:
    """What was found in the pictures of one camera."""

    views: list[BoardView]  # one per picture in which the board was found; their names are the pictures' keys
    size: tuple[int, int]  # (width, height) [px]
    missed: list[str] = field(default_factory=list)  # keys of the pictures without the board
    # key to reason, of pictures that are damaged, have another size or were seen before
    unread: dict[str, str] = field(default_factory=dict)
    pictures: dict[str, Picture] = field(default_factory=dict)  # key to picture, of all


def search(pictures: dict[str, Picture], board: Board) -> Search:
    """Find the board in pictures of one camera; damaged ones and copies are listed, not fatal.

    Raises:
        RecordingError: none can be read, or another board than the stated one is in them.
    """
    find = find_charuco if board.is_charuco else find_checkerboard
    views: list[BoardView] = []
    sizes, missed, unread = {}, [], {}
    seen: dict[bytes, str] = {}  # content of a picture with the board to its key
    for key in each(pictures, "looking for the board"):
        try:
            image = read_picture(pictures[key])
        except RecordingError as error:
            unread[key] = f"{error.what}: {error.found}"
            continue
        digest = hashlib.blake2b(image.tobytes()).digest()
        if digest in seen:  # its noise is that of the first: it tells nothing more
            unread[key] = f"the same picture as {seen[digest]}"
            continue
        sizes[key] = (image.shape[1], image.shape[0])
        found = find(image, board)
        if found is None:
            missed.append(key)
            if len(missed) == EARLY and not views and not board.is_charuco:  # every further miss takes seconds
                _check_counts(Search([], (0, 0), missed, unread, pictures), board, final=False)
        else:
            seen[digest] = key
            views.append(view_of(key, found.pixels, board, found.ids, found.how))
    if not sizes:
        first = next(iter(unread.values()), "no picture")
        raise RecordingError("no picture can be read", next(iter(pictures.values()), ""), first, "PNG or JPEG files")
    size = usual_size(sizes)
    other = {key: f"{s[0]} x {s[1]} px, the others {size[0]} x {size[1]}" for key, s in sizes.items() if s != size}
    kept = [view for view in views if view.name not in other]
    result = Search(kept, size, [k for k in missed if k not in other], unread | other, pictures)
    if not board.is_charuco:
        _check_counts(result, board)
    elif len(result.views) < FEWEST:
        raise _hardly_seen(result, board)
    return result


def _hardly_seen(result: Search, board: Board) -> RecordingError:
    total = len(result.views) + len(result.missed)
    found = f"{len(result.views)} of {total} pictures that show it"
    expected, do = f"{board.columns} x {board.rows} inner corners", "check columns and rows (inner corners)"
    if board.is_charuco:
        expected += f" with markers of {board.dictionary}, {board.marker_m:g} m in squares of {board.square_m:g} m"
        do += ", dictionary and marker_m"
    do += ", light and focus" if board.is_charuco else ", light and focus; the whole board must be in view"
    where = place_of(next(iter(result.pictures.values())))
    # of other markers a ChArUco board may be in them all the same
    what = "the board is hardly seen" if result.views or board.is_charuco else "no board is seen"
    return RecordingError(what, where, found, f"{expected}, in {FEWEST} pictures or more", do)


def _check_counts(result: Search, board: Board, final: bool = True) -> None:
    """Refuse a board with other numbers of corners than stated: part of a larger one, or one that is never found."""
    few = len(result.views) < FEWEST
    keys = result.missed if few else [view.name for view in result.views]
    asked = [keys[i] for i in np.unique(np.linspace(0, len(keys) - 1, min(ASKED, len(keys))).astype(int))]
    seen = [largest_board(read_picture(result.pictures[key])) for key in asked]
    stated = tuple(sorted((board.columns, board.rows)))
    others = [tuple(sorted(s)) for s in seen if s is not None and tuple(sorted(s)) != stated]
    if not few:  # the stated one is found: only a larger one around it, seen twice alike, is worth a word
        others = [s for s in others if s[0] >= stated[0] and s[1] >= stated[1]]
    usual = max(set(others), key=others.count) if others else None
    if usual is not None and (others.count(usual) >= 2 or (few and len(asked) == 1)):
        found = f"{usual[1]} x {usual[0]} inner corners in {others.count(usual)} of {len(asked)} pictures looked at"
        do = "correct columns and rows: inner corners, one less than the squares"
        raise RecordingError(
            "another board is in the pictures", "board.json", found, f"{board.columns} x {board.rows}", do
        )
    if few and final:
        raise _hardly_seen(result, board)
