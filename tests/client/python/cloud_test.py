"""Clouds of all kinds become what the API describes, and the encoding is the one specified."""
import array
import unittest
from types import SimpleNamespace
from typing import Any, List

import numpy as np
import zstandard
from crc32c import crc32c

from isthmus import InvalidArgument
from isthmus.cloud import from_message, records_of, to_message
from isthmus.quantized import quantize
from isthmus.v1 import types_pb2

DTYPE = np.dtype({"names": ["x", "y", "z", "intensity", "ring", "time"],
                  "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f8"],
                  "offsets": [0, 4, 8, 16, 20, 24], "itemsize": 40})
NUMBERS = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}


def some_records(count: int = 5000) -> np.ndarray:
    random = np.random.default_rng(5)
    records = np.zeros(count, DTYPE)
    for name in "xyz":
        records[name] = np.cumsum(random.normal(0, 0.3, count))
    records["intensity"] = random.integers(0, 100, count) / 100
    records["ring"] = np.arange(count) % 16
    records["time"] = np.linspace(-0.1, 0, count)
    return records


def as_message(records: np.ndarray, order: str = "<", padding: int = 0,
               height: int = 1) -> Any:
    """As ROS has it."""
    dtype = records.dtype.newbyteorder(order)
    rows = records.astype(dtype).reshape(height, -1)
    data = b"".join(row.tobytes() + bytes(padding) for row in rows)
    fields = [SimpleNamespace(name=name, offset=dtype.fields[name][1], count=1,
                              datatype=NUMBERS[records.dtype[name].str[1:]])
              for name in records.dtype.names]
    return SimpleNamespace(height=height, width=rows.shape[1], fields=fields,
                           is_bigendian=order == ">", point_step=dtype.itemsize,
                           row_step=rows.shape[1] * dtype.itemsize + padding,
                           data=array.array("B", data))


def transform_names(data: bytes, columns: int) -> List[int]:
    return list(data[8:8 + columns])


