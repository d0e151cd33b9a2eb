"""Point clouds on their way to the server and back.

Points are given as any of

* a float array (N, 3) of x y z, or (N, 4) of x y z intensity;
* a numpy structured array, (N,) or (H, W) with a ring per row, with fields x, y, z and any others:
  `intensity`, `ring`, `time` are used where they are there, the rest is carried along; times that
  are all 0 say that a scan is motion-compensated already;
* a message like `sensor_msgs/PointCloud2`: anything with height, width, fields, point_step, data.

Lengths are metres, in the frame that the call asks for. `InvalidArgument` for anything else.
"""
from __future__ import annotations

from typing import Any, Dict, List, Tuple

import numpy as np
from numpy.typing import NDArray

from isthmus.errors import InvalidArgument
from isthmus.quantized import check_resolution, quantize
from isthmus.v1 import types_pb2

Points = Any  # One of the above.
Records = NDArray[np.void]


def xyz(points: Records) -> NDArray[np.float32]:
    """The coordinates of points with the fields x, y, z, as of `Client.query`: (N, 3), metres."""
    out: NDArray[np.float32] = np.empty((len(points), 3), np.float32)
    for k, name in enumerate(("x", "y", "z")):
        out[:, k] = points[name]
    return out

# Numbers of PointField.Type, which are those of sensor_msgs/PointField.
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_NUMBERS = {code: number for number, code in _TYPES.items()}
# Types that the API lacks, and those that replace them. 64-bit integers become float64, which keeps
# stamps of nanoseconds to a quarter of a microsecond; long doubles become float64, too.
_REPLACED = {"b1": "u1", "f2": "f4", "i8": "f8", "u8": "f8", "f16": "f8"}


def records_of(points: Points) -> Records:
    """The points as a structured array (H, W), little endian, without a copy where possible."""
    try:
        if all(hasattr(points, name) for name in ("point_step", "fields", "data")):
            return _of_message(points)
        array = np.asarray(points)
        records = _of_plain(array) if array.dtype.names is None else _sendable(array)
    except InvalidArgument:
        raise
    except (AttributeError, TypeError, ValueError, OverflowError) as error:  # NumPy's own.
        raise InvalidArgument(f"these are no points, see isthmus.cloud: {error}") from None
    if records.ndim not in (1, 2):
        raise InvalidArgument(f"points are (N,) or (H, W) records, not {records.shape}")
    return records.reshape(1, -1) if records.ndim == 1 else records


def to_message(points: Points, resolution: float = 0.0) -> types_pb2.PointCloud:
    """The cloud as it is sent: quantised to `resolution` metres, or raw where that is 0."""
    resolution = check_resolution(resolution)
    records = records_of(points)
    columns = _columns(records.dtype)
    names = [name.lower() for name, _, _, _ in columns]
    missing = [name for name in "xyz" if name not in names]
    if missing:
        raise InvalidArgument(f"the cloud has no field {', '.join(missing)}; it has "
                              f"{', '.join(names) or 'none'}")
    message = types_pb2.PointCloud(encoding=types_pb2.PointCloud.RAW, height=records.shape[0],
                                   width=records.shape[1], stride=records.dtype.itemsize)
    for name, number, offset, count in columns:
        message.fields.add(name=name, type=number, offset=offset, count=count)
    if resolution != 0 and records.size > 0:
        message.encoding = types_pb2.PointCloud.QUANTIZED
        message.resolution_m = resolution
        message.data = quantize(records.reshape(-1), resolution)
    else:
        message.data = records.tobytes()
    return message


def from_message(cloud: types_pb2.PointCloud) -> Records:
    """The records (N,) of a raw cloud that the server sent, by the names of its fields."""
    if cloud.encoding != types_pb2.PointCloud.RAW and cloud.width > 0:
        known = types_pb2.PointCloud.Encoding.DESCRIPTOR.values_by_number
        name = known[cloud.encoding].name if cloud.encoding in known else cloud.encoding
        raise InvalidArgument(f"this client reads RAW clouds only, and this one is {name}: ask for "
                              "encoding RAW")
    dtype = _dtype([(f.name, f.type, f.offset, f.count or 1) for f in cloud.fields], cloud.stride)
    return np.frombuffer(cloud.data, dtype=dtype)


