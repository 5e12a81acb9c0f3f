"""LZF, as PCD files are packed with it (liblzf by M. Lehmann)."""


def unpacked(data: bytes, size: int) -> bytes:
    """The `size` bytes that were packed; ValueError where the data are not whole."""
    out, at = bytearray(), 0
    try:
        while at < len(data):
            control = data[at]
            at += 1
            if control < 32:  # so many bytes, and one, as they are
                end = at + control + 1
                out += data[at:end]
                at = end
                continue
            length = control >> 5
            if length == 7:
                length += data[at]
                at += 1
            start = len(out) - ((control & 31) << 8 | data[at]) - 1
            at += 1
            length += 2
            if start < 0 or len(out) + length > size:
                raise ValueError("packed points that are damaged")
            piece = out[start : start + length]
            while len(piece) < length:  # it reaches into what it makes
                piece += piece[: length - len(piece)]
            out += piece
    except IndexError:
        raise ValueError("packed points that are cut off") from None
    if at != len(data) or len(out) != size:
        raise ValueError(f"{len(out)} of {size} bytes unpacked")
    return bytes(out)
