"""Scans of a whole drive, pushed as fast as the server takes them."""
from __future__ import annotations

import contextlib
import logging
import math
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Iterator, List, Optional, Tuple, Union

from isthmus._arguments import number, wrong
from isthmus.cloud import Points
from isthmus.records import Ack, PushSummary, Rejection
from isthmus.errors import Error, InvalidArgument
from isthmus.stream import ScanStream
from isthmus.times import Moment, to_ns
from isthmus.v1.records import Outcome, Session

log = logging.getLogger("isthmus")
MOST_REJECTIONS = 1000  # Kept with their reasons.


@dataclass(frozen=True)
class Scan:
    """One turn of a LiDAR. `points`: see isthmus.cloud; sensor frame."""

    stamp_ns: Moment  # END of the scan.
    points: Points

    @classmethod
    def at_seconds(cls, stamp_s: float, points: Points) -> Scan:
        """With the END of the scan in seconds."""
        if math.isinf(number("stamp_s", stamp_s)):
            raise wrong("stamp_s", "seconds since 1970", stamp_s)
        return cls(round(float(stamp_s) * 1e9), points)


Scans = Iterable[Union[Scan, Tuple[Moment, Points]]]


class NoScan(InvalidArgument):
    """What came in the place of a scan."""


def each_scan(scans: Scans) -> Iterator[Tuple[int, Points]]:
    """The END of each scan in nanoseconds, and its points. `NoScan`, with its number from 1, for
    what is no scan, or has no moment for a stamp."""
    try:
        items = iter(scans)
    except TypeError:
        raise wrong("scans", "a list or an iterator of scans", scans) from None
    for number_of_it, item in enumerate(items, 1):
        stamp_ns, points = _pair(f"scan {number_of_it}", item)
        try:
            end_ns = to_ns(stamp_ns, f"the stamp of scan {number_of_it}")
        except InvalidArgument as error:
            raise NoScan(error.message) from None
        yield end_ns, points


def _pair(what: str, item: Any) -> Tuple[Moment, Points]:
    if isinstance(item, Scan):
        return item.stamp_ns, item.points
    try:
        stamp_ns, points = item
    except (TypeError, ValueError):
        raise NoScan(f"{what} is an isthmus.Scan or a pair (END of the scan in nanoseconds, "
                     f"points), not {type(item).__name__}") from None
    return stamp_ns, points


class Rejections:
    """Collects what was rejected; `on_ack` is the caller's."""

    def __init__(self, on_ack: Optional[Callable[[Ack], None]]) -> None:
        self._on_ack = on_ack
        self.all: List[Rejection] = []
        self.unsendable: dict[int, str] = {}  # By stamp.

    def __call__(self, ack: Ack) -> None:
        if ack.outcome == Outcome.REJECTED and len(self.all) < MOST_REJECTIONS:
            reason = self.unsendable.pop(ack.stamp_ns, ack.reason)
            self.all.append(Rejection(ack.sequence, ack.stamp_ns, reason))
        if self._on_ack is not None:
            self._on_ack(ack)


def push_all(stream: ScanStream, scans: Iterable[Tuple[int, Points]],
             rejections: Rejections) -> None:
    """Hands over every scan; those that cannot be sent use up a number, so that the n-th scan
    behind those of before has the n-th number, and are among the rejected."""
    for stamp_ns, points in scans:
        try:
            stream.push(stamp_ns, points)
        except InvalidArgument as error:
            log.warning("a scan cannot be sent: %s", error)
            rejections.unsendable[stamp_ns] = error.message
            stream.push_empty(stamp_ns)


def push_drive(stream: ScanStream, scans: Iterable[Tuple[int, Points]], rejections: Rejections,
               skipped: int, get_session: Callable[[], Session], finish: bool) -> PushSummary:
    """To the end; the first scans of the drive were skipped. The session is finished after what is
    no scan, too."""
    try:
        push_all(stream, scans, rejections)
        session = None
        if finish:
            session = stream.finish_session()
        else:
            stream.finish()
    except BaseException as error:
        if finish and isinstance(error, NoScan):
            with contextlib.suppress(Error):
                stream.finish_session()
        stream.close()
        raise
    return PushSummary(session or get_session(), stream.stats, tuple(rejections.all), skipped)
