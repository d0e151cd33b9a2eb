"""Drives pushed to a real server, which dies in the middle; scans that it refuses."""
import subprocess
import threading
import unittest
from types import SimpleNamespace
from typing import List

import numpy as np

import isthmus
from isthmus import Outcome, SessionState, Tracking
from servers import SERVER, Server, room, scans


class PushTest(unittest.TestCase):
    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.client = self.enterContext(isthmus.connect(self.server.address))

    def test_a_drive_is_processed_and_finished(self) -> None:
        acks: List[isthmus.Ack] = []
        drive = scans(0)
        summary = self.client.push("alice", iter(drive), sensor="vlp16", odometry="continuous",
                                   on_ack=acks.append)
        self.assertEqual((summary.session.id, summary.session.state, summary.processed),
                         ("alice-1", SessionState.FINISHED, len(drive)))
        self.assertEqual((summary.rejected, summary.session.segments), ((), 1))
        self.assertEqual(summary.session.scan_counts.ok, len(drive))
        self.assertEqual([ack.stamp_ns for ack in acks], [scan.stamp_ns for scan in drive])
        last = acks[-1]
        self.assertEqual(last.tracking, Tracking.OK)
        self.assertEqual(last.covariance.shape, (6, 6))
        np.testing.assert_allclose(last.covariance, last.covariance.T)
        turned = last.covariance_in_odom()
        np.testing.assert_allclose(np.trace(turned[:3, :3]), np.trace(last.covariance[:3, :3]))
        self.assertGreater(last.timing.total_ms, 0)
        stamps, poses = self.client.trajectory("alice", "odom")
        np.testing.assert_array_equal(stamps, [scan.stamp_ns for scan in drive])
        np.testing.assert_allclose(poses[-1], last.T_odom_sensor.matrix(), atol=1e-6)

    def test_a_session_says_what_it_does_when_behind(self) -> None:
        drive = scans(0)[:30]
        summary = self.client.push("alice", drive, sensor="vlp16", when_behind="keep-newest",
                                   window=64)
        self.assertEqual(summary.session.when_behind, isthmus.WhenBehind.KEEP_NEWEST)
        self.assertEqual(summary.processed + summary.stats.skipped, len(drive))
        self.assertEqual(summary.session.scan_counts.skipped, summary.stats.skipped)
        self.assertEqual(self.client.create_session("bob", "vlp16").when_behind,
                         isthmus.WhenBehind.WAIT)
        with self.assertRaisesRegex(isthmus.InvalidArgument, "keep-newest"):
            self.client.create_session("bob", "vlp16", when_behind="never")

    def test_a_session_takes_any_field_of_its_request(self) -> None:
        first = self.client.create_session("bob", "vlp16", request_id="once")
        self.assertEqual(self.client.create_session("bob", "vlp16", request_id="once").id, first.id)
        with self.assertRaisesRegex(isthmus.InvalidArgument, "request_id"):
            self.client.create_session("bob", "vlp16", request_id=7)
        with self.assertRaisesRegex(TypeError, "request_id"):
            self.client.create_session("bob", "vlp16", wish="once")
        with self.assertRaisesRegex(TypeError, "wish"):
            self.client.push("bob", [], sensor="vlp16", wish="once")

    def test_rounded_scans_lead_where_raw_ones_do(self) -> None:
        drive = scans(0)[:20]
        rounded = self.client.push("alice", drive, sensor="vlp16", resolution=0.002)
        raw = self.client.push("bob", drive, sensor="vlp16", resolution=0)
        self.assertLess(rounded.stats.sent_bytes, raw.stats.sent_bytes / 3)
        a, b = (self.client.trajectory(robot, "odom")[1][-1] for robot in ("alice", "bob"))
        np.testing.assert_allclose(a, b, atol=0.01)

    def test_scans_that_cannot_be_used_are_named_and_the_rest_goes_on(self) -> None:
        drive = list(scans(0)[:12])
        good = drive[3].points
        refused = {
            2: np.zeros((5, 2)),  # No points at all: found here.
            4: np.zeros((0, 3), np.float32),
            6: good[["x", "y"]],
            8: SimpleNamespace(height=1, width=7, point_step=0, fields=[], data=b"",
                               is_bigendian=False),
            10: np.full((100, 3), np.nan, np.float32),
        }
        for k, points in refused.items():
            drive[k] = isthmus.Scan(drive[k].stamp_ns, points)
        summary = self.client.push("alice", drive, sensor="vlp16")
        self.assertEqual([rejection.sequence for rejection in summary.rejected],
                         [k + 1 for k in refused])
        self.assertTrue(all(rejection.reason for rejection in summary.rejected))
        self.assertIn("(N, 3)", summary.rejected[0].reason)
        self.assertIn("no field z", summary.rejected[2].reason)
        self.assertEqual(summary.processed, len(drive) - len(refused))
        self.assertEqual(summary.session.scan_counts.rejected, len(refused))

    def test_sensors_robots_and_sessions_that_are_none(self) -> None:
        for robot, sensor, session, error in (
                ("alice", "", None, isthmus.InvalidArgument),
                ("alice", "camera", None, isthmus.InvalidArgument),
                ("a b", "vlp16", None, isthmus.InvalidArgument),
                ("alice", "vlp16", "alice-9", isthmus.NotFound)):
            with self.assertRaises(error):
                self.client.push(robot, [], sensor=sensor, session=session)
        with self.assertRaisesRegex(isthmus.InvalidArgument, "continuous"):
            self.client.create_session("alice", "vlp16", odometry="guess")

    def test_plain_arrays_of_a_sensor_without_rings(self) -> None:
        clouds = room()
        summary = self.client.push("carol", [(k * 10**8, next(clouds)) for k in range(5)],
                                   sensor="unordered")
        self.assertEqual(summary.processed, 5)

    def test_goes_on_in_a_session_where_it_stands(self) -> None:
        drive = scans(0)[:30]
        first = self.client.push("alice", drive[:18], sensor="vlp16", finish=False)
        self.assertEqual(first.session.state, SessionState.ACTIVE)
        second = self.client.push("alice", drive, session=first.session.id)
        self.assertEqual((second.skipped, second.processed), (18, 12))
        stamps, _ = self.client.trajectory("alice", "odom")
        np.testing.assert_array_equal(stamps, [scan.stamp_ns for scan in drive])
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "is finished"):
            self.client.open_stream(first.session.id)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "is finished"):
            self.client.push("alice", scans(0)[:31], session=first.session.id)
        self.assertEqual(self.client.push("alice", drive, session="alice-1").skipped, 30)
        with self.assertRaisesRegex(isthmus.InvalidArgument, "of robot alice"):
            self.client.push("bob", drive, session=first.session.id)

    def test_a_live_stream_from_several_threads(self) -> None:
        session = self.client.create_session("alice", "unordered",
                                             isthmus.Pose((0, 0, 1)), isthmus.Odometry.CONTINUOUS)
        np.testing.assert_allclose(session.T_base_sensor.translation, (0, 0, 1))
        with self.client.open_stream(session, window=4) as stream:
            stamps = iter(range(0, 10**12, 10**8))
            lock = threading.Lock()

            def push() -> None:
                for cloud, _ in zip(room(500), range(5)):
                    with lock:
                        stream.push(next(stamps), cloud)

            threads = [threading.Thread(target=push) for _ in range(3)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual([ack.sequence for ack in stream.acks()], list(range(1, 16)))
        self.assertEqual(stream.finish_session().state, SessionState.FINISHED)
        self.assertEqual(stream.finish_session().last_sequence, 15)  # Twice is no error.

    def test_an_exception_of_the_scans_reaches_the_caller(self) -> None:
        def broken():
            yield scans(0)[0]
            raise OSError("the disk with the scans")

        with self.assertRaisesRegex(OSError, "the disk"):
            self.client.push("alice", broken(), sensor="vlp16")


class RestartTest(unittest.TestCase):
    """A server that is killed comes back at the same address with the same folder."""

    def drive(self, seconds: int, at: dict) -> list:
        """Poses of a drive, where with the given acknowledgements something happens."""
        with Server() as server, isthmus.connect(server.address) as client:
            acks: List[isthmus.Ack] = []

            def note(ack: isthmus.Ack) -> None:
                acks.append(ack)
                if ack.sequence in at:
                    at.pop(ack.sequence)(server)
                    server.start()

            drive = scans(0, seconds, 1)
            summary = client.push("alice", drive, sensor="vlp16", on_ack=note)
            self.assertEqual(at, {})
            self.assertEqual([ack.sequence for ack in acks], list(range(1, len(drive) + 1)))
            self.assertEqual(summary.session.scan_counts.ok, len(drive))
            self.assertEqual(summary.session.durable_sequence, len(drive))
            stamps, poses = client.trajectory("alice", "odom")
            np.testing.assert_array_equal(stamps, [scan.stamp_ns for scan in drive])
            self.reconnects = summary.stats.reconnects
            self.outcomes = {ack.outcome for ack in acks}
            return poses

    def test_nothing_is_lost_and_nothing_doubled_by_kills(self) -> None:
        undisturbed = self.drive(21, {})
        self.assertEqual(self.reconnects, 0)
        # Before and after scans have become durable, which they do by 200.
        disturbed = self.drive(21, {30: Server.kill, 90: Server.kill, 205: Server.kill})
        self.assertGreaterEqual(self.reconnects, 3)
        np.testing.assert_array_equal(disturbed, undisturbed)

    def test_nor_by_a_stop_which_stores_what_it_has(self) -> None:
        def stop(server: Server) -> None:
            self.assertEqual(server.stop(), 0)

        undisturbed = self.drive(6, {})
        np.testing.assert_array_equal(self.drive(6, {15: stop, 58: stop}), undisturbed)
        self.assertLessEqual(self.outcomes, {Outcome.PROCESSED, Outcome.DUPLICATE})

    def test_gives_up_in_the_end_and_says_so(self) -> None:
        with Server() as server, isthmus.connect(server.address, timeout=0.5) as client:
            session = client.create_session("alice", "vlp16")
            stream = client.open_stream(session, keep_trying_s=0.5)
            server.kill()
            stream.push(1, scans(0)[0].points)
            with self.assertRaisesRegex(isthmus.Unavailable, "cannot reach isthmus-server"):
                stream.finish()
            with self.assertRaises(isthmus.Unavailable):
                client.status()
            server.start()
            with isthmus.connect(server.address) as again:
                self.assertEqual(again.get_session(session.id).last_sequence, 0)


class ConnectTest(unittest.TestCase):
    def test_the_package_has_the_servers_version(self) -> None:
        said = subprocess.run([SERVER, "--version"], capture_output=True, text=True, check=True)
        self.assertEqual(said.stdout.split()[-1], isthmus.__version__)

    def test_says_which_address_does_not_answer(self) -> None:
        with self.assertRaisesRegex(isthmus.Unavailable, "127.0.0.1:1:") as caught:
            isthmus.connect("127.0.0.1:1", timeout=0.2)
        self.assertIsInstance(caught.exception, ConnectionError)
        self.assertIsInstance(caught.exception, isthmus.Error)

    def test_an_address_that_is_none_is_refused_at_once(self) -> None:
        for address in ("localhost", "localhost:0", "localhost:65536", ":50051", "localhost:http"):
            with self.assertRaisesRegex(isthmus.InvalidArgument, "write HOST:PORT"):
                isthmus.connect(address)

    def test_a_client_waits_for_a_server_that_comes_later(self) -> None:
        with Server() as server:
            server.kill()
            client = isthmus.connect(server.address, timeout=20, require_server=False)
            starting = threading.Thread(target=server.start)
            starting.start()
            with client:
                self.assertEqual(client.status().revision, 0)
                self.assertEqual(client.address, server.address)
            starting.join()
            with self.assertRaises(isthmus.Error):
                client.status()


if __name__ == "__main__":
    unittest.main()
