"""Streams of scans: bounded, in order, taken up again after every kind of lost link."""
import itertools
import threading
import unittest
from typing import Any, List, Optional
from unittest import mock

import grpc
import numpy as np

import isthmus
from fake_server import FakeServer
from isthmus import Outcome
from isthmus.link import Backoff
from isthmus.v1 import map_service_pb2
from servers import temporary_folder

POINTS = np.ones((50, 3), np.float32)


class StreamTest(unittest.TestCase):
    def setUp(self) -> None:
        self.server = self.enterContext(FakeServer())
        self.client = self.enterContext(isthmus.connect(self.server.address, timeout=5))

    def test_push_waits_while_the_window_is_full(self) -> None:
        stream = self.client.open_stream("alice-1", window=4)
        fifth = threading.Event()

        def push() -> None:
            for k in range(5):
                stream.push(k, POINTS)
            fifth.set()

        thread = threading.Thread(target=push)
        thread.start()
        self.assertTrue(self.server.await_received(1))
        self.assertFalse(fifth.is_set())  # Nothing was acknowledged, so only four may be.
        self.assertLessEqual(stream.stats.pushed, 4)
        self.server.open_gate()
        self.assertTrue(fifth.wait(20))
        thread.join()
        stream.finish()
        self.assertEqual(self.server.received, [1, 2, 3, 4, 5])

    def test_drops_the_newest_if_asked_to(self) -> None:
        stream = self.client.open_stream("alice-1", window=3, when_full="drop_newest")
        taken = [stream.push(k, POINTS) for k in range(10)]
        self.assertEqual(taken, [True] * 3 + [False] * 7)
        self.server.open_gate()
        stream.finish()
        self.assertEqual(stream.stats.dropped, 7)
        self.assertEqual(self.server.received, [1, 2, 3])  # Numbers have no gaps.
        self.assertEqual([ack.stamp_ns for ack in stream.acks()], [0, 1, 2])

    def test_acknowledgements_come_once_and_in_order_by_both_ways(self) -> None:
        self.server.open_gate()
        told: List[isthmus.Ack] = []
        with self.client.open_stream("alice-1", on_ack=told.append) as stream:
            reader: List[isthmus.Ack] = []
            thread = threading.Thread(target=lambda: reader.extend(stream.acks()))
            thread.start()
            for k in range(40):
                stream.push(k, POINTS)
        thread.join()
        self.assertEqual([ack.sequence for ack in told], list(range(1, 41)))
        self.assertEqual(reader, told)
        self.assertEqual({ack.outcome for ack in told}, {Outcome.PROCESSED})

    def test_a_lost_acknowledgement_is_a_duplicate_and_nothing_is_lost(self) -> None:
        self.server.open_gate()

        def lose_link(scan: Any, context: Any) -> None:
            if scan.sequence == 3 and self.server.streams == 1:
                self.server.last_sequence = 3  # It has the scan, but the link dies.
                context.abort(grpc.StatusCode.UNAVAILABLE, "cut")

        self.server.on_scan = lose_link
        with self.client.open_stream("alice-1") as stream:
            for k in range(6):
                stream.push(k, POINTS)
        outcomes = [ack.outcome for ack in stream.acks()]
        self.assertEqual(outcomes, [Outcome.PROCESSED] * 2 + [Outcome.DUPLICATE]
                         + [Outcome.PROCESSED] * 3)
        self.assertEqual((stream.stats.reconnects, self.server.last_sequence), (1, 6))

    def test_what_a_crash_took_is_sent_again_also_at_the_very_end(self) -> None:
        self.server.open_gate()
        self.server.finish_errors = [grpc.StatusCode.ABORTED]

        def crash_at_the_end(scan: Any, context: Any) -> None:
            if self.server.streams == 2 and scan.sequence == 3:  # It lost all but two.
                self.server.last_sequence = 2

        stream = self.client.open_stream("alice-1")
        for k in range(5):
            stream.push(k, POINTS)
        stream.finish()
        self.server.last_sequence = 2
        self.server.on_scan = crash_at_the_end
        session = stream.finish_session()
        self.assertEqual(session.last_sequence, 5)
        self.assertEqual(self.server.received, [1, 2, 3, 4, 5, 3, 4, 5])
        self.assertEqual(stream.stats.processed, 5)

    def test_goes_on_at_the_next_server_behind_what_that_has(self) -> None:
        self.server.open_gate()
        after = self.enterContext(FakeServer())
        after.open_gate()

        def end(scan: Any, context: Any) -> None:
            if scan.sequence == 3:
                context.abort(grpc.StatusCode.UNAVAILABLE, "taken over")

        self.server.on_scan = end
        both = f"{self.server.address}, {after.address}"
        with isthmus.connect(both, timeout=5) as client:
            self.assertEqual(client.address, both)
            with client.open_stream("alice-1") as stream:
                for k in range(6):
                    stream.push(k, POINTS)
            self.assertEqual(client.get_session("alice-1").last_sequence, 6)
        self.assertEqual(self.server.last_sequence, 2)
        self.assertEqual(after.received, [1, 2, 3, 4, 5, 6])  # Nothing was durable.
        self.assertEqual(stream.stats.processed, 6)

    def test_a_call_finds_the_server_that_has_the_map(self) -> None:
        with FakeServer() as gone:
            nobody = gone.address
        with mock.patch.object(Backoff, "next", wraps=Backoff(5, 2).next) as waits:
            with isthmus.connect(f"{nobody},{self.server.address}", timeout=5) as client:
                self.assertEqual(client.get_session("alice-1").id, "alice-1")
            self.assertEqual(waits.call_count, 1)
        with self.assertRaisesRegex(isthmus.Unavailable, "no server there has the map"):
            isthmus.connect(f"{nobody},{nobody}", timeout=0)
        with self.assertRaises(isthmus.InvalidArgument):
            isthmus.connect(f"{nobody},b")

    def test_goes_round_all_servers_before_it_waits(self) -> None:
        backoff = Backoff(100, 3)
        waits = [backoff.next() for _ in range(6)]
        self.assertEqual([wait == 0 for wait in waits], [True, True, False] * 2)

    def test_numbers_of_scans_that_are_no_longer_kept_are_filled(self) -> None:
        self.server.open_gate()
        widths = {}

        def note(scan: Any, context: Any) -> None:
            widths[scan.sequence] = scan.cloud.width
            if scan.sequence == 5 and self.server.streams == 1:
                self.server.last_sequence = 0  # A crash, with nothing durable.
                context.abort(grpc.StatusCode.UNAVAILABLE, "cut")

        self.server.on_scan = note
        with self.client.open_stream("alice-1", resolution=0, window=1,
                                     keep_bytes=2 * POINTS.nbytes) as stream:
            for k in range(6):
                stream.push(k, POINTS)
        self.assertEqual(stream.stats.lost, 2)
        self.assertEqual(widths, {1: 0, 2: 0, 3: 50, 4: 50, 5: 50, 6: 50})

    def test_scans_of_others_in_the_session_are_found_out(self) -> None:
        self.server.open_gate()

        def other(scan: Any, context: Any) -> None:
            self.server.last_sequence = 100
            context.abort(grpc.StatusCode.CANCELLED, "taken over")

        self.server.on_scan = other
        stream = self.client.open_stream("alice-1")
        stream.push(1, POINTS)
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "another program"):
            stream.finish()

    def test_another_session_of_the_name_is_not_taken_for_its_own(self) -> None:
        self.server.open_gate()
        stream = self.client.open_stream("alice-1")
        stream.push(1, POINTS)
        stream.finish()
        self.server.created_ns = 2
        with self.assertRaisesRegex(isthmus.NotFound, "another one now"):
            stream.finish_session()

    def test_a_stream_goes_on_behind_the_scans_of_an_earlier_program(self) -> None:
        self.server.open_gate()
        session = self.client.get_session("alice-1")
        self.server.last_sequence = 7  # Taken up since then.
        with self.client.open_stream(session) as stream:
            stream.push(1, POINTS)
        self.assertEqual([ack.sequence for ack in stream.acks()], [8])
        self.assertEqual(stream.stats.processed, 1)

    def test_a_full_server_is_asked_again_when_it_wants_to_be(self) -> None:
        self.server.open_gate()
        waits = self.waits()
        session = self.client.get_session("alice-1")
        self.server.refusals = [2500]
        stream = self.client.open_stream(session)
        stream.push(1, POINTS)
        stream.finish()
        self.assertEqual(self.server.received, [1])
        self.server.refusals = [1500, 3500]
        self.client.create_session("alice", "vlp16")
        self.server.refusals = [4500]
        self.server.answers["ListLoops"] = [map_service_pb2.ListLoopsResponse()]
        self.client.list_loops("alice")
        self.server.refusals = [5500]
        with self.client.open_localisation("vlp16") as localisation:
            self.assertEqual(localisation.locate(1, POINTS).sequence, 1)
        # Each refused call was to wait as long as the server asked for.
        self.assertEqual(waits, [2.5, 1.5, 3.5, 4.5, 5.5])

    def test_answers_without_end_are_refused(self) -> None:
        loops, file = map_service_pb2.ListLoopsResponse(), map_service_pb2.ExportMapResponse()
        loops.loops.add().detail = "x" * 10_000
        file.data = b"x" * 10_000
        path = temporary_folder() / "map.pcd"
        with isthmus.connect(self.server.address, max_answer_bytes=1_000_000,
                             max_file_bytes=1_000_000) as client:
            self.server.answers["ListLoops"] = itertools.repeat(loops)
            with self.assertRaises(isthmus.ResourceExhausted):
                client.list_loops()
            self.server.answers["ExportMap"] = itertools.repeat(file)
            with self.assertRaises(isthmus.ResourceExhausted):
                client.export(path)
        self.assertEqual(list(path.parent.iterdir()), [])

    def test_a_full_server_that_stays_full_is_an_error_that_says_so(self) -> None:
        self.waits(keep_trying=False)
        self.server.refusals = [2500]
        with self.assertRaises(isthmus.ResourceExhausted) as caught:
            self.client.create_session("alice", "vlp16")
        self.assertEqual(caught.exception.retry_after_s, 2.5)

    def test_a_scan_above_the_servers_limit_names_the_setting(self) -> None:
        self.server.open_gate()
        stream = self.client.open_stream("alice-1")
        stream.push(1, np.random.default_rng(1).uniform(-50, 50, (300_000, 3)))
        with self.assertRaisesRegex(isthmus.ResourceExhausted, "network.max_receive_bytes"):
            stream.finish()

    def waits(self, keep_trying: bool = True) -> List[float]:
        """What servers ask to wait for, as it is asked for, in place of waiting."""
        asked: List[float] = []

        def next_delay(_: Backoff, asked_s: Optional[float] = None) -> Optional[float]:
            if asked_s is not None:
                asked.append(asked_s)
            return 0.0 if keep_trying else None

        self.enterContext(mock.patch.object(Backoff, "next", next_delay))
        return asked

    def test_a_wait_is_what_was_asked_for_and_more(self) -> None:
        backoff = Backoff(100)
        delay = backoff.next(3.0)
        assert delay is not None
        self.assertGreaterEqual(delay, 3.0)
        self.assertLess(delay, 3.3)

    def test_an_exception_of_on_ack_ends_the_stream(self) -> None:
        self.server.open_gate()

        def fail(ack: isthmus.Ack) -> None:
            raise KeyError("the robot's own mistake")

        stream = self.client.open_stream("alice-1", on_ack=fail)
        stream.push(1, POINTS)
        with self.assertRaisesRegex(KeyError, "own mistake"):
            stream.finish()
        with self.assertRaises(KeyError):
            stream.push(2, POINTS)

    def test_points_that_cannot_be_sent_leave_the_stream_as_it_is(self) -> None:
        self.server.open_gate()
        with self.client.open_stream("alice-1") as stream:
            with self.assertRaises(isthmus.InvalidArgument):
                stream.push(1, np.zeros((5, 2)))
            stream.push(2, POINTS)
        self.assertEqual(self.server.received, [1])
        with self.assertRaisesRegex(isthmus.FailedPrecondition, "finished"):
            stream.push(3, POINTS)

    def test_closing_gives_up_at_once(self) -> None:
        stream = self.client.open_stream("alice-1")
        stream.push(1, POINTS)
        self.assertTrue(self.server.await_received(1))
        stream.close()
        with self.assertRaises(isthmus.Cancelled):
            stream.finish()

    def test_options_are_checked(self) -> None:
        with self.assertRaisesRegex(isthmus.InvalidArgument, "drop_newest"):
            self.client.open_stream("alice-1", when_full="drop")


class ExportTest(unittest.TestCase):
    def test_a_file_that_is_not_whole_is_none(self) -> None:
        part, folder = map_service_pb2.ExportMapResponse, temporary_folder()
        cut = [part(data=b"abc")]
        wrong = [part(data=b"abc"), part(last=True, size=3, crc32c=1)]
        with FakeServer() as server, isthmus.connect(server.address, timeout=0.5) as client:
            for answer in (cut, wrong):
                server.answers["ExportMap"] = answer
                with self.assertRaises(isthmus.DataLoss):
                    client.export(folder / "never.pcd")
        self.assertEqual(list(folder.iterdir()), [])


if __name__ == "__main__":
    unittest.main()
