"""The thread of a stream of scans: opens links, sends, takes acknowledgements. Private."""
from __future__ import annotations

import dataclasses
import logging
import threading
import time
from collections import deque
from typing import Any, Callable, Deque, Dict, Iterator, Optional, Set

import grpc

from isthmus import convert
from isthmus._arguments import number, whole
from isthmus.records import Ack, StreamStats
from isthmus.errors import (Aborted, Cancelled, DeadlineExceeded, Error, FailedPrecondition,
                            Internal, InvalidArgument, NotFound, OutOfRange, Unavailable, Unknown,
                            asked_to_wait, from_rpc, too_large)
from isthmus.link import Link
from isthmus.quantized import check_resolution
from isthmus.v1 import session_service_pb2 as pb
from isthmus.window import ScanWindow
from isthmus.v1.records import Outcome, Session, SessionState

log = logging.getLogger("isthmus")

# Errors that another link may mend: the server went down, it is back with fewer scans than it had
# told of, or gRPC reports a link that was cut at a bad moment.
_WORTH_ANOTHER_TRY = (Unavailable, Aborted, Internal, OutOfRange, Unknown)
_COUNTED = {Outcome.PROCESSED: "processed", Outcome.DUPLICATE: "duplicates",
            Outcome.REJECTED: "rejected", Outcome.SKIPPED: "skipped"}
ACK_QUEUE = 1024


def finished(session: Any) -> FailedPrecondition:
    """Why a session takes no more."""
    return FailedPrecondition(f"session {session.id} is finished: create a new session for robot "
                              f"{session.robot}")


class _Outage:
    """Logs how a link fares that is tried again and again: each reason once, and the end."""

    def __init__(self, session: str) -> None:
        self._session = session
        self._told: Set[type] = set()
        self._since_s = 0.0
        self._failures = 0

    def failed(self, why: BaseException) -> None:
        self._since_s = self._since_s if self._failures else time.monotonic()
        self._failures += 1
        if type(why) not in self._told:
            self._told.add(type(why))
            log.warning("session %s: interrupted, trying again: %s", self._session, why)

    def ended(self) -> None:
        if self._failures:
            log.warning("session %s: goes on after %.1f s, attempt %d", self._session,
                        time.monotonic() - self._since_s, self._failures)
        self._failures = 0
        self._told.clear()