def decode(message: types_pb2.PointCloud) -> np.ndarray:
    """As docs/storage-format.md says it is to be read."""
    data, n, columns = message.data, message.width * message.height, len(message.fields)
    assert data[:4] == b"IQ\x01\x00" and int.from_bytes(data[4:8], "little") == crc32c(data[8:])
    content = zstandard.ZstdDecompressor().decompress(data[8 + columns:])
    out, at = {}, 0
    for field, transform in zip(message.fields, data[8:8 + columns]):
        code = {v: k for k, v in NUMBERS.items()}[field.type]
        width = 4 if transform == 2 else int(code[1])
        if transform == 3:
            palette = np.frombuffer(content, f"<u{width}", 256, at)
            words = palette[np.frombuffer(content, "u1", n, at + 256 * width)]
            at += 256 * width + n
        else:
            planes = np.frombuffer(content, "u1", n * width, at).reshape(width, n)
            words = np.ascontiguousarray(planes.T).view(f"<u{width}").ravel()
            at += n * width
        if transform == 1:
            words = np.cumsum(words, dtype=words.dtype)
        if transform == 2:
            known = words > 0
            d = words[known].astype(np.int64)
            steps = np.cumsum(np.where(d % 2 == 1, (d - 1) // 2, -(d // 2)))
            values = np.full(n, np.nan)
            values[known] = steps * message.resolution_m
            out[field.name] = values.astype("<" + code)
        else:
            out[field.name] = words.view("<" + code)
    assert at == len(content)
    return out  # type: ignore[return-value]


class CloudTest(unittest.TestCase):
    def test_records_are_described_field_by_field(self) -> None:
        records = some_records()
        message = to_message(records)
        self.assertEqual((message.encoding, message.width, message.height, message.stride),
                         (types_pb2.PointCloud.RAW, len(records), 1, 40))
        self.assertEqual([(f.name, f.offset, f.type) for f in message.fields],
                         [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 16, 7),
                          ("ring", 20, 4), ("time", 24, 8)])
        np.testing.assert_array_equal(from_message(message), records)

    def test_plain_arrays_are_x_y_z_and_intensity(self) -> None:
        for columns, kind in ((3, "f4"), (4, "f4"), (3, "f8"), (4, "i4")):
            array_of = np.arange(columns * 5).reshape(5, columns).astype(kind)
            back = from_message(to_message(np.asfortranarray(array_of)))
            self.assertEqual(back.dtype.names, ("x", "y", "z", "intensity")[:columns])
            np.testing.assert_array_equal([list(row) for row in back.tolist()], array_of)

    def test_no_copy_where_none_is_needed(self) -> None:
        records, plain = some_records(), np.zeros((9, 3), np.float32)
        self.assertTrue(np.shares_memory(records_of(records), records))
        self.assertTrue(np.shares_memory(records_of(plain), plain))
        message = as_message(records)
        self.assertTrue(np.shares_memory(records_of(message), np.frombuffer(message.data, "u1")))

    def test_messages_of_ros_in_all_their_forms(self) -> None:
        records = some_records(480)
        for options in ({}, {"order": ">"}, {"padding": 12, "height": 16}, {"height": 16}):
            message = as_message(records, **options)  # type: ignore[arg-type]
            sent = to_message(message)
            self.assertEqual((sent.height, sent.width), (message.height, message.width))
            back = from_message(sent)
            for name in records.dtype.names:
                np.testing.assert_array_equal(back[name], records[name], f"{options} {name}")

    def test_types_that_the_api_lacks_go_into_the_next(self) -> None:
        records = np.zeros(3, dtype=[("x", ">f4"), ("y", "f2"), ("z", "f4"), ("t", "i8"),
                                     ("valid", "?")])
        records["x"], records["t"], records["valid"] = 1.5, 1_600_000_000_000_000_000, True
        back = from_message(to_message(records))
        self.assertEqual([back.dtype[name].str for name in back.dtype.names],
                         ["<f4", "<f4", "<f4", "<f8", "|u1"])
        self.assertEqual(back[0].tolist(), (1.5, 0, 0, 1.6e18, 1))

    def test_refuses_what_it_cannot_unpack(self) -> None:
        message = to_message(some_records(10))
        for encoding, name in ((types_pb2.PointCloud.DRACO, "DRACO"),
                               (types_pb2.PointCloud.QUANTIZED, "QUANTIZED"), (77, "77")):
            message.encoding = encoding
            with self.assertRaisesRegex(InvalidArgument, f"this one is {name}: ask for .* RAW"):
                from_message(message)

    def test_refuses_what_is_no_cloud(self) -> None:
        message = as_message(some_records(10))
        message.data = message.data[:-1]
        overlapping = as_message(some_records(10))
        overlapping.fields[0].offset = 39
        for points in (np.zeros((5, 2)), np.zeros(5), np.zeros((2, 5, 3)), "cloud", None,
                       np.zeros(3, dtype=[("x", "f4"), ("y", "f4")]), message, overlapping,
                       np.zeros(3, dtype=[("x", "f4"), ("y", "f4"), ("z", "f4"), ("s", "U3")])):
            with self.assertRaises(InvalidArgument, msg=repr(points)[:60]):
                to_message(points)


class QuantizedTest(unittest.TestCase):
    def test_the_worked_example_of_the_specification(self) -> None:
        points = np.array([(1.002, -0.5, 0.2, 10), (1.006, -0.5, 0.199, 10)], dtype="f4")
        message = to_message(points, 0.001)
        self.assertEqual(message.encoding, types_pb2.PointCloud.QUANTIZED)
        self.assertEqual(message.data[:4], b"IQ\x01\x00")
        self.assertEqual(transform_names(message.data, 4)[:3], [2, 2, 2])
        content = zstandard.ZstdDecompressor().decompress(message.data[12:])
        self.assertEqual(content[:24].hex(), "d509070000000000e801030000000000"
                                             "9102010000000000")

    def test_coordinates_are_rounded_and_the_rest_is_kept(self) -> None:
        records = some_records()
        records["x"][7], records["y"][8] = np.nan, np.inf
        message = to_message(records, 0.002)
        self.assertLess(len(message.data), records.nbytes / 2)
        back = decode(message)
        for name in "xyz":
            known = np.isfinite(records[name])
            np.testing.assert_array_equal(np.isnan(back[name]), ~known)
            np.testing.assert_allclose(back[name][known], records[name][known], atol=0.001001)
        for name in ("intensity", "ring", "time"):
            np.testing.assert_array_equal(back[name], records[name])

    def test_every_column_finds_its_transform_back(self) -> None:
        n = 9000
        random = np.random.default_rng(2)
        fields = {"x": np.zeros(n, "f8"), "y": np.full(n, np.nan, "f8"), "z": np.arange(n) / 7.0,
                  "steady": np.arange(n).astype("u4"), "few": random.choice([1.5, 2, 9], n),
                  "noise": random.normal(size=n), "byte": random.integers(0, 255, n).astype("u1")}
        records = np.zeros(n, dtype=[(name, column.dtype) for name, column in fields.items()])
        for name, column in fields.items():
            records[name] = column
        message = to_message(records, 0.001)
        self.assertEqual(transform_names(message.data, 7), [2, 2, 2, 1, 3, 0, 0])
        back = decode(message)
        for name in ("steady", "few", "noise", "byte"):
            np.testing.assert_array_equal(back[name], records[name], name)

    def test_refuses_steps_and_coordinates_out_of_range(self) -> None:
        records = some_records(5)
        for step in (1e-6, 0.5, float("nan"), "fine"):
            with self.assertRaisesRegex(InvalidArgument, "resolution"):
                to_message(records, step)
        records["z"][0] = 6e5
        with self.assertRaisesRegex(InvalidArgument, "farthest"):
            quantize(records, 0.001)


if __name__ == "__main__":
    unittest.main()
