"""Arguments that make no sense: told by name, in an error of ours, before anything is sent."""
import contextlib
import datetime
import inspect
import itertools
import os
import unittest
from pathlib import Path
from typing import Any, Callable, Tuple
from unittest import mock

import numpy as np

import isthmus
import isthmus.io
from fake_server import FakeServer
from isthmus import InvalidArgument, Pose
from isthmus.v1 import map_service_pb2 as pb
from servers import temporary_folder

Call = Callable[[isthmus.Client], Any]
POINTS = np.zeros((4, 3), np.float32)
NOBODY = {"timeout": 0, "require_server": False}
EPOCH_2020_NS = 1_577_836_800 * 10**9

# Calls with a wrong argument, and what the message names. A call that was sent would be
# `Unavailable`.
WRONG: Tuple[Tuple[Call, str], ...] = (
    (lambda c: c.query(component=-1), "component"),
    (lambda c: c.query(component=1.5), "component"),
    (lambda c: c.query(box=((0, 0, 0), (1, 1))), "box"),
    (lambda c: c.query(box=(0, 0, 0, 1, 1, 1)), "box"),
    (lambda c: c.query(box=((0, 0, 0), (1, 1, np.nan))), "box"),
    (lambda c: c.query(sphere=(0, 0, 0, 1)), "sphere"),
    (lambda c: c.query(sphere=((0, 0), 1)), "sphere"),
    (lambda c: c.query(sphere=((0, 0, 0), "wide")), "radius"),
    (lambda c: c.query(shape=((0, 0, 0), 1)), "shape"),
    (lambda c: c.query(shape=isthmus.Polygon([(0, 0, 0)])), "corners"),
    (lambda c: c.query(shape=isthmus.Polygon([(0, 0), (1, 0), (1, 1)], 3)), "heights"),
    (lambda c: c.query(shape=isthmus.Corridor([(0, 0)], 1)), "path"),
    (lambda c: c.query(shape=isthmus.OrientedBox(np.eye(4), (1, 1, 1))), "T_map_box"),
    (lambda c: c.query(resolution="fine"), "resolution"),
    (lambda c: c.query(max_points=-1), "max_points"),
    (lambda c: c.query(robot=7), "robot"),
    (lambda c: c.query(sessions=7), "sessions"),
    (lambda c: c.query(sessions=[7]), "sessions"),
    (lambda c: c.query(seen_from_ns="2020"), "seen_from_ns"),
    (lambda c: c.find_changes(since_ns=1.5), "since_ns"),
    (lambda c: c.find_changes(since_ns=1, box=1), "box"),
    (lambda c: c.find_changes(since_revision="x"), "since_revision"),
    (lambda c: c.get_trajectory("alice", segment=-1), "segment"),
    (lambda c: c.trajectory(7), "robot"),
    (lambda c: c.get_session(7), "session"),
    (lambda c: c.wait(timeout_s="long"), "timeout_s"),
    (lambda c: next(c.watch(every_s="often")), "every_s"),
    (lambda c: next(c.watch(since="x")), "since"),
    (lambda c: next(c.watch_map(since=5)), "since"),
    (lambda c: c.list_tiles(level="x"), "level"),
    (lambda c: c.get_tile((0, 0, 1, 1)), "tile"),
    (lambda c: c.get_tile(isthmus.TileId(0, -1, 1, 1)), "level"),
    (lambda c: c.list_events(kinds=5), "kinds"),
    (lambda c: c.list_events(kinds=["nonsense"]), "session-opened"),
    (lambda c: c.list_events(since_ns=np.datetime64("NaT")), "since_ns"),
    (lambda c: c.list_events(-1), "after"),
    (lambda c: c.create_token("x", "king"), "operator"),
    (lambda c: c.create_token("x", 77), "role"),
    (lambda c: c.create_token("x", "robot", expires_ns=datetime.datetime(2200, 1, 1)), "time zone"),
    (lambda c: c.revoke_token(5), "name"),
    (lambda c: c.create_session("alice", "vlp16", np.eye(4)), "T_base_sensor"),
    (lambda c: c.create_session("alice", "vlp16", odometry=[]), "odometry"),
    (lambda c: c.create_session(7, "vlp16"), "robot"),
    (lambda c: c.decide_match("a", "b", "perhaps"), "withdraw"),
    (lambda c: c.decide_match("a", "b", "set", np.eye(4)), "T_a_b"),
    (lambda c: c.decide_loop("x"), "id"),
    (lambda c: c.set_anchor("alice", (1, 2)), "position"),
    (lambda c: c.set_anchor("alice", (1, 2, 3), yaw="north"), "yaw"),
    (lambda c: c.put_anchor("alice", Pose(), sigma_xy="near"), "sigma_xy"),
    (lambda c: c.put_anchor("alice", (1, 2, 3)), "T_map_submap"),
    (lambda c: c.remove_anchor(("alice-1",)), "a submap"),
    (lambda c: c.remove_anchor(("alice-1", -1)), "a submap"),
    (lambda c: c.set_datum((48.1, 11.5)), "datum"),
    (lambda c: c.set_datum(isthmus.Datum("north", 11.5)), "latitude_deg"),
    (lambda c: c.list_revisions(-1), "limit"),
    (lambda c: c.undo_revision("x"), "revision"),
    (lambda c: c.diff_revisions(1.5), "from_revision"),
    (lambda c: c.push("alice", None, "vlp16"), "scans"),
    (lambda c: c.push("alice", [POINTS], "vlp16"), "scan 1 is"),
    (lambda c: c.push("alice", [(1, 2, 3)], "vlp16"), "scan 1 is"),
    (lambda c: c.push("alice", [("noon", POINTS)], "vlp16"), "the stamp of scan 1"),
    (lambda c: c.push("alice", [(float("nan"), POINTS)], "vlp16"), "the stamp of scan 1"),
    (lambda c: c.push("alice", [(1 << 63, POINTS)], "vlp16"), "the stamp of scan 1"),
    (lambda c: c.push("alice", [(1, POINTS)], "vlp16", resolution=1), "resolution"),
    (lambda c: c.push("alice", [(1, POINTS)], "vlp16", window=0), "window"),
    (lambda c: next(c.localise([POINTS], "vlp16")), "scan 1 is"),
    (lambda c: c.open_localisation("vlp16", resolution="fine"), "resolution"),
    (lambda c: c.upload("alice", [POINTS]), "a submap"),
    (lambda c: c.upload("alice", [isthmus.OwnSubmap(POINTS, keyframes=[3])]), "a keyframe"),
    (lambda c: c.upload("alice", [isthmus.OwnSubmap(POINTS, np.eye(4))]), "T_odom_submap"),
    (lambda c: c.upload("alice", [isthmus.OwnSubmap(POINTS, last_stamp_ns="x")]), "last_stamp_ns"),
    (lambda c: c.upload_submap("alice-1", -1, isthmus.OwnSubmap(POINTS)), "index"),
    (lambda c: c.export("m.npy"), "m.npy"),
    (lambda c: c.export("m.txt", "pcd"), ".pcd"),
    (lambda c: c.export("m"), "does not tell the format"),
    (lambda c: c.export("m."), "does not tell the format"),
    (lambda c: c.export("m.nav2"), "does not tell the format"),
    (lambda c: c.export("m.yaml"), "export_floors"),
    (lambda c: c.export("m.png", "pcd"), "isthmus picture"),
    (lambda c: c.export("m.laz"), "m.laz"),
    (lambda c: c.export("m.pcd", "ot"), ".ot"),
    (lambda c: c.export("m.pcd", "docx"), "geojson"),
    (lambda c: c.export("m.pcd", robots=[]), "robots"),
    (lambda c: c.export("m.pcd", robots=[5]), "robot"),
    (lambda c: c.export("m.pcd", component=-1), "component"),
    (lambda c: c.export("m.pcd", box=((0, 0), (1, 1))), "box"),
    (lambda c: c.export_pose_graph("g.json"), ".g2o"),
    (lambda c: c.back_up("copy", tokens="all"), "tokens"),
)