class Sender:
    """What is below ScanStream; see there for what it promises."""

    def __init__(self, link: Link, session: Session, *, resolution: float, window: int,
                 when_full: str, keep_bytes: int, keep_trying_s: float,
                 on_ack: Optional[Callable[[Ack], None]], same_drive: bool = False) -> None:
        if when_full not in ("wait", "drop_newest"):
            raise InvalidArgument(f"when_full is 'wait' or 'drop_newest', not {when_full!r}")
        if session.state == SessionState.FINISHED:
            raise finished(session)
        self._link, self._session, self._created_ns = link, session.id, session.created_ns
        self._resolution, self._when_full = check_resolution(resolution), when_full
        self._keep_trying_s = number("keep_trying_s", keep_trying_s, 0)
        self._on_ack = on_ack
        self._changed = threading.Condition()
        # Guarded by _changed:
        self._window = ScanWindow(session.last_sequence, whole("window", window, 1),
                                  whole("keep_bytes", keep_bytes))
        self._sent_up_to: Optional[int] = None  # Nothing so far.
        # The server may have more scans than it told of: they are those that will be pushed.
        self._same_drive = same_drive
        self._outage = _Outage(session.id)
        self._stats = StreamStats()
        self._acks: Deque[Ack] = deque(maxlen=ACK_QUEUE)
        self._epoch = 0  # The number of the link under way; an older one takes no more scans.
        self._call: Any = None
        self._finishing = self._conclude = self._abandoned = self._progress = False
        self._finished: Optional[Session] = None
        self._failure: Optional[BaseException] = None
        self._done = False
        self._start()

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="isthmus-stream", daemon=True)
        self._thread.start()

    # The stream's own thread runs this section, except _requests, which gRPC calls in another one.

    def _run(self) -> None:
        backoff = self._link.backoff(self._keep_trying_s)
        failure: Optional[BaseException] = None
        while True:
            try:
                self._run_link()
                self._outage.ended()
                break
            except BaseException as error:  # pylint: disable=broad-except
                failure = error
                if not isinstance(error, _WORTH_ANOTHER_TRY) and asked_to_wait(error) is None:
                    break
            with self._changed:
                if self._progress:
                    backoff.reset()
                self._progress = False
                delay = backoff.next(asked_to_wait(failure))
                if delay is None or self._abandoned or self._link.closed.is_set():
                    break
                assert failure is not None
                self._outage.failed(failure)
                failure = None
                self._count("reconnects")
                self._changed.wait_for(lambda: self._abandoned, timeout=delay)
        with self._changed:
            self._done = True
            self._failure = self._link.explain(failure) if isinstance(failure, Error) else failure
            self._interrupt()

    def _run_link(self) -> None:
        """From opening a link to its end; an error unless all is acknowledged and concluded."""
        epoch = self._begin_link(self._ask(self._link.sessions.GetSession,
                                           pb.GetSessionRequest(session=self._session),
                                           self._link.call_timeout_s))
        if not self._complete():
            self._stream(epoch)
        with self._changed:
            self._interrupt()
            if not self._conclude or self._abandoned:
                return
            last = self._window.acked
        answer = self._ask(self._link.sessions.FinishSession,
                           pb.FinishSessionRequest(session=self._session, last_sequence=last),
                           self._link.transfer_timeout_s)
        with self._changed:
            self._finished = convert.record(Session, answer)
            self._stats = dataclasses.replace(self._stats,
                                              durable_sequence=answer.durable_sequence)

    def _ask(self, method: Callable[..., Any], request: Any, timeout_s: float) -> Any:
        try:
            return self._link.once(lambda: method(request, timeout=timeout_s))
        except DeadlineExceeded:
            raise Unavailable(f"no answer within {timeout_s:g} s") from None

    def _begin_link(self, known: pb.Session) -> int:
        """The number of the new link to a server where the session stands so."""
        with self._changed:
            if self._abandoned:
                raise Cancelled("the stream was given up")
            if known.created_ns != self._created_ns:
                raise NotFound(f"session {known.id} is another one now, opened since: the server "
                               "has another map folder, or the session was deleted")
            self._check_numbers(known)
            self._window.rewind(known.last_sequence)
            if known.state == pb.Session.FINISHED and not (self._finishing
                                                           and self._window.settled):
                raise finished(known)
            self._window.durable(known.durable_sequence)
            self._epoch += 1
            return self._epoch

    def _check_numbers(self, known: pb.Session) -> None:
        """Numbers that others have used in the session would be taken for scans of theirs."""
        if self._same_drive:
            return
        if self._sent_up_to is None:  # Scans of an earlier program may just have been taken up.
            self._window.renumber(known.last_sequence)
        elif known.last_sequence > self._sent_up_to:
            raise FailedPrecondition(
                f"session {known.id} has {known.last_sequence} scans, and only those up to "
                f"{self._sent_up_to} were sent from here: another program streams into it; open a "
                "session of your own")

    def _stream(self, epoch: int) -> None:
        failure: Optional[Error] = None
        call = self._link.once(lambda: self._link.sessions.StreamScans(self._requests(epoch)))
        with self._changed:
            self._call = call
        try:
            for response in call:
                self._handle(response)
        except grpc.RpcError as error:
            failure = from_rpc(error)
        finally:
            with self._changed:
                self._call = None
                self._interrupt()
            call.cancel()
        with self._changed:
            abandoned = self._abandoned
        if abandoned:
            raise Cancelled("the stream was given up")
        if isinstance(failure, Cancelled) or (failure is None and not self._complete()):
            raise Unavailable("the server closed the stream")  # It goes down, or was asked to.
        if failure is not None:
            raise too_large(failure)

    def _requests(self, epoch: int) -> Iterator[pb.StreamScansRequest]:
        yield pb.StreamScansRequest(session=self._session)
        while True:
            with self._changed:
                scan = None
                while self._epoch == epoch and scan is None:
                    scan = self._window.take()
                    # Half-closing early is fine: the server acknowledges what is queued first.
                    if scan is None and self._finishing:
                        return
                    if scan is None:
                        self._changed.wait()
                if scan is None:
                    return
                self._sent_up_to = max(self._sent_up_to or 0, scan.sequence)
                self._count("sent_bytes", len(scan.cloud.data))
            yield pb.StreamScansRequest(scan=scan)

    def _handle(self, response: pb.StreamScansResponse) -> None:
        with self._changed:
            durable = max(self._stats.durable_sequence, response.durable_sequence)
            self._stats = dataclasses.replace(self._stats, durable_sequence=durable)
            scan = self._window.acknowledge(response.sequence) if response.sequence else None
            self._window.durable(response.durable_sequence)
            if scan is None:
                return
            ack = convert.record(Ack, response, session=self._session, stamp_ns=scan.end_stamp_ns)
            self._acks.append(ack)
            self._progress = True
            self._outage.ended()
            if ack.outcome in _COUNTED:
                self._count(_COUNTED[ack.outcome])
            self._changed.notify_all()
        if self._on_ack is not None:
            self._on_ack(ack)

    def _complete(self) -> bool:
        with self._changed:
            return self._finishing and self._window.settled

    # With _changed held.

    def _interrupt(self) -> None:
        self._epoch += 1
        if self._abandoned and self._call is not None:
            self._call.cancel()
        self._changed.notify_all()

    def _count(self, what: str, by: int = 1) -> None:
        change: Dict[str, Any] = {what: getattr(self._stats, what) + by}
        self._stats = dataclasses.replace(self._stats, **change)

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure
