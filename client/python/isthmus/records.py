"""What a transfer comes to, and answers of several parts; isthmus.v1.records has the other records."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from isthmus.pose import Array
from isthmus.times import Utc
from isthmus.v1.records import AckedScan, BackupContents, Match, Placement, Session


@dataclass(frozen=True)
class Ack(AckedScan):
    """What became of one scan.

    `T_odom_sensor` is where the sensor was at the END of the scan; `T_map_odom @ T_odom_sensor` is
    its place in the map, once the session has been placed. Both are in the odom frame of `segment`;
    when that number grows, poses begin anew.
    """

    session: str = ""
    stamp_ns: int = 0  # END of the scan, as it was pushed.
    stamp = Utc()

    def covariance_in_odom(self) -> Optional[Array]:
        """`covariance` about the axes of the odom frame, as nav_msgs/Odometry wants it."""
        if self.covariance is None or self.T_odom_sensor is None:
            return None
        turn = np.kron(np.eye(2), self.T_odom_sensor.rotation)
        rotated: Array = turn @ self.covariance @ turn.T
        return rotated


@dataclass(frozen=True)
class Trajectory:
    """Where a robot's sensor, or the robot itself, was, in one frame, in order of time."""

    session: str
    revision: int
    component: int  # The number of the map whose frame the poses are in.
    stamps_ns: NDArray[np.int64] = field(compare=False)  # (N,), ENDs of scans.
    poses: Array = field(compare=False)  # (N, 4, 4), T_map_sensor and the like.
    segments: NDArray[np.uint32] = field(compare=False)  # (N,), which each pose is of.
    segments_left_out: Tuple[int, ...] = ()

    @property
    def stamps(self) -> NDArray[np.datetime64]:
        """`stamps_ns` as numpy has times, which are UTC: (N,), datetime64[ns]."""
        return self.stamps_ns.view("datetime64[ns]")


@dataclass(frozen=True)
class MatchGraph:
    """Every match, accepted or not, and where the sessions lie."""

    revision: int
    matches: Tuple[Match, ...]
    placements: Tuple[Placement, ...]


@dataclass(frozen=True)
class Rejection:
    """A scan that was of no use, and why."""

    sequence: int
    stamp_ns: int
    reason: str
    stamp = Utc()


@dataclass(frozen=True)
class StreamStats:
    """How a stream of scans goes."""

    pushed: int = 0
    processed: int = 0
    duplicates: int = 0  # Acknowledged as known: their acknowledgement was lost with a link.
    rejected: int = 0
    skipped: int = 0  # By a server that was behind, in a session that keeps the newest.
    dropped: int = 0  # By a full queue, with when_full="drop_newest".
    lost: int = 0  # Scans that a crash of the server took and that were no longer kept here.
    durable_sequence: int = 0
    sent_bytes: int = 0  # Bytes of clouds, those sent again included.
    reconnects: int = 0


@dataclass(frozen=True)
class PushSummary:
    """What became of the scans of one push."""

    session: Session  # As it stands at the end: its `state`, `scan_counts`, `segments`.
    stats: StreamStats
    rejected: Tuple[Rejection, ...]  # The first thousand.
    skipped: int = 0  # Scans that the session had before.

    @property
    def processed(self) -> int:
        """Scans that moved the odometry, as far as acknowledgements came."""
        return self.stats.processed


@dataclass(frozen=True)
class ExportSummary:
    """A file that arrived whole."""

    revision: int
    size: int  # Bytes.
    crc32c: int


@dataclass(frozen=True)
class Backup:
    """A backup that arrived whole."""

    file: ExportSummary
    contents: BackupContents
    has_tokens: bool


@dataclass(frozen=True)
class BackupState:
    """A backup under way."""

    copied: float  # Share of the copy that the server makes first, [0, 1].
    bytes: int  # Received, ...
    total_bytes: int  # ... of the whole, once the copy is made.
