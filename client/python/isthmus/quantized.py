"""Compressed clouds: coordinates rounded, everything else bit by bit.

The layout is specified in docs/storage-format.md, "Quantised payload". Compared with raw points a
scan of a spinning LiDAR takes about a quarter of the bytes.
"""
from __future__ import annotations

import threading
from typing import Any, Tuple

import numpy as np
import zstandard
from crc32c import crc32c
from numpy.typing import NDArray

from isthmus._arguments import number
from isthmus.errors import InvalidArgument

# As the server takes them.
MIN_RESOLUTION_M, MAX_RESOLUTION_M = 1e-5, 0.1
_MOST_STEPS = 1 << 29  # Differences of coordinates must fit a code of 32 bits.
_ZSTD_LEVEL = 3  # On LiDAR scans the next level gains 1 % for half as much time again.
_PLAIN, _DELTA, _COORDINATE, _PALETTE = range(4)
_PALETTE_SIZE = 256
_SAMPLE = 2048  # Points that tell how a column packs best.

_local = threading.local()  # Compressors serve one thread each.


def check_resolution(resolution: float) -> float:
    """`InvalidArgument` for what is neither 0, which stands for "as they are", nor one of these."""
    given = number("resolution", resolution)
    if given != 0 and not MIN_RESOLUTION_M <= given <= MAX_RESOLUTION_M:
        raise InvalidArgument(f"the resolution must be {MIN_RESOLUTION_M} to {MAX_RESOLUTION_M} m, "
                              f"or 0 for scans as they are; it is {resolution}")
    return given


def quantize(records: NDArray[np.void], resolution: float) -> bytes:
    """The payload of records (N,) with fields x, y, z; those are rounded to `resolution` metres.

    `resolution` is one that `check_resolution` lets pass. `InvalidArgument` for a coordinate beyond
    2^29 steps from the origin. Coordinates that are not finite become NaN.
    """
    transforms, content = bytearray(), []
    coordinates = {"x", "y", "z"}  # The first field of each of these names is a coordinate.
    for name in records.dtype.names or ():
        field = records[name].reshape(len(records), -1)
        first = name.lower() in coordinates
        coordinates.discard(name.lower())
        for column in field.T:
            if first and field.shape[1] == 1 and column.dtype.kind == "f":
                transform, data = _COORDINATE, _planes(_codes(column, resolution))
            else:
                transform, data = _pack(np.ascontiguousarray(column))
            transforms.append(transform)
            content.append(data)
    body = bytes(transforms) + _compress(b"".join(content))
    return b"IQ\x01\x00" + int(crc32c(body)).to_bytes(4, "little") + body


def _compress(content: bytes) -> bytes:
    compressor = getattr(_local, "compressor", None)
    if compressor is None:
        compressor = zstandard.ZstdCompressor(level=_ZSTD_LEVEL, write_content_size=True)
        _local.compressor = compressor
    return bytes(compressor.compress(content))


def _planes(values: NDArray[Any]) -> bytes:
    """The lowest byte of every value, then the second of every value, and so on."""
    return values.view(np.uint8).reshape(len(values), -1).T.tobytes()


def _codes(column: NDArray[Any], resolution: float) -> NDArray[np.uint32]:
    """Of each step the difference to the last one; 0 where there is no value."""
    steps = column.astype(np.float64) * (1.0 / resolution)
    known = np.isfinite(steps)
    if (np.abs(steps[known]) >= _MOST_STEPS).any():
        raise InvalidArgument(f"a coordinate is beyond {_MOST_STEPS * resolution:.6g} m, the "
                              f"farthest that a step of {resolution} m allows")
    whole = np.trunc(steps[known] + np.copysign(0.5, steps[known])).astype(np.int64)
    differences = np.diff(whole, prepend=np.int64(0))
    codes = np.zeros(len(column), dtype=np.uint32)
    codes[known] = np.where(differences >= 0, 1 + 2 * differences, -2 * differences)
    return codes


def _pack(column: NDArray[Any]) -> Tuple[int, bytes]:
    """The transform that packs the column well, and what it makes of it."""
    words = column.view(f"<u{column.dtype.itemsize}")
    middle = (len(words) - min(len(words), _SAMPLE)) // 2
    sample = words[middle:middle + _SAMPLE]
    if _changes(_differences(sample)) * 10 < _changes(sample) * 9:
        return _DELTA, _planes(_differences(words))
    width = words.dtype.itemsize
    shorter = _PALETTE_SIZE * width + len(words) < len(words) * width
    if shorter and len(np.unique(sample)) <= _PALETTE_SIZE:
        values, picks = np.unique(words, return_inverse=True)
        if len(values) <= _PALETTE_SIZE:
            palette = np.zeros(_PALETTE_SIZE, dtype=words.dtype)
            palette[:len(values)] = values
            return _PALETTE, palette.tobytes() + picks.astype(np.uint8).tobytes()
    return _PLAIN, _planes(words)


def _differences(words: NDArray[Any]) -> NDArray[Any]:
    """To the value before, modulo the word."""
    out = words.copy()
    out[1:] -= words[:-1]
    return out


def _changes(words: NDArray[Any]) -> int:
    """How many bytes differ from those of the value before."""
    other = words.copy()
    other[1:] ^= words[:-1]
    return int(np.count_nonzero(other.view(np.uint8)))
