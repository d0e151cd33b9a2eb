"""One robot's scans on their way to the server, over as many links as it takes."""
from __future__ import annotations

import dataclasses
from types import TracebackType
from typing import Iterator, Optional, Type

from isthmus._sender import Sender
from isthmus.cloud import Points, to_message
from isthmus.errors import FailedPrecondition
from isthmus.records import Ack, StreamStats
from isthmus.times import Moment, to_ns
from isthmus.v1 import session_service_pb2 as pb
from isthmus.v1.records import Session


class ScanStream(Sender):
    """Made by `Client.open_stream`. Thread safe, though scans of one robot come from one thread.

    When the link is lost it is opened again, with back-off, and what the server lacks is sent
    again: nothing that was pushed is lost and nothing counts twice. Only this program's end loses
    scans that are not durable yet. After `keep_trying_s` without any acknowledgement the stream
    gives up, and from then on every call raises that error.

    As a context manager it finishes the stream (not the session), or gives up on an exception.
    """

    @property
    def session(self) -> str:
        """The id of the session."""
        return self._session

    @property
    def stats(self) -> StreamStats:
        """How it goes, as of now."""
        with self._changed:
            return dataclasses.replace(self._stats, lost=self._window.lost)

    def push(self, stamp_ns: Moment, points: Points) -> bool:
        """Hands over a scan. `stamp_ns` is the END of it, the instant its last point was measured.

        `points`: see isthmus.cloud; sensor frame, each as measured at its own instant. While
        `window` scans are without acknowledgement it waits, or with when_full="drop_newest" counts
        the scan as dropped and returns False. `InvalidArgument` for points that cannot be sent
        and a stamp that is none: the scan was not taken, and the stream goes on.
        """
        return self._push(pb.ScanMessage(end_stamp_ns=to_ns(stamp_ns, "stamp_ns"),
                                         cloud=to_message(points, self._resolution)))

    def push_empty(self, stamp_ns: Moment) -> bool:
        """As `push`, of a scan that cannot be sent: uses up its number, and is rejected."""
        return self._push(pb.ScanMessage(end_stamp_ns=to_ns(stamp_ns, "stamp_ns")))

    def acks(self) -> Iterator[Ack]:
        """Acknowledgements as they come, each once, until the stream has ended.

        For one reader. Of those that are not read the newest 1024 are kept.
        """
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._acks or self._done)
                if not self._acks:
                    self._raise_failure()
                    return
                ack = self._acks.popleft()
            yield ack

    def finish(self) -> None:
        """Waits until every scan is acknowledged and closes the stream. The session stays open."""
        with self._changed:
            self._finishing = True
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._done)
            self._raise_failure()

    def finish_session(self) -> Session:
        """As `finish`, then finishes the session: all is durable, and it takes no more scans."""
        with self._changed:
            self._conclude = self._finishing = True
            if self._done and self._failure is None and self._finished is None:
                self._done = False
                self._start()
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._done)
            self._raise_failure()
            assert self._finished is not None
            return self._finished

    def close(self) -> None:
        """Gives up what is not acknowledged; without effect after `finish`."""
        with self._changed:
            self._abandoned = True
            self._interrupt()
        self._thread.join()

    def __enter__(self) -> ScanStream:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        if kind is None:
            self.finish()
        else:
            self.close()

    def _push(self, scan: pb.ScanMessage) -> bool:
        with self._changed:
            if self._when_full == "wait":
                self._changed.wait_for(
                    lambda: self._done or self._finishing or not self._window.full)
            self._raise_failure()
            if self._finishing or self._done:
                raise FailedPrecondition("the stream was finished")
            if self._window.full:
                self._count("dropped")
                return False
            self._window.add(scan)
            self._count("pushed")
            self._changed.notify_all()
            return True
