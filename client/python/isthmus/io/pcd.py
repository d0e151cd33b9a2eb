"""PCD files, version 0.7, as of the Point Cloud Library."""
from __future__ import annotations

import io
import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
from numpy.typing import NDArray

from isthmus._arguments import wrong
from isthmus.errors import InvalidArgument
from isthmus.io.lzf import unpack
from isthmus.io.whole import PathLike, replace_file
from isthmus.pose import Pose

_KINDS = {"I": "i", "U": "u", "F": "f"}
_NEEDED = ("FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT", "DATA")
_LZF_GAINS_AT_MOST = 300  # Bounds what a damaged header can make us allocate.


@dataclass(frozen=True)
class Pcd:
    """`points`: structured array, (N,) or (H, W) where the file is organised. `viewpoint`: where
    the sensor stood, T_data_sensor; identity unless the file says so."""

    points: NDArray[np.void]
    viewpoint: Pose


def read_pcd(path: PathLike) -> Pcd:
    """ascii, binary or binary_compressed."""
    data = Path(path).read_bytes()
    try:
        return _parse(data)
    except (InvalidArgument, ValueError, KeyError, struct.error, OverflowError) as error:
        raise InvalidArgument(f"{os.fspath(path)} is no PCD file: {error}") from None


def write_pcd(path: PathLike, points: NDArray[Any], encoding: str = "binary",
              viewpoint: Pose = Pose()) -> None:
    """`points`: structured array (N,) or (H, W), or floats (N, 3) or (N, 4) as of isthmus.cloud.
    `encoding`: "binary" or "ascii"."""
    replace_file(path, pcd_bytes(points, encoding, viewpoint))


def pcd_bytes(points: NDArray[Any], encoding: str, viewpoint: Pose = Pose()) -> bytes:
    """What `write_pcd` writes."""
    from isthmus.cloud import records_of  # It needs the API's messages, reading does not.
    if encoding not in ("ascii", "binary"):
        raise InvalidArgument(f"the encoding is 'ascii' or 'binary', not '{encoding}'")
    if not isinstance(viewpoint, Pose):
        raise wrong("viewpoint", "an isthmus.Pose", viewpoint)
    records = records_of(points)
    packed = np.zeros(records.shape, dtype=[(name, records.dtype[name]) for name in
                                            records.dtype.names or ()])  # Without gaps.
    for name in packed.dtype.names or ():
        packed[name] = records[name]
    header = _header(packed, encoding, viewpoint).encode()
    if encoding == "binary":
        return header + packed.tobytes()
    text = io.BytesIO()
    columns = [packed[name].reshape(packed.size, -1) for name in packed.dtype.names or ()]
    for row in range(packed.size):
        text.write(" ".join(_text(value) for column in columns
                            for value in column[row]).encode() + b"\n")
    return header + text.getvalue()


def _text(value: Any) -> str:
    return np.format_float_positional(value, trim="-") if value.dtype.kind == "f" else str(value)


def _header(points: NDArray[np.void], encoding: str, viewpoint: Pose) -> str:
    columns: List[Tuple[str, str, int, int]] = []
    for name in points.dtype.names or ():
        kind = points.dtype[name]
        columns.append((name, kind.base.kind.upper(), kind.base.itemsize,
                        int(np.prod(kind.shape, dtype=int))))
    x, y, z, w = viewpoint.quaternion
    place = " ".join(f"{value:.17g}" for value in (*viewpoint.translation, w, x, y, z))
    height, width = points.shape
    return "\n".join([
        "# .PCD v0.7 - Point Cloud Data file format", "VERSION 0.7",
        *(f"{word} {' '.join(str(column[i]) for column in columns)}"
          for word, i in (("FIELDS", 0), ("SIZE", 2), ("TYPE", 1), ("COUNT", 3))),
        f"WIDTH {width}", f"HEIGHT {height}", f"VIEWPOINT {place}",
        f"POINTS {width * height}", f"DATA {encoding}", ""])


