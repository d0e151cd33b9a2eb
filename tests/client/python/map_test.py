"""The map of two robots, read and corrected over a real socket."""
import functools
import json
import os
import threading
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import isthmus
import isthmus.io
from fake_server import FakeServer
from isthmus import MatchState, Pose, Reason, SessionState
from isthmus.v1 import map_service_pb2 as pb
from servers import CLI, Server, scans, temporary_folder

MOUNTED = {"alice": None, "bob": Pose.from_xyz_rpy(0.4, -0.2, 1.1, roll=0.02, yaw=0.3)}
T_ALICE_BOB = Pose.from_xyz_rpy(3, -1, 0, yaw=0.5)


@functools.lru_cache(maxsize=None)
def two_drives() -> Path:
    """The folder of a map of two drives that hardly overlap."""
    with Server() as server:
        with isthmus.connect(server.address) as client:
            for k, robot in enumerate(("alice", "bob")):
                client.push(robot, scans(k)[:25], sensor="vlp16", T_base_sensor=MOUNTED[robot])
            client.wait("settled", 300)
        server.stop()
        return server.data


class MapTest(unittest.TestCase):
    """A person says how the two lie."""

    def setUp(self) -> None:
        self.server = self.enterContext(Server(two_drives()))
        self.client = self.enterContext(isthmus.connect(self.server.address))
        self.client.wait("settled", 300)

    def join(self) -> int:
        revision, match = self.client.decide_match("alice", "bob", "set", T_ALICE_BOB, "surveyed")
        self.assertEqual((match.state, match.reason), (MatchState.ACCEPTED, Reason.BY_HAND))
        return revision

    def test_sessions_and_robots(self) -> None:
        sessions = self.client.sessions()
        self.assertEqual([session.id for session in sessions], ["alice-1", "bob-1"])
        self.assertEqual(self.client.list_sessions(), sessions)
        self.client.create_session("alice", "vlp16")
        robots = self.client.robots()
        self.assertEqual({name: session.id for name, session in robots.items()},
                         {"alice": "alice-2", "bob": "bob-1"})
        self.assertEqual(self.client.finish_session("alice-2").state, SessionState.FINISHED)
        self.client.delete_session("alice-2")
        with self.assertRaises(isthmus.NotFound):
            self.client.get_session("alice-2")
        with self.assertRaises(LookupError):
            self.client.delete_session("alice-2")

    def test_a_datum_is_set_read_and_taken_back(self) -> None:
        self.assertIsNone(self.client.get_map_info().datum)
        self.client.set_datum(isthmus.Datum(48.1, 11.5, 520.0, 12.5))
        datum = self.client.get_map_info().datum
        assert datum is not None
        self.assertEqual((datum.latitude_deg, datum.longitude_deg, datum.altitude_m,
                          datum.heading_deg), (48.1, 11.5, 520.0, 12.5))
        self.assertGreater(datum.given_ns, 0)
        self.client.set_datum(None)
        self.assertIsNone(self.client.get_map_info().datum)

    def test_the_server_says_how_it_is_getting_on(self) -> None:
        session = self.client.create_session("carol", "vlp16")
        status = self.client.get_status()
        self.assertEqual(status.version, isthmus.VERSION)
        self.assertEqual(status.site, "default")
        self.assertEqual(status.degraded, ())
        self.assertGreater(status.process.resident_bytes, 0)
        self.assertGreater(status.disk.database_bytes, 0)
        self.assertGreaterEqual(status.calls.others, 1)
        self.assertIn(session.id, [load.session for load in status.sessions])
        self.assertEqual(status.sessions[-1].robot, "carol")
        self.assertEqual(status.sessions[-1].tracking, isthmus.Tracking.UNSPECIFIED)
        self.client.delete_session(session.id)

    def test_a_decision_joins_the_maps_and_another_parts_them(self) -> None:
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "alice and bob"):
            self.client.transform("alice", "bob")
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "not merged"):
            self.client.wait("merged", 300)
        revision = self.join()
        self.assertEqual(len(self.client.wait("merged", 300).components), 1)
        at, T_alice_bob = self.client.get_transform("alice", "bob")
        self.assertEqual(at, revision)
        np.testing.assert_allclose(T_alice_bob.matrix(), T_ALICE_BOB.matrix(), atol=1e-9)
        np.testing.assert_allclose(self.client.transform("bob", "alice").matrix(),
                                   T_ALICE_BOB.inverse().matrix(), atol=1e-9)
        graph = self.client.graph()
        (match,) = graph.matches
        self.assertEqual((match.manual_decision.note, match.in_tree), ("surveyed", True))
        self.assertEqual([placement.robot for placement in graph.placements], ["alice", "bob"])
        # Sessions by name, undone by its revision.
        undone = self.client.undo_revision(revision, "twin hall")
        self.assertGreater(undone, revision)
        self.client.decide_match("alice-1", "bob-1", isthmus.Decision.REJECT, sessions=True)
        self.assertEqual(self.client.get_match_graph(True).matches[0].state, MatchState.REJECTED)
        for names, error in ((("alice", "carol"), isthmus.NotFound),
                             (("alice", "alice"), isthmus.InvalidArgument)):
            with self.assertRaises(error):
                self.client.decide_match(*names, "reject")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "withdraw"):
            self.client.decide_match("alice", "bob", "perhaps")

    def test_trajectories(self) -> None:
        self.join()
        stamps, poses = self.client.trajectory("alice")
        np.testing.assert_array_equal(stamps, [scan.stamp_ns for scan in scans(0)[:25]])
        self.assertEqual(poses.shape, (25, 4, 4))
        T_map_odom = self.client.get_session("alice-1").T_map_odom.matrix()
        odom = self.client.trajectory("alice", "odom")[1]
        np.testing.assert_allclose(poses, T_map_odom @ odom, atol=1e-6)
        np.testing.assert_array_equal(self.client.trajectory("alice-1")[1], poses)
        whole = self.client.get_trajectory("bob")
        self.assertEqual((whole.session, whole.component, whole.segments_left_out),
                         ("bob-1", 0, ()))
        self.assertEqual(set(whole.segments), {1})
        with self.assertRaises(isthmus.NotFound):
            self.client.trajectory("carol")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "'odom'"):
            self.client.trajectory("alice", "base")
        T_bob_sensor = MOUNTED["bob"]
        assert T_bob_sensor is not None
        base = self.client.get_trajectory("bob", poses_of="base")
        self.assertEqual(len(base.poses), len(whole.poses))
        np.testing.assert_allclose(base.poses @ T_bob_sensor.matrix(), whole.poses, atol=1e-9)
        np.testing.assert_array_equal(self.client.trajectory("bob-1", poses_of="base")[1],
                                      base.poses)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "alice-1 does not say where"):
            self.client.trajectory("alice", poses_of="base")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "'base'"):
            self.client.trajectory("alice", poses_of="wheel")
        self.client.create_session("alice", "vlp16")
        np.testing.assert_array_equal(self.client.trajectory("alice-1", "odom")[1], odom)

    def test_queries(self) -> None:
        self.join()
        self.client.wait("merged", 300)
        everything = self.client.query()
        self.assertEqual(set(everything["robot"]), {"alice", "bob"})
        coarse = self.client.query(resolution=0.5)
        self.assertLess(len(coarse), len(everything) / 4)
        low, high = (-2, -2, 0), (4, 3, 2)
        box = self.client.query(box=(low, high))
        xyz = np.stack([box["x"], box["y"], box["z"]], 1)
        self.assertTrue(((xyz >= low) & (xyz <= high)).all())
        ball = self.client.query(sphere=((0, 0, 0), 5), robot="bob")
        self.assertEqual(set(ball["robot"]), {"bob"})
        self.assertLessEqual((ball["x"]**2 + ball["y"]**2 + ball["z"]**2).max(), 25.001)
        self.assertEqual(len(self.client.query(box=((900, 900, 0), (901, 901, 1)))), 0)
        pieces = list(self.client.query_region(resolution=0.5))
        self.assertEqual(sum(len(points) for _, _, points in pieces), len(coarse))
        self.assertEqual(pieces[0][1], ("alice", "bob"))
        self.assertEqual(len(self.client.query(component="bob-1")), len(everything))
        self.assertEqual(set(self.client.query(sessions="bob-1")["robot"]), {"bob"})
        self.assertLessEqual({"ground", "wall"}, set(everything["label"]))
        self.assertLessEqual(set(everything["label"]), set(isthmus.LABELS))
        walls = self.client.query(classes="wall")
        self.assertEqual(set(walls["label"]), {"wall"})
        self.assertEqual(len(walls), (everything["label"] == "wall").sum())
        two = self.client.query(classes=["wall", "ground"])
        self.assertEqual(set(two["label"]), {"wall", "ground"})
        for wrong, error in (({"box": (high, low)}, isthmus.InvalidArgument),
                             ({"box": (low, high), "sphere": (low, 1)}, isthmus.InvalidArgument),
                             ({"sphere": (low, -1)}, isthmus.InvalidArgument),
                             ({"classes": "walls"}, isthmus.InvalidArgument),
                             ({"robot": "carol"}, isthmus.NotFound),
                             ({"component": "carol-1"}, isthmus.NotFound),
                             ({"component": 7}, isthmus.NotFound)):
            with self.assertRaises(error, msg=str(wrong)):
                self.client.query(**wrong)

    def test_files(self) -> None:
        self.join()
        self.client.wait("merged", 300)
        folder = temporary_folder()
        everything, steps = self.client.query(), []
        for form in ("pcd", "pcd-binary", "pcd-ascii"):
            summary = self.client.export(folder / "map.pcd", form, progress=steps.append)
            self.assertEqual(summary.size, (folder / "map.pcd").stat().st_size)
            points = isthmus.io.read_pcd(folder / "map.pcd").points
            for name in "xyz":
                np.testing.assert_allclose(np.sort(points[name]), np.sort(everything[name]),
                                           atol=1e-4)
            np.testing.assert_allclose(np.sort(isthmus.xyz(everything), axis=0),
                                       np.sort(isthmus.xyz(points), axis=0), atol=1e-4)
        self.assertEqual(steps[-1], summary.size)
        self.client.export(folder / "bob.pcd", robots=["bob"])
        self.assertEqual(len(isthmus.io.read_pcd(folder / "bob.pcd").points),
                         np.count_nonzero(everything["robot"] == "bob"))
        # A part of the map, of everything, of one robot, and of several.
        box = ((-3.0, -4.0, -1.0), (5.0, 6.0, 2.0))
        inside = np.logical_and(isthmus.xyz(everything) >= box[0],
                                isthmus.xyz(everything) <= box[1]).all(axis=1)
        of_bob = inside & (everything["robot"] == "bob")
        self.assertTrue(0 < np.count_nonzero(of_bob) < np.count_nonzero(inside) < len(inside))
        for robots, expected in ((None, inside), ("bob", of_bob), (["alice", "bob"], inside)):
            self.client.export(folder / "part.pcd", robots=robots, box=box)
            self.assertEqual(len(isthmus.io.read_pcd(folder / "part.pcd").points),
                             np.count_nonzero(expected), robots)
        (folder / "part.pcd").unlink()
        # Without a format the name of the file decides, and never one against the other.
        self.client.export(folder / "named.PLY", resolution=0.5, robots="bob")
        self.assertTrue((folder / "named.PLY").read_bytes().startswith(b"ply"))
        (folder / "named.PLY").unlink()
        for name, form in (("map.laz", None), ("map.las", "pcd"), ("map.png", None),
                           ("map.pgm", None), ("map.ply", "pcd"), ("map.pcd", "ot"),
                           ("map.bt", "ot"), ("map.pcd", "las")):
            with self.assertRaises(isthmus.InvalidArgument, msg=name):
                self.client.export(folder / name, form)
        for form, magic in (("ply", b"ply"), ("octomap", b"# Octomap"), ("ot", b"# Octomap")):
            self.client.export_to_file(folder / form, form, resolution=0.5)
            self.assertTrue((folder / form).read_bytes().startswith(magic))
        self.client.export(folder / "by_name.ply", component="bob-1", resolution=0.5)
        self.assertEqual((folder / "by_name.ply").read_bytes(), (folder / "ply").read_bytes())
        (folder / "by_name.ply").unlink()
        self.client.export_pose_graph(folder / "graph.g2o", component="alice-1")
        self.assertIn("VERTEX_SE3:QUAT", (folder / "graph.g2o").read_text())
        names = sorted(path.name for path in folder.iterdir())
        self.assertEqual(names, ["bob.pcd", "graph.g2o", "map.pcd", "octomap", "ot", "ply"])
        for options, error in (({"component": 9}, isthmus.NotFound),
                               ({"format": "docx"}, isthmus.InvalidArgument),
                               ({"format": "ply", "robots": ["alice", "bob"]},
                                isthmus.InvalidArgument),
                               ({"robots": ["carol"]}, isthmus.NotFound)):
            with self.assertRaises(error):
                self.client.export(folder / "none", **{"format": "pcd", **options})
        self.assertFalse((folder / "none").exists() or (folder / "none.part").exists())

    def test_files_that_the_program_writes(self) -> None:
        self.join()
        self.client.wait("merged", 300)
        folder = temporary_folder()
        path = {"PATH": os.path.dirname(CLI) + os.pathsep + os.environ["PATH"]}
        self.enterContext(mock.patch.dict(os.environ, path))
        summary = self.client.export(folder / "map.las", component="alice-1")
        las = (folder / "map.las").read_bytes()
        self.assertEqual((las[:4], len(las)), (b"LASF", summary.size))
        self.assertEqual(int.from_bytes(las[247:255], "little"), len(self.client.query()))
        self.client.export(folder / "bob.las", robots=["bob"], resolution=0.5)
        self.assertLess((folder / "bob.las").stat().st_size, summary.size)
        sphere = ((1.0, -0.5, 0.5), 3.0)
        self.client.export(folder / "part.las", sphere=sphere)
        self.assertEqual(int.from_bytes((folder / "part.las").read_bytes()[247:255], "little"),
                         len(self.client.query(sphere=sphere)))
        self.assertEqual(self.client.export(folder / "map.mcap").revision, summary.revision)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "datum"):
            self.client.export(folder / "ways.geojson")
        self.client.set_datum(isthmus.Datum(48.1, 11.5))
        with self.assertRaisesRegex(isthmus.InvalidArgument, "whole ways"):
            self.client.export(folder / "ways.geojson", sphere=sphere)
        self.client.export(folder / "ways.geojson")
        ways = json.loads((folder / "ways.geojson").read_text())
        self.assertEqual(ways["type"], "FeatureCollection")
        floors = self.client.export_floors(folder / "office", resolution=0.1)
        self.assertEqual(floors, [folder / "office_floor0.yaml"])
        band = self.client.export_floors(folder / "band", heights=(0.2, 1.5))
        self.assertIn('image: "band.pgm"', band[0].read_text())
        for options, error in (({"robots": ["alice", "bob"]}, isthmus.InvalidArgument),
                               ({"dropped": True}, isthmus.InvalidArgument),
                               ({"shape": isthmus.Corridor([(0, 0, 0), (1, 0, 0)], 1)},
                                isthmus.InvalidArgument),
                               ({"component": 9}, isthmus.NotFound)):
            with self.assertRaises(error, msg=str(options)):
                self.client.export(folder / "none.las", **options)
        with mock.patch.dict(os.environ, {"PATH": str(folder)}):
            with self.assertRaisesRegex(isthmus.Unimplemented, "not in PATH"):
                self.client.export(folder / "none.las")
        self.assertFalse((folder / "none.las").exists())

    def test_a_backup_can_be_served(self) -> None:
        folder = temporary_folder() / "copy"
        seen = []
        backup = self.client.back_up(folder, seen.append)
        self.assertEqual((backup.contents.sessions, backup.contents.damaged), (2, 0))
        self.assertEqual((seen[-1].copied, seen[-1].bytes), (1.0, backup.file.size))
        with self.assertRaises(isthmus.AlreadyExists):
            self.client.back_up(folder)
        self.server.kill()
        self.server.data = folder
        self.server.start()
        self.assertEqual(set(self.client.robots()), {"alice", "bob"})

    def test_anchors_and_revisions(self) -> None:
        before = self.client.status().revision
        (submap,) = self.client.list_submaps("alice")
        anchored = self.client.set_anchor("alice", (10, 20, 1), yaw=1.0, sigma_xy=0.5, sigma_z=0.2,
                                          sigma_deg=1, note="GNSS")
        self.assertEqual((anchored.session, anchored.index), (submap.session, submap.index))
        self.client.put_anchor("bob-1/0", Pose((0, 5, 0)), sigma_xy=1)
        alice, bob = self.client.list_anchors()
        self.assertEqual((alice.robot, alice.note, bob.sigma_xy_m), ("alice", "GNSS", 1.0))
        self.client.wait("settled", 300)
        (submap,) = self.client.list_submaps("alice")
        np.testing.assert_allclose(submap.T_map_submap.translation, (10, 20, 1), atol=0.01)
        newest, *older = self.client.revisions()
        self.assertEqual(newest.revision, self.client.status().revision)
        self.assertEqual(self.client.list_revisions(1), [newest])
        diff = self.client.diff_revisions(before)
        self.assertEqual([revision.revision for revision in diff.revisions],
                         list(range(newest.revision, before, -1)))
        self.assertIn(("alice-1", 0), {(move.session, move.index) for move in diff.moves})
        self.assertGreater(self.client.remove_anchor(("bob-1", 0)), newest.revision)
        with self.assertRaises(isthmus.NotFound):
            self.client.remove_anchor("bob-1/0")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "alice-1/7"):
            self.client.put_anchor("alice-1/x", Pose(), sigma_xy=1)
        with self.assertRaises(isthmus.NotFound):
            self.client.diff_revisions(0, 10**6)
        with self.assertRaises(isthmus.FailedPrecondition):
            self.client.undo_revision(newest.revision)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "after that"):
            self.client.find_changes(since_revision=newest.revision)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "before that"):
            self.client.find_changes(since_ns=1, sphere=((0, 0, 0), 5))
        with self.assertRaisesRegex(isthmus.InvalidArgument, "since_ns or since_revision"):
            self.client.find_changes()
        self.assertEqual(self.client.list_loops(), [])
        with self.assertRaises(isthmus.NotFound):
            self.client.decide_loop(17, rejected=False)

    def test_changes_are_watched(self) -> None:
        changes = self.client.watch(since=0, every_s=0.05)
        first = next(changes)
        self.assertEqual({move.session for move in first.moves}, {"alice-1", "bob-1"})
        self.assertTrue(all(move.before is None for move in first.moves))
        joining = threading.Thread(target=self.join)
        joining.start()
        second = next(changes)
        joining.join()
        self.assertEqual(second.from_revision, first.to_revision)
        self.assertTrue(second.moves)
        self.client.close()
        self.assertEqual(list(changes), [])  # It ends with the client.


    def test_the_map_is_read_and_watched_tile_by_tile(self) -> None:
        steps = self.client.watch_map()
        first = next(steps)
        self.assertTrue(first.restart)
        self.assertEqual({place.session for place in first.submaps}, {"alice-1", "bob-1"})
        listed = [tile for component in (0, 1) for tile in self.client.list_tiles(component)]
        named = [tile for name in ("alice-1", "bob-1") for tile in self.client.list_tiles(name)]
        self.assertEqual(set(named), set(listed))
        self.assertEqual([tile.version for tile in first.tiles],
                         [tile.version for tile in listed])
        tile = self.client.get_tile(listed[0].id)
        self.assertEqual(len(tile.points), tile.info.points)
        self.assertEqual(set(tile.points["robot"]), set(range(len(tile.robots))))
        self.assertGreater(tile.points["last_seen"].min(), 0)
        self.assertIsNone(self.client.get_tile(tile.info.id, tile.info.version).points)
        with self.assertRaises(isthmus.NotFound):
            self.client.get_tile(isthmus.TileId(0, 0, 999, 999))
        joining = threading.Thread(target=self.join)
        joining.start()
        later = next(step for step in steps if step.matches)
        joining.join()
        self.assertFalse(later.restart)
        self.assertGreater(later.revision, first.revision)
        again = next(self.client.watch_map(since=first))
        self.assertFalse(again.restart)
        self.assertTrue(again.submaps)

    def test_a_mirror_has_the_map(self) -> None:
        self.join()
        self.client.wait("merged", 300)
        tiles = next(self.client.mirror_map())
        for component in range(len(self.client.status().components)):
            everything = self.client.query(component=component)
            mine = np.concatenate([np.zeros((0, 3))] + [
                np.stack([tile.points[name] for name in "xyz"], 1)
                for name, tile in tiles.items() if name.component == component])
            theirs = np.stack([everything[name] for name in "xyz"], 1)
            np.testing.assert_array_equal(mine[np.lexsort(mine.T)], theirs[np.lexsort(theirs.T)])

    def test_shapes(self) -> None:
        everything = self.client.query()
        xyz = np.stack([everything[name] for name in "xyz"], 1).astype(float)
        T_map_box = Pose.from_matrix([[0.6, -0.8, 0, 1], [0.8, 0.6, 0, 0], [0, 0, 1, 1],
                                      [0, 0, 0, 1]])
        inside = (np.abs(T_map_box.inverse() @ xyz) <= (2, 3, 1)).all(axis=1)
        square = (np.abs(xyz[:, :2]) <= 3).all(axis=1) & (xyz[:, 2] <= 0.5)
        along = (np.abs(xyz[:, 1]) <= 1) & (xyz[:, 0] >= -50) & (xyz[:, 0] <= 50)
        for shape, expected in (
                (isthmus.OrientedBox(T_map_box, (4, 6, 2)), inside),
                (isthmus.Polygon([(-3, -3), (3, -3), (3, 3), (-3, 3)], (None, 0.5)), square),
                (isthmus.Corridor([(-50, 0, 0), (50, 0, 0)], 2), along)):
            self.assertGreater(expected.sum(), 0)
            self.assertEqual(len(self.client.query(shape=shape)), expected.sum())
        self.assertLessEqual(len(self.client.query(max_points=100)), 100)
        self.assertEqual(len(self.client.query(sessions=["alice-1"], component=0)) +
                         len(self.client.query(sessions=["bob-1"], component=0)), len(everything))
        with self.assertRaises(isthmus.NotFound):
            self.client.query(sessions=["carol-1"])
        with self.assertRaisesRegex(isthmus.InvalidArgument, "not several"):
            self.client.query(sphere=((0, 0, 0), 1), shape=isthmus.Corridor([(0, 0, 0)], 1))


