"""What the server tells of the map; see records.py for what holds for all of them."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from isthmus.enums import Decision, GuessSource, MatchState, Reason
from isthmus.pose import Array, Pose
from isthmus.records import Box
from isthmus.times import Utc


@dataclass(frozen=True)
class Component:
    """Sessions that accepted matches connect; one map frame."""

    component: int
    reference_session: str
    sessions: Tuple[str, ...]
    robots: Tuple[str, ...]
    point_count: int
    bounds: Optional[Box]  # Map frame.


@dataclass(frozen=True)
class ReplicaState:
    """How a server keeps up that only reads a map which another one has."""

    owner: str
    behind_s: float
    problem: str


@dataclass(frozen=True)
class Datum:
    """Where on the Earth the frame of the anchors has its origin (WGS84)."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0  # Above the ellipsoid.
    heading_deg: float = 0.0  # Of the frame's y axis, clockwise from north.
    given_ns: int = 0  # When it was set; not looked at when it is.
    given = Utc()


@dataclass(frozen=True)
class MapInfo:
    """How the server stands."""

    revision: int
    robots: Tuple[str, ...]
    components: Tuple[Component, ...]
    settled: bool
    composition_ms: float
    estimation_ms: float
    compositions: int
    estimations: int
    composition_max_ms: float
    placement_ms: float
    placements: int
    submaps: int
    retired: int
    damaged: Tuple[str, ...]
    storage_problem: str
    replica: Optional[ReplicaState]  # Of a server that only reads the map.
    datum: Optional[Datum]


@dataclass(frozen=True)
class Submap:
    """A submap without its points; where it lies once it has been placed."""

    session: str
    index: int
    robot: str
    T_odom_submap: Pose
    first_sequence: int
    last_sequence: int
    first_stamp_ns: int
    last_stamp_ns: int
    keyframe_count: int
    point_count: int
    bounds: Optional[Box]  # Submap frame.
    component: Optional[int]
    T_map_submap: Optional[Pose]
    first_stamp = Utc()
    last_stamp = Utc()


@dataclass(frozen=True)
class Trajectory:
    """Where a robot's sensor, or the robot itself, was, in one frame, in order of time."""

    session: str
    revision: int
    component: int  # Of the map frame.
    stamps_ns: NDArray[np.int64] = field(compare=False)  # (N,), ENDs of scans.
    poses: Array = field(compare=False)  # (N, 4, 4), T_map_sensor and the like.
    segments: NDArray[np.uint32] = field(compare=False)  # (N,), which each pose is of.
    segments_left_out: Tuple[int, ...] = ()

    @property
    def stamps(self) -> NDArray[np.datetime64]:
        """`stamps_ns` as numpy has times, which are UTC: (N,), datetime64[ns]."""
        return self.stamps_ns.view("datetime64[ns]")


@dataclass(frozen=True)
class StageTime:
    """Wall time of a part of matching."""

    stage: str
    ms: float


@dataclass(frozen=True)
class SubmapEdge:
    """One submap of session a lies on one of session b."""

    submap_a: int
    submap_b: int
    T_a_b: Pose
    information: Optional[Array] = field(compare=False)  # (6, 6), of [rho; phi], frame of a.


@dataclass(frozen=True)
class ManualDecision:
    """What a person said of a pair."""

    kind: Decision
    note: str
    given_ns: int
    given = Utc()


@dataclass(frozen=True)
class Match:
    """What was found out about a pair of sessions. Numbers that were not computed are -1."""

    session_a: str
    session_b: str
    robot_a: str
    robot_b: str
    T_a_b: Optional[Pose]  # Takes session_b's odom frame to session_a's.
    state: MatchState
    reason: Reason
    detail: str
    confidence: float
    overlap: float
    inliers: int
    residual_m: float
    free_space: float
    comparisons: int
    runner_up: float
    matcher: GuessSource
    computed_ns: int
    stages: Tuple[StageTime, ...]
    in_tree: bool
    manual_decision: Optional[ManualDecision]
    inlier_ratio: float
    shared_area_m2: float
    observability: float
    odometry_residual: float
    cycle_m: float
    cycle_deg: float
    candidates: int
    submaps_a: int
    submaps_b: int
    edges: Tuple[SubmapEdge, ...]
    computed = Utc()


@dataclass(frozen=True)
class Placement:
    """Where a session lies."""

    session: str
    robot: str
    component: int
    reference_session: str
    T_map_odom: Pose  # At its newest submap.


@dataclass(frozen=True)
class MatchGraph:
    """Every match, accepted or not, and where the sessions lie."""

    revision: int
    matches: Tuple[Match, ...]
    placements: Tuple[Placement, ...]


@dataclass(frozen=True)
class Loop:
    """A place that a session came back to."""

    id: int
    session: str
    robot: str
    submap_a: int
    submap_b: int
    T_a_b: Pose  # The newer submap (b) in the older one's frame.
    confidence: float
    overlap: float
    residual_m: float
    free_space: float
    comparisons: int
    source: GuessSource
    detail: str
    computed_ns: int
    rejected: bool
    note: str
    edge_count: int
    edges_used: int
    edges: Tuple[SubmapEdge, ...]
    computed = Utc()


@dataclass(frozen=True)
class Anchor:
    """A submap whose place is known from outside; a sigma of 0: that part is not known."""

    session: str
    index: int
    robot: str
    T_map_submap: Pose
    sigma_xy_m: float
    sigma_z_m: float
    sigma_deg: float
    note: str
    given_ns: int
    given = Utc()


@dataclass(frozen=True)
class SessionPair:
    """Two sessions."""

    session_a: str
    session_b: str


@dataclass(frozen=True)
class Revision:
    """What changed the map, without poses."""

    revision: int
    stamp_ns: int
    cause: str
    matches: Tuple[SessionPair, ...]
    loops: Tuple[int, ...]
    added: int
    moved: int
    removed: int
    largest_move_m: float
    stamp = Utc()


@dataclass(frozen=True)
class SubmapMove:
    """T_map_submap before and after; None where the submap was not in the map."""

    session: str
    index: int
    before: Optional[Pose]
    reference_before: str
    after: Optional[Pose]
    reference_after: str


@dataclass(frozen=True)
class RevisionDiff:
    """How the map changed from one revision to another."""

    from_revision: int
    to_revision: int
    revisions: Tuple[Revision, ...]  # The newest first.
    moves: Tuple[SubmapMove, ...]


@dataclass(frozen=True)
class Anchored:
    """What became of putting an anchor."""

    revision: int
    session: str
    index: int
