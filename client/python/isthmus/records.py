"""What the server tells of scans, sessions and transfers.

Attributes are those of the messages in api/isthmus/v1, where every unit and frame is written; poses
are called `T_target_source`. A moment `x_ns` is nanoseconds since the Unix epoch, and `x` the same
as a datetime in UTC, None for 0. All are immutable.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

import numpy as np

from isthmus.enums import (LocalisationState, Odometry, Outcome, SessionState, Tracking,
                           WhenBehind)
from isthmus.pose import Array, Pose
from isthmus.times import Utc

Triple = Tuple[float, float, float]


@dataclass(frozen=True)
class Box:
    """Axis-aligned; metres. `min` must not exceed `max` in any coordinate."""

    min: Triple
    max: Triple


@dataclass(frozen=True)
class ScanCounts:
    """What became of a session's scans."""

    ok: int = 0
    degenerate: int = 0
    lost: int = 0
    rejected: int = 0
    skipped: int = 0


@dataclass(frozen=True)
class ScanTiming:
    """Computing time of one scan's odometry; milliseconds of wall time."""

    features_ms: float
    matching_ms: float
    map_ms: float
    total_ms: float


@dataclass(frozen=True)
class Session:
    """One run of one robot, or a later segment of one."""

    id: str
    robot: str
    sensor: str
    T_base_sensor: Optional[Pose]
    state: SessionState
    created_ns: int
    finished_ns: int
    last_sequence: int
    durable_sequence: int
    scans_processed: int
    scans_rejected: int
    submap_count: int
    point_count: int
    odometry_ms_mean: float
    travelled_m: float
    tracking: Tracking
    component: Optional[int]
    T_map_odom: Optional[Pose]
    odometry: Odometry
    input: str
    map_bytes: int
    scan_bytes: int
    quota_bytes: int
    archive_problem: str
    segment: int
    first_segment: str
    segments: int
    scan_counts: Optional[ScanCounts]
    lost_since_ns: int
    when_behind: WhenBehind
    created = Utc()
    finished = Utc()
    lost_since = Utc()


@dataclass(frozen=True)
class Ack:
    """What became of one scan.

    `T_odom_sensor` is where the sensor was at the END of the scan; `T_map_odom @ T_odom_sensor` is
    its place in the map, once the session has been placed. Both are in the odom frame of `segment`;
    when that number grows, poses begin anew.
    """

    sequence: int
    outcome: Outcome
    reason: str  # Why it was rejected.
    tracking: Tracking
    T_odom_sensor: Optional[Pose]
    T_map_odom: Optional[Pose]
    durable_sequence: int
    timing: Optional[ScanTiming]
    # (6, 6), order x y z and rotations about them, sensor frame; m^2 and rad^2. None if not told.
    covariance: Optional[Array] = field(compare=False)
    unobserved_translations: Tuple[Triple, ...]  # Unit vectors, sensor frame.
    unobserved_rotations: Tuple[Triple, ...]
    segment: int
    segment_session: str
    lost_since_ns: int
    scan_counts: Optional[ScanCounts]
    session: str = ""
    stamp_ns: int = 0  # END of the scan, as it was pushed.
    lost_since = Utc()
    stamp = Utc()

    def covariance_in_odom(self) -> Optional[Array]:
        """`covariance` about the axes of the odom frame, as nav_msgs/Odometry wants it."""
        if self.covariance is None or self.T_odom_sensor is None:
            return None
        turn = np.kron(np.eye(2), self.T_odom_sensor.rotation)
        rotated: Array = turn @ self.covariance @ turn.T
        return rotated


@dataclass(frozen=True)
class LocalisedScan:
    """What is known of the place where a scan was taken.

    While LOCATED or UNCERTAIN there are `T_map_sensor`, at the END of the scan, and `T_map_odom`.
    `T_odom_sensor` is in a frame of the stream's own; when `segment` grows it begins anew.
    """

    sequence: int
    state: LocalisationState
    rejected: str  # Why it could not be used; else empty.
    T_map_sensor: Optional[Pose]
    # Of T_map_sensor; (6, 6), order x y z and rotations about them, sensor frame; m^2 and rad^2.
    covariance: Optional[Array] = field(compare=False)
    T_map_odom: Optional[Pose]
    T_odom_sensor: Optional[Pose]
    tracking: Tracking
    segment: int
    revision: int  # Of the map that it was looked for in.
    component: int
    odometry_ms: float
    localising_ms: float


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
    lost: int = 0  # Of what a crash of the server took, scans that were no longer kept here.
    durable_sequence: int = 0
    sent_bytes: int = 0  # Of clouds, what was sent again included.
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
class BackupContents:
    """What is in a backup."""

    sessions: int
    submaps: int
    scans: int
    points: int
    damaged: int
    report: str


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
