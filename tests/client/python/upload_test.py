"""Submaps of another SLAM, sent whole, in pieces, twice and wrongly."""
import unittest
from unittest import mock

import grpc
import numpy as np

import isthmus
from isthmus import OwnSubmap, Pose, SessionState, _uploads as uploads
from isthmus.v1 import session_service_pb2 as pb
from isthmus.v1.session_service_pb2_grpc import SessionServiceStub
from servers import Server, room


def submap(k: int = 0, points: int = 3000) -> OwnSubmap:
    cloud = next(room(points, seed=k))
    records = np.zeros(points, dtype=[("x", "f4"), ("y", "f4"), ("z", "f4"), ("keyframe", "u2")])
    for i, name in enumerate("xyz"):
        records[name] = cloud[:, i]
    records["keyframe"] = np.arange(points) % 2
    return OwnSubmap(records, Pose.from_xyz_rpy(5 * k, 0, 0), [Pose(), (7, Pose((0.5, 0, 0)))],
                     first_stamp_ns=k * 10**9, last_stamp_ns=(k + 1) * 10**9)


class UploadTest(unittest.TestCase):
    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.client = self.enterContext(isthmus.connect(self.server.address))

    def test_submaps_become_the_robots_map(self) -> None:
        told = []
        session = self.client.upload("carol", (submap(k) for k in range(3)), sensor="unordered",
                                     on_submap=lambda *what: told.append(what))
        self.assertEqual((session.id, session.state, session.submap_count),
                         ("carol-1", SessionState.FINISHED, 3))
        self.assertEqual(told, [(k, 3000) for k in range(3)])
        self.client.wait("settled", 300)
        listed = self.client.list_submaps("carol")
        self.assertEqual([(s.index, s.keyframe_count, s.first_stamp_ns) for s in listed],
                         [(k, 2, k * 10**9) for k in range(3)])
        np.testing.assert_allclose(listed[2].T_odom_submap.translation, (10, 0, 0))
        cloud = self.client.query(robot="carol")
        self.assertAlmostEqual(float(cloud["x"].max()), 16, delta=0.2)

    def test_quantised_submaps_and_no_keyframes(self) -> None:
        session = self.client.upload("carol", [OwnSubmap(next(room()))], "unordered", 0.002)
        self.assertEqual(session.point_count, 2000)

    def test_going_on_in_a_session_sends_what_is_missing(self) -> None:
        first = self.client.upload("carol", [submap(0)], "unordered", finish=False)
        self.server.kill()
        self.server.start()
        again = self.client.upload("carol", map(submap, range(3)), session=first.id)
        self.assertEqual((again.id, again.submap_count), (first.id, 3))
        self.assertEqual(len(self.client.sessions()), 1)

    def test_goes_on_behind_what_has_arrived(self) -> None:
        session = self.client.create_session("carol", "unordered").id
        big = submap(0, points=400_000)
        header, data = uploads.describe(session, 0, big, 0)
        half = len(data) // 2

        def cut_off():
            yield pb.UploadSubmapRequest(header=header)
            for at in range(0, half, 1 << 20):
                chunk = pb.UploadSubmapChunk(offset=at, data=data[at:min(at + (1 << 20), half)])
                yield pb.UploadSubmapRequest(chunk=chunk)

        with grpc.insecure_channel(self.server.address) as channel:
            with self.assertRaises(grpc.RpcError):
                SessionServiceStub(channel).UploadSubmap(cut_off())
        with mock.patch.object(uploads, "_parts", wraps=uploads._parts) as parts:
            self.assertEqual(self.client.upload_submap(session, 0, big), 400_000)
        (_, _, arrived), _ = parts.call_args
        self.assertEqual(arrived, half)

    def test_what_cannot_be_uploaded(self) -> None:
        session = self.client.create_session("carol", "unordered").id
        self.client.upload_submap(session, 0, submap(0))
        self.client.upload_submap(session, 0, submap(0))  # The same twice is no error.
        nowhere = submap(0).points.copy()
        nowhere["x"] = np.nan
        for where, what, error in (((session, 0), submap(1), isthmus.AlreadyExists),
                                   ((session, 5), submap(1), isthmus.OutOfRange),
                                   (("carol-9", 0), submap(1), isthmus.NotFound),
                                   ((session, 1), OwnSubmap(nowhere), isthmus.InvalidArgument),
                                   ((session, 1), OwnSubmap(np.zeros((0, 3))),
                                    isthmus.InvalidArgument),
                                   ((session, 1), OwnSubmap([1, 2]), isthmus.InvalidArgument)):
            with self.assertRaises(error):
                self.client.upload_submap(*where, what)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "holds uploaded submaps"):
            with self.client.open_stream(session) as stream:
                stream.push(1, next(room()))


if __name__ == "__main__":
    unittest.main()