# Values that make sense, for the parameters without a default.
SENSIBLE = {
    "robot": "alice", "scans": [(1, POINTS)], "sensor": "vlp16", "session": "alice-1",
    "path": "m.g2o", "a": "alice", "b": "bob", "decision": "accept", "loop": 1, "target": "alice",
    "position": (1, 2, 3), "T_map_submap": Pose(), "datum": None, "revision": 1,
    "from_revision": 1, "tile": isthmus.TileId(0, 0, 0, 0), "name": "chief", "role": "reader",
    "submap": isthmus.OwnSubmap(POINTS), "submaps": [isthmus.OwnSubmap(POINTS)], "index": 0,
    "folder": "copy", "robot_or_session": "alice"}
GARBAGE = (5, -1, 1.5, float("nan"), 10**30, "x", "", b"x", [5], [[]], {}, object(), Pose(),
           np.datetime64("NaT"), datetime.datetime(2020, 1, 1), "\udcff")


class ArgumentsTest(unittest.TestCase):
    """No server is there."""

    def setUp(self) -> None:
        self.enterContext(mock.patch.dict(os.environ))
        self.folder = temporary_folder()
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)

    def test_each_is_named_and_nothing_is_sent(self) -> None:
        with isthmus.connect("127.0.0.1:1", **NOBODY) as client:
            for number, (call, named) in enumerate(WRONG):
                with self.subTest(number=number, named=named):
                    with self.assertRaisesRegex(InvalidArgument, named):
                        call(client)
            with self.assertRaises(isthmus.Unavailable):
                client.query(box=((0, 0, 0), (np.inf, 1, 1)))
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_no_argument_of_any_method_is_a_bare_error(self) -> None:
        tried = 0
        with isthmus.connect("127.0.0.1:1", **NOBODY) as client:
            for name, method in inspect.getmembers(client, inspect.ismethod):
                parameters = [one for one in inspect.signature(method).parameters.values()
                              if one.kind != one.VAR_KEYWORD]
                if name.startswith("_") or name == "close":
                    continue
                needed = {one.name: SENSIBLE[one.name] for one in parameters
                          if one.default is one.empty}
                for one, garbage in itertools.product(parameters, GARBAGE):
                    if one.name in ("path", "folder"):
                        continue  # A TypeError, as of any function that takes a path.
                    with self.subTest(name=name, argument=one.name, garbage=garbage):
                        tried += 1
                        with contextlib.suppress(isthmus.Error):
                            answer = method(**{**needed, one.name: garbage})
                            if inspect.isgenerator(answer):
                                next(answer, None)
        self.assertGreater(tried, 1000)

    def test_those_of_connect(self) -> None:
        for given, named in (
                ({"address": 50051}, "address"), ({"address": ["a:1"]}, "address"),
                ({"token": b"secret"}, "token"), ({"site": 5}, "site"),
                ({"timeout": "x"}, "timeout"),
                ({"call_timeout": -1}, "call_timeout"), ({"max_file_bytes": 1.5}, "max_file_bytes"),
                ({"tls_ca": 5}, "tls_ca"), ({"token_file": 5}, "token_file"),
                ({"token": "a", "token_file": "b"}, "not both")):
            with self.assertRaisesRegex(InvalidArgument, named, msg=str(given)) as caught:
                isthmus.connect(**{"address": "127.0.0.1:1", **NOBODY, **given})
            self.assertNotIn("secret", str(caught.exception))

    def test_a_token_file_without_a_token_is_said_to_be_empty(self) -> None:
        for contents in ("", " \n"):
            Path("token").write_text(contents)
            with self.assertRaisesRegex(InvalidArgument, "is empty"):
                isthmus.connect("127.0.0.1:1", token_file=Path("token"), **NOBODY)
            os.environ["ISTHMUS_TOKEN_FILE"] = "token"
            with self.assertRaisesRegex(InvalidArgument, "is empty"):
                isthmus.connect("127.0.0.1:1", **NOBODY)
            isthmus.connect("127.0.0.1:1", token="", **NOBODY).close()
            del os.environ["ISTHMUS_TOKEN_FILE"]

    def test_files_that_cannot_be_written_have_the_name_that_was_given(self) -> None:
        Path("folder.pcd").mkdir()
        Path("file").write_text("")
        graph = np.zeros((1, 3))
        with isthmus.connect("127.0.0.1:1", **NOBODY) as client:
            for write, path in (
                    (lambda path: client.export(path), "missing/a/x.pcd"),
                    (lambda path: client.export(path, robots=["a", "b"]), "missing/a/x.pcd"),
                    (lambda path: client.export(path), "folder.pcd"),
                    (lambda path: client.export_pose_graph(path), "missing/g.g2o"),
                    (lambda path: client.back_up(path), "file/copy"),
                    (lambda path: isthmus.io.write_pcd(path, graph), "missing/a.pcd"),
                    (lambda path: isthmus.io.write_tum(path, [1], [Pose()]), "missing/a.tum")):
                with self.assertRaisesRegex(InvalidArgument, f"cannot write {path}: ") as caught:
                    write(path)
                self.assertIsInstance(caught.exception, OSError)
                self.assertEqual(caught.exception.filename, path)
        left = sorted(path.name for path in self.folder.iterdir())
        self.assertEqual(left, ["file", "folder.pcd"])

    def test_a_full_disk_is_told_by_the_name_that_was_given(self) -> None:
        whole = pb.ExportMapResponse(data=b"12345", last=True, size=5)
        with FakeServer() as server, isthmus.connect(server.address) as client:
            server.answers["ExportMap"] = [whole]
            os.symlink("/dev/full", "map.pcd.part")
            with self.assertRaisesRegex(isthmus.ResourceExhausted, "write map.pcd: ") as caught:
                client.export("map.pcd")
        self.assertIsInstance(caught.exception, OSError)
        self.assertEqual(list(self.folder.iterdir()), [])