def _parse(data: bytes) -> Pcd:
    header, at = _read_header(data)
    width, height = int(header["WIDTH"][0]), int(header["HEIGHT"][0])
    count = width * height
    if min(width, height) < 0 or int(header.get("POINTS", [str(count)])[0]) != count:
        raise InvalidArgument("POINTS is not WIDTH times HEIGHT")
    dtype = _dtype(header)
    encoding = header["DATA"][0]
    if encoding == "ascii":
        points = _parse_ascii(data[at:], dtype, count)
    elif encoding == "binary":
        if len(data) - at < count * dtype.itemsize:
            raise InvalidArgument(f"{count} points of {dtype.itemsize} bytes do not fit "
                                  f"{len(data) - at} bytes of data")
        points = np.frombuffer(data, dtype=dtype, count=count, offset=at).copy()
    elif encoding == "binary_compressed":
        points = _parse_compressed(data[at:], dtype, count)
    else:
        raise InvalidArgument(f"DATA {encoding} is none of ascii, binary, binary_compressed")
    view = [float(word) for word in header.get("VIEWPOINT", "0 0 0 1 0 0 0".split())]
    viewpoint = Pose(view[:3], (*view[4:7], view[3]))
    return Pcd(points.reshape(height, width) if height > 1 else points, viewpoint)


def _read_header(data: bytes) -> Tuple[Dict[str, List[str]], int]:
    header: Dict[str, List[str]] = {}
    at = 0
    while "DATA" not in header:
        end = data.find(b"\n", at)
        if end < 0:
            raise InvalidArgument("its header has no line DATA")
        words = data[at:end].decode("ascii", "replace").split()
        at = end + 1
        if words and not words[0].startswith("#"):
            header[words[0].upper()] = words[1:]
    missing = [word for word in _NEEDED if not header.get(word)]
    if missing:
        raise InvalidArgument(f"its header lacks {', '.join(missing)}")
    return header, at


def _dtype(header: Dict[str, List[str]]) -> Any:
    names = header["FIELDS"]
    counts = header.get("COUNT") or ["1"] * len(names)
    if not len(names) == len(header["SIZE"]) == len(header["TYPE"]) == len(counts):
        raise InvalidArgument("FIELDS, SIZE, TYPE and COUNT have different lengths")
    fields: List[Any] = []
    for i, name in enumerate(names):  # Padding of PCL is called _, perhaps more than once.
        kind = f"<{_KINDS[header['TYPE'][i].upper()]}{int(header['SIZE'][i])}"
        name = name if name != "_" and name not in names[:i] else f"_{i}"
        fields.append((name, kind, (int(counts[i]),)) if int(counts[i]) != 1 else (name, kind))
    try:
        return np.dtype(fields)
    except TypeError as error:
        raise InvalidArgument(f"SIZE and TYPE make no numbers: {error}") from None


def _parse_ascii(text: bytes, dtype: Any, count: int) -> NDArray[np.void]:
    rows = [line.split() for line in text.decode("ascii", "replace").splitlines() if line.strip()]
    points: NDArray[np.void] = np.zeros(count, dtype=dtype)
    if len(rows) < count:
        raise InvalidArgument(f"it has {len(rows)} lines of {count} points")
    at = 0
    for name in dtype.names:
        width = int(np.prod(dtype[name].shape, dtype=int))
        kind = float if dtype[name].base.kind == "f" else int
        try:
            values = [[kind(row[at + k]) for k in range(width)] for row in rows[:count]]
        except IndexError:
            raise InvalidArgument("a line has too few numbers") from None
        points[name] = np.array(values, dtype=dtype[name].base).reshape(points[name].shape)
        at += width
    return points


def _parse_compressed(data: bytes, dtype: Any, count: int) -> NDArray[np.void]:
    packed_size, size = struct.unpack_from("<II", data)
    if size != count * dtype.itemsize or packed_size > len(data) - 8:
        raise InvalidArgument("the sizes of the compressed data do not fit")
    if size > _LZF_GAINS_AT_MOST * max(packed_size, 1):
        raise InvalidArgument("the compressed data is too short for its points")
    plain = unpack(data[8:8 + packed_size], size)
    points: NDArray[np.void] = np.zeros(count, dtype=dtype)
    at = 0
    for name in dtype.names:  # Field by field, not point by point.
        field = dtype[name]
        column = np.frombuffer(plain, dtype=field.base, offset=at,
                               count=count * field.itemsize // field.base.itemsize)
        points[name] = column.reshape(points[name].shape)
        at += count * field.itemsize
    return points