class PartsTest(unittest.TestCase):
    def test_edges_that_did_not_fit_belong_to_the_last_of_the_part_before(self) -> None:
        edge = [pb.SubmapEdge(submap_a=k, information=range(21)) for k in range(4)]
        with FakeServer() as server, isthmus.connect(server.address) as client:
            server.answers["GetMatchGraph"] = [
                pb.GetMatchGraphResponse(revision=9, matches=[pb.Match(session_a="a")]),
                pb.GetMatchGraphResponse(revision=9, more_edges=edge[:3]),
                pb.GetMatchGraphResponse(revision=9, more_edges=edge[3:], matches=[
                    pb.Match(session_a="b", edges=edge[:1], state=77, reason=78)])]
            a, b = client.graph(True).matches
            self.assertEqual([e.submap_a for e in a.edges], [0, 1, 2, 3])
            self.assertEqual(len(b.edges), 1)
            self.assertEqual((b.state, b.reason), (MatchState.UNSPECIFIED, Reason.UNSPECIFIED))
            matrix = a.edges[0].information
            self.assertEqual(matrix[0].tolist(), [0, 1, 2, 3, 4, 5])
            np.testing.assert_array_equal(matrix, matrix.T)
            server.answers["ListLoops"] = [
                pb.ListLoopsResponse(loops=[pb.Loop(id=1), pb.Loop(id=2, edges=edge[:1])]),
                pb.ListLoopsResponse(more_edges=edge[1:2], loops=[pb.Loop(id=3)])]
            self.assertEqual([(loop.id, len(loop.edges)) for loop in client.list_loops()],
                             [(1, 0), (2, 2), (3, 0)])


if __name__ == "__main__":
    unittest.main()