class MomentsTest(unittest.TestCase):
    def test_numpys_datetimes_are_moments(self) -> None:
        for text in ("2020-01-01T00:00:00", "2020-01-01T00:00:00.000000000", "2020-01-01", "2020"):
            self.assertEqual(isthmus.to_ns(np.datetime64(text)), EPOCH_2020_NS, text)
        self.assertEqual(isthmus.to_ns(np.datetime64(EPOCH_2020_NS + 7, "ns")), EPOCH_2020_NS + 7)
        stamps = np.array([EPOCH_2020_NS, EPOCH_2020_NS + 1]).astype("datetime64[ns]")
        file = temporary_folder() / "way.tum"
        isthmus.io.write_tum(file, stamps, [Pose(), Pose()])
        read = isthmus.io.read_tum(file)[0]
        np.testing.assert_array_equal(read.astype("datetime64[ns]"), stamps)

    def test_numbers_are_nanoseconds(self) -> None:
        for number in (7, np.int64(7), np.uint8(7), 7.0):
            self.assertEqual(isthmus.to_ns(number), 7)
        for wrong in (1577836800.5, float("inf"), "7", None, b"7", np.datetime64("NaT"), 1 << 63,
                      np.datetime64(10**7, "D"), np.datetime64("2400-01-01")):
            with self.assertRaisesRegex(InvalidArgument, "a moment is nanoseconds since 1970"):
                isthmus.to_ns(wrong)


