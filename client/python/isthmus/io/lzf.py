"""Unpacks LZF, the compression of PCD's binary_compressed. Private to the package."""
from __future__ import annotations

from isthmus.errors import InvalidArgument


def unpack(packed: bytes, size: int) -> bytes:
    """`size` bytes. A control byte below 32 announces as many literals and one more; others a copy
    of what was unpacked before, by three bits of length (7: another byte adds to it) and 13 of
    distance."""
    out = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end:
            control = packed[at]
            at += 1
            if control < 32:
                if at + control + 1 > end:
                    raise IndexError
                out += packed[at:at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - packed[at] - 1
            at += 1
            length += 2
            if start < 0 or len(out) + length > size:
                raise IndexError
            piece = out[start:start + length]
            while len(piece) < length:  # A copy may run into what it writes.
                piece = piece + piece
            out += piece[:length]
    except IndexError:
        raise InvalidArgument("the compressed data is damaged") from None
    if len(out) != size:
        raise InvalidArgument(f"the compressed data unpacks to {len(out)} bytes, not {size}")
    return bytes(out)
