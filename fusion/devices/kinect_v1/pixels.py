"""Bytes of a frame become images: values of 11 and 10 bits, Bayer colours."""

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.devices.kinect_v1.packets import RawFrame
from fusion.recording.cameras.zero_plane import NO_VALUE

SHAPE = (480, 640)
IR_ROWS = 488  # eight more than depth has


def raw_depth(frame: RawFrame) -> NDArray[np.uint16]:
    """(480, 640) raw values of 11 bits, 2047 where nothing was measured or did not come."""
    values = unpack_11(frame.data)
    for begin, end in frame.holes:  # a value that lies in the hole with any of its bits
        values[8 * begin // 11 : -(-8 * end // 11)] = NO_VALUE
    return values.reshape(SHAPE)


def infrared(frame: RawFrame) -> NDArray[np.uint16]:
    """(480, 640) of 10 bits, 0 where nothing came; the last eight of 488 rows are left out."""
    values = unpack_10(frame.data)
    for begin, end in frame.holes:
        values[8 * begin // 10 : -(-8 * end // 10)] = 0
    return values.reshape(IR_ROWS, SHAPE[1])[: SHAPE[0]]


def color(frame: RawFrame) -> NDArray[np.uint8]:
    """(480, 640, 3) RGB of a Bayer image whose rows begin G R and B G; black where nothing came."""
    bayer = np.frombuffer(frame.data, np.uint8).reshape(SHAPE)
    return np.asarray(cv2.cvtColor(bayer, cv2.COLOR_BayerGRBG2RGB), np.uint8)


def unpack_11(data: bytes | bytearray) -> NDArray[np.uint16]:
    """Values of 11 bits in one stream of bits, the highest first: 8 of them in 11 bytes."""
    by_group = np.frombuffer(data, np.uint8).reshape(-1, 11).T
    a, b, c, d, e, f, g, h, i, j, k = by_group.astype(np.uint16, order="C")
    values = np.empty((8, a.size), np.uint16)
    values[0] = a << 3 | b >> 5
    values[1] = (b & 31) << 6 | c >> 2
    values[2] = (c & 3) << 9 | d << 1 | e >> 7
    values[3] = (e & 127) << 4 | f >> 4
    values[4] = (f & 15) << 7 | g >> 1
    values[5] = (g & 1) << 10 | h << 2 | i >> 6
    values[6] = (i & 63) << 5 | j >> 3
    values[7] = (j & 7) << 8 | k
    return np.ascontiguousarray(values.T).reshape(-1)


def unpack_10(data: bytes | bytearray) -> NDArray[np.uint16]:
    """The same for 10 bits: 4 values in 5 bytes."""
    a, b, c, d, e = np.frombuffer(data, np.uint8).reshape(-1, 5).T.astype(np.uint16, order="C")
    values = np.empty((4, a.size), np.uint16)
    values[0] = a << 2 | b >> 6
    values[1] = (b & 63) << 4 | c >> 4
    values[2] = (c & 15) << 6 | d >> 2
    values[3] = (d & 3) << 8 | e
    return np.ascontiguousarray(values.T).reshape(-1)
