"""The part of Client that reads the event log, for operators and administrators."""
from __future__ import annotations

from typing import Iterable, Iterator, List, Optional, Union

import grpc

from isthmus import convert
from isthmus._arguments import listed, request, word
from isthmus.errors import Unavailable, from_rpc
from isthmus.link import Link
from isthmus.times import Moment, to_ns
from isthmus.v1 import event_service_pb2 as pb
from isthmus.v1.records import Event, EventKind


class Events:
    """Part of Client."""

    _link: Link

    def list_events(self, after: Optional[int] = None, *, since_ns: Moment = 0,
                    kinds: Union[str, Iterable[Union[EventKind, str]]] = (), robot: str = "",
                    limit: int = 1000) -> List[Event]:
        """The newest `limit` events, or with `after` the first `limit` after that number, in order.

        At most 10,000. `OutOfRange` where `after` is of another log.
        """
        asked = request(pb.ListEventsRequest, after=after, since_ns=to_ns(since_ns, "since_ns"),
                        kinds=_kinds(kinds), robot=robot, limit=limit)
        parts = self._link.collect(self._link.events.ListEvents, asked)
        return [convert.record(Event, event) for part in parts for event in part.events]

    def watch_events(self, after: Optional[int] = None, *,
                     kinds: Union[str, Iterable[Union[EventKind, str]]] = (),
                     robot: str = "") -> Iterator[Event]:
        """Events as they come, after that number or from now on; each once, also over a connection
        that was lost. Goes on until it is closed, or the server does not answer any more
        (`Unavailable`). Those after `after` that are not kept any more are left out."""
        asked = request(pb.WatchEventsRequest, after=after, kinds=_kinds(kinds), robot=robot)
        backoff = self._link.backoff()
        while True:
            call = self._link.once(lambda: self._link.events.WatchEvents(asked))
            try:
                for response in call:
                    backoff.reset()
                    for event in response.events:
                        asked.after = event.number
                        yield convert.record(Event, event)
                    asked.after = response.up_to
                continue
            except grpc.RpcError as lost:
                error = from_rpc(lost)
            finally:
                call.cancel()
            if not isinstance(error, Unavailable):
                raise error
            delay = backoff.next()
            if delay is None or self._link.closed.wait(delay):
                raise self._link.explain(error)


def _kinds(given: Union[str, Iterable[Union[EventKind, str]]]) -> List[int]:
    """The messages' values of words or names."""
    return [word("a kind of event", EventKind, kind) for kind in listed("kinds", given)]
