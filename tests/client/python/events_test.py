"""The event log, read and watched over a real socket."""
import unittest

import isthmus
from isthmus import EventKind
from servers import Server


class EventsTest(unittest.TestCase):
    """What a client does is in the log of its server."""

    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.client = self.enterContext(isthmus.connect(self.server.address))

    def test_listed_and_watched(self) -> None:
        # Events are stored one after the other: whoever sees a later one sees the earlier ones.
        self.client.create_session("alice", "vlp16")
        opened = self.client.list_events(kinds="session_opened", robot="alice")
        self.assertEqual(len(opened), 1)
        self.assertEqual((opened[0].kind, opened[0].session, opened[0].who),
                         (EventKind.SESSION_OPENED, "alice-1", ""))
        self.assertTrue(opened[0].from_.startswith("ipv"))
        self.assertIn("alice-1", opened[0].text)
        watched = self.client.watch_events(opened[0].number, kinds=[EventKind.SESSION_OPENED])
        self.client.create_session("bob", "vlp16")
        self.assertEqual(next(watched).session, "bob-1")
        watched.close()
        again = self.client.watch_events(0, kinds=[EventKind.SESSION_OPENED])
        self.assertEqual([next(again).session, next(again).session], ["alice-1", "bob-1"])
        again.close()

    def test_what_makes_no_sense(self) -> None:
        with self.assertRaises(isthmus.InvalidArgument):
            self.client.list_events(kinds=["nonsense"])
        with self.assertRaises(isthmus.OutOfRange):
            self.client.list_events(10**9)
        with self.assertRaises(isthmus.OutOfRange):
            next(self.client.watch_events(10**9))


if __name__ == "__main__":
    unittest.main()
