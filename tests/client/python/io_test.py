"""Files are read as they were written, by whomever; damaged ones are refused."""
import unittest
from pathlib import Path

import numpy as np

from isthmus import InvalidArgument, Pose
from isthmus.io import read_kitti_bin, read_pcd, read_tum, write_pcd, write_tum
from isthmus.io.lzf import unpack
from servers import drives, temporary_folder

RECORDS = np.array([(1.5, -2, 1e-7, 7, 3, -0.1), (np.nan, 4, 5, 8, 65535, 0)],
                   dtype=[("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "u1"),
                          ("ring", "u2"), ("time", "f8")])


class PcdTest(unittest.TestCase):
    def setUp(self) -> None:
        self.path = temporary_folder() / "cloud.pcd"

    def test_what_is_written_is_read(self) -> None:
        viewpoint = Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.9))
        for encoding in ("ascii", "binary"):
            write_pcd(self.path, RECORDS, encoding, viewpoint)
            pcd = read_pcd(self.path)
            self.assertEqual((pcd.points.dtype, pcd.points.tobytes()),
                             (RECORDS.dtype, RECORDS.tobytes()))
            np.testing.assert_allclose(pcd.viewpoint.matrix(), viewpoint.matrix(), atol=1e-15)
        self.assertEqual([path.name for path in self.path.parent.iterdir()], ["cloud.pcd"])

    def test_organised_clouds_and_plain_arrays(self) -> None:
        rows = np.tile(RECORDS, (3, 1))
        write_pcd(self.path, rows)
        again = read_pcd(self.path).points
        self.assertEqual((again.shape, again.tobytes()), ((3, 2), rows.tobytes()))
        write_pcd(self.path, np.ones((5, 3)))
        self.assertEqual(read_pcd(self.path).points["z"].tolist(), [1] * 5)
        write_pcd(self.path, np.ones((0, 3)))
        self.assertEqual(len(read_pcd(self.path).points), 0)

    def test_fields_with_several_values_and_padding(self) -> None:
        self.path.write_text("# made by hand\nVERSION .7\nFIELDS x y z _ normal\nSIZE 4 4 4 1 4\n"
                             "TYPE F F F U F\nCOUNT 1 1 1 4 3\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n"
                             "DATA ascii\n1 2 3 0 0 0 0 0 0 1\n\n4 5 6 0 0 0 0 1 0 0\n")
        points = read_pcd(self.path).points
        self.assertEqual(points["y"].tolist(), [2, 5])
        self.assertEqual(points["normal"].tolist(), [[0, 0, 1], [1, 0, 0]])

    def test_scans_of_the_simulator(self) -> None:
        points = read_pcd(next((drives() / "robot_0").glob("*.pcd"))).points
        self.assertEqual(points.dtype.names, ("x", "y", "z", "intensity", "ring", "time"))
        self.assertGreater(len(points), 20000)
        self.assertLess(points["time"].max(), 1e-9)

    def test_damaged_files_are_refused(self) -> None:
        write_pcd(self.path, RECORDS)
        whole = self.path.read_bytes()
        for broken in (b"", whole[:40], whole[:-1], whole.replace(b"WIDTH 2", b"WIDTH -2"),
                       whole.replace(b"POINTS 2", b"POINTS 3"),
                       whole.replace(b"SIZE 4", b"SIZE 3"), whole.replace(b"TYPE F", b"TYPE Q"),
                       whole.replace(b"COUNT 1 1", b"COUNT 1"),
                       whole.replace(b"WIDTH 2", b"WIDTH 99999999999"),
                       whole.replace(b"DATA binary", b"DATA ascii"),
                       whole.replace(b"DATA binary", b"DATA binary_compressed")):
            self.path.write_bytes(broken)
            with self.assertRaisesRegex(InvalidArgument, "cloud.pcd"):
                read_pcd(self.path)
        with self.assertRaises(FileNotFoundError):
            read_pcd(self.path.with_name("none.pcd"))


class LzfTest(unittest.TestCase):
    def test_literals_copies_and_copies_of_themselves(self) -> None:
        self.assertEqual(unpack(b"\x02abc", 3), b"abc")
        self.assertEqual(unpack(b"\x02abc\x20\x02", 6), b"abcabc")  # 3 bytes from 3 before.
        self.assertEqual(unpack(b"\x00a\xe0\x01\x00", 11), b"a" * 11)  # Copies itself: 7 + 1 + 2.

    def test_damage(self) -> None:
        for packed in (b"\x02ab", b"\x20\x00", b"\x00a\x20\x05", b"\xe0", b"\x02abc\xe0\xff\x00"):
            with self.assertRaises(InvalidArgument):
                unpack(packed, 6)


class KittiTest(unittest.TestCase):
    def test_four_floats_a_point(self) -> None:
        path = temporary_folder() / "000000.bin"
        np.arange(8, dtype="f4").tofile(path)
        self.assertEqual(read_kitti_bin(path).tolist(), [(0, 1, 2, 3), (4, 5, 6, 7)])
        path.write_bytes(bytes(17))
        with self.assertRaisesRegex(InvalidArgument, "000000.bin"):
            read_kitti_bin(path)


class TumTest(unittest.TestCase):
    def test_every_nanosecond_is_kept(self) -> None:
        path = temporary_folder() / "a.tum"
        stamps = np.array([-1, 0, 1_600_000_000_123_456_789], dtype=np.int64)
        poses = [Pose((k, 0.25, -k), (0, 0, 0.6, 0.8)) for k in range(3)]
        write_tum(path, stamps, poses)
        self.assertEqual(path.read_text().split()[0], "-0.000000001")
        again, matrices = read_tum(path)
        np.testing.assert_array_equal(again, stamps)
        np.testing.assert_allclose(matrices, [pose.matrix() for pose in poses], atol=1e-12)
        write_tum(path, again, matrices)
        np.testing.assert_allclose(read_tum(path)[1], matrices, atol=1e-8)

    def test_the_truth_of_the_simulator(self) -> None:
        stamps, matrices = read_tum(drives() / "robot_0.truth.tum")
        self.assertEqual(matrices.shape, (len(stamps), 4, 4))
        self.assertTrue((np.diff(stamps) > 0).all())

    def test_what_is_no_pose_is_named_by_its_line(self) -> None:
        path: Path = temporary_folder() / "a.tum"
        for line in ("1 2 3", "1 0 0 0 0 0 0 0", "x 0 0 0 0 0 0 1", "1 0 0 nan 0 0 0 1",
                     "nan 0 0 0 0 0 0 1"):
            path.write_text(f"# stamp ...\n\n{line}\n")
            with self.assertRaisesRegex(InvalidArgument, "line 3"):
                read_tum(path)
        with self.assertRaises(InvalidArgument):
            write_tum(path, [1, 2], [Pose()])


if __name__ == "__main__":
    unittest.main()