def _columns(dtype: np.dtype[Any]) -> List[Tuple[str, int, int, int]]:
    """Name, number of the type, offset and count of each field."""
    out = []
    for name in dtype.names or ():
        field, offset = _fields(dtype)[name][:2]
        count = int(np.prod(field.shape, dtype=int)) if field.shape else 1
        out.append((name, _NUMBERS[field.base.str[1:]], offset, count))
    return out


def _fields(dtype: np.dtype[Any]) -> Dict[str, Any]:
    return dict(dtype.fields or {})


def _dtype(fields: List[Tuple[str, int, int, int]], stride: int, order: str = "<") -> Any:
    formats = []
    for name, number, _, count in fields:
        if number not in _TYPES:
            raise InvalidArgument(f"field '{name}' has no known type: {number}")
        formats.append((order + _TYPES[number], (count,)) if count > 1 else order + _TYPES[number])
    layout: Any = {"names": [name for name, _, _, _ in fields], "formats": formats,
                              "offsets": [offset for _, _, offset, _ in fields], "itemsize": stride}
    try:
        return np.dtype(layout)
    except (ValueError, TypeError) as error:
        raise InvalidArgument(
            f"the fields do not fit a record of {stride} bytes: {error}") from None


def _of_plain(array: NDArray[Any]) -> Records:
    if array.ndim != 2 or array.shape[1] not in (3, 4) or array.dtype.kind not in "fiu":
        raise InvalidArgument("points are an array (N, 3) of x y z, (N, 4) of x y z intensity, a "
                              f"structured array or a PointCloud2; not {array.dtype} of shape "
                              f"{array.shape}")
    code = "<f8" if array.dtype.kind == "f" and array.dtype.itemsize == 8 else "<f4"
    names = ("x", "y", "z", "intensity")[:array.shape[1]]
    packed = np.ascontiguousarray(array, dtype=code)
    return packed.reshape(-1).view(np.dtype([(name, code) for name in names]))


def _sendable(array: NDArray[Any]) -> Records:
    """With types that the API has, little endian; itself where it is so already."""
    formats: Dict[str, Any] = {}
    same = array.dtype.itemsize > 0
    for name in array.dtype.names or ():
        field = _fields(array.dtype)[name][0]
        code = field.base.str[1:]
        wanted = _REPLACED.get(code, code)
        if wanted not in _NUMBERS:
            raise InvalidArgument(f"field '{name}' cannot be sent: {field} is no number")
        formats[name] = ("<" + wanted, field.shape) if field.shape else "<" + wanted
        same = same and field.base.newbyteorder("<") == field.base and wanted == code
    if same:
        return array
    out: Records = np.zeros(array.shape, dtype=np.dtype(list(formats.items())))
    for name in formats:
        out[name] = array[name]
    return out


def _of_message(message: Any) -> Records:
    fields = [(str(f.name), int(f.datatype), int(f.offset), int(f.count) or 1)
              for f in message.fields]
    step, width, height = int(message.point_step), int(message.width), int(message.height)
    order = ">" if getattr(message, "is_bigendian", False) else "<"
    dtype = _dtype(fields, step, order)
    row = int(getattr(message, "row_step", 0)) or width * step
    data = message.data
    flat = np.frombuffer(bytes(data) if isinstance(data, (list, tuple)) else data, dtype=np.uint8)
    if row < width * step or flat.size < height * row - (row - width * step if height else 0):
        raise InvalidArgument(f"{width} x {height} points of {step} bytes in rows of {row} do not "
                              f"fit {flat.size} bytes of data")
    if width * height == 0:
        return np.zeros((height, width), dtype=dtype.newbyteorder("<"))
    rows: Records = np.ndarray((height, width), dtype=dtype, buffer=flat, strides=(row, step))
    return _sendable(rows)