class ScansTest(unittest.TestCase):
    """A drive that turns out to be none."""

    def test_a_wrong_stamp_leaves_no_open_session(self) -> None:
        clouds = [(np.datetime64(k, "s"), POINTS) for k in range(1, 4)]
        with FakeServer() as server, isthmus.connect(server.address) as client:
            server.open_gate()
            with self.assertRaisesRegex(InvalidArgument, "the stamp of scan 4 .*'noon'"):
                client.push("alice", [*clouds, ("noon", POINTS), *clouds], sensor="vlp16")
            self.assertEqual(server.received, [1, 2, 3])
            self.assertEqual(server.finished, 1)
            with self.assertRaisesRegex(InvalidArgument, "scan 5 is"):
                client.push("alice", [*clouds, *clouds[:1], POINTS], session="alice-1",
                            finish=False)
            self.assertEqual(server.finished, 1)

    def test_points_that_numpy_cannot_read_are_rejected_one_by_one(self) -> None:
        drive = [(1, POINTS), (2, [[1, 2, 3], [4]]), (3, [["a", "b", "c"]]), (4, object()),
                 (5, POINTS)]
        with FakeServer() as server, isthmus.connect(server.address) as client:
            server.open_gate()
            summary = client.push("alice", drive, sensor="vlp16")
        self.assertEqual([one.stamp_ns for one in summary.rejected], [2, 3, 4])
        self.assertEqual(summary.processed, 2)


if __name__ == "__main__":
    unittest.main()
