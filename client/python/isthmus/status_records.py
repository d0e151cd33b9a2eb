"""What the server tells of itself; see records.py for what holds for all of them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from isthmus.enums import LocalisationState, Tracking
from isthmus.map_records import ReplicaState
from isthmus.pose import Pose
from isthmus.times import Utc


@dataclass(frozen=True)
class ProcessUse:
    """Of the machine by the server's process; zeros where the system does not tell."""

    cpu_s: float
    resident_bytes: int
    threads: int
    open_files: int
    open_files_limit: int


@dataclass(frozen=True)
class RunningCalls:
    """Calls under way, of all sites."""

    streams: int
    queries: int
    exports: int
    lists: int
    others: int


@dataclass(frozen=True)
class DegradedService:
    """One that health checking calls NOT_SERVING."""

    service: str
    why: str


@dataclass(frozen=True)
class Localising:
    """How a robot fares that is found in the map that others made. Times are the server's."""

    state: LocalisationState  # As of its newest scan, like tracking.
    tracking: Tracking
    since_ns: int
    received_ns: int  # When its newest scan came; 0: none has.
    scans: int
    rejected: int
    since = Utc()
    received = Utc()


@dataclass(frozen=True)
class RobotPlace:
    """Where a robot is that is under way; without a component not known yet."""

    robot: str  # Empty only where one that is localised gave no name.
    session: str
    component: Optional[int]
    T_map_sensor: Optional[Pose]
    stamp_ns: int
    lag_ms: float
    localising: Optional[Localising]  # Of one that is localised, and has no session.
    stamp = Utc()


@dataclass(frozen=True)
class SessionLoad:
    """How far the scans of an open session have come. Times are the server's, 0 for none."""

    session: str
    robot: str
    waiting_scans: int
    waiting_bytes: int
    received_sequence: int
    acknowledged_sequence: int
    durable_sequence: int
    received_ns: int
    ack_delay_ns: int
    oldest_unacknowledged_ns: int
    oldest_undurable_ns: int
    scans_processed: int
    scans_rejected: int
    scans_skipped: int
    tracking: Tracking
    lost_since_ns: int
    submaps: int
    map_bytes: int
    scan_bytes: int
    received = Utc()
    oldest_unacknowledged = Utc()
    oldest_undurable = Utc()
    lost_since = Utc()


@dataclass(frozen=True)
class QueueLoad:
    """Scans that wait, of all sessions; the limits are of all and of one session."""

    scans: int
    bytes: int
    bytes_limit: int
    session_scans_limit: int
    session_bytes_limit: int


@dataclass(frozen=True)
class MatchingLoad:
    """What is to be matched: here, and, as jobs, by workers."""

    idle: bool
    submaps: int
    pairs: int
    workers: int
    jobs: int
    jobs_set_aside: int


@dataclass(frozen=True)
class CacheLoad:
    """In memory."""

    bytes: int
    limit_bytes: int


@dataclass(frozen=True)
class DiskLoad:
    """Zeros where nothing is kept on disk."""

    database_bytes: int
    log_bytes: int
    scan_bytes: int
    spilled_bytes: int
    free_bytes: int
    total_bytes: int


@dataclass(frozen=True)
class ServerStatus:
    """How the server is getting on."""

    version: str
    site: str
    started_ns: int
    uptime_s: float
    process: ProcessUse
    calls: RunningCalls
    degraded: Tuple[DegradedService, ...]
    now_ns: int
    sessions: Tuple[SessionLoad, ...]
    localising: Tuple[RobotPlace, ...]
    queues: QueueLoad
    matching: MatchingLoad
    placement_waits: bool
    composition_waits: bool
    map_is_loading: bool
    revision: int
    submaps: int
    composition_ms: float
    placement_ms: float
    estimation_ms: float
    compositions: int
    placements: int
    estimations: int
    submap_cache: CacheLoad
    prepared_maps: CacheLoad
    composed: CacheLoad
    disk: DiskLoad
    storage_problem: str
    uploads: int
    submaps_coming_in: int
    web_address: str
    replica: Optional[ReplicaState]
    started = Utc()
    now = Utc()
