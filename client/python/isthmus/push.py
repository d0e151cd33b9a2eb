"""Scans of a whole drive, pushed as fast as the server takes them."""
from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Callable, Iterable, List, Optional, Tuple, Union

from isthmus.cloud import Points
from isthmus.enums import Outcome
from isthmus.errors import InvalidArgument
from isthmus.records import Ack, PushSummary, Rejection, Session
from isthmus.stream import ScanStream
from isthmus.times import Moment, to_ns

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
        return cls(round(stamp_s * 1e9), points)


Scans = Iterable[Union[Scan, Tuple[Moment, Points]]]


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


def push_all(stream: ScanStream, scans: Scans, rejections: Rejections) -> None:
    """Hands over every scan; those that cannot be sent use up a number, so that the n-th scan
    behind those of before has the n-th number, and are among the rejected."""
    for item in scans:
        stamp_ns, points = (item.stamp_ns, item.points) if isinstance(item, Scan) else item
        try:
            stream.push(stamp_ns, points)
        except InvalidArgument as error:
            log.warning("a scan cannot be sent: %s", error)
            rejections.unsendable[to_ns(stamp_ns)] = error.message
            stream.push_empty(stamp_ns)


def push_drive(stream: ScanStream, scans: Scans, rejections: Rejections, skipped: int,
               get_session: Callable[[], Session], finish: bool) -> PushSummary:
    """To the end; the first scans of the drive were skipped."""
    try:
        push_all(stream, scans, rejections)
        session = None
        if finish:
            session = stream.finish_session()
        else:
            stream.finish()
    except BaseException:
        stream.close()
        raise
    return PushSummary(session or get_session(), stream.stats, tuple(rejections.all), skipped)
