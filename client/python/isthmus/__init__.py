"""Isthmus joins the LiDAR maps of many robots into one; this is its client for Python.

    import isthmus

    with isthmus.connect("127.0.0.1:50051") as client:
        client.push("alice", scans, sensor="vlp16")
        client.export("merged.pcd")

`connect` gives a `Client`; its methods are the server's services, see docs/python.md.
"""
import os

os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # What matters of it is in our errors.

# pylint: disable=wrong-import-position
from isthmus.client import Client, connect
from isthmus.cloud import xyz
from isthmus._localisation import Localisation
from isthmus.enums import (Decision, EventKind, GuessSource, LocalisationState, MatchState,
                           Odometry, Outcome, Reason, Role, SessionState, Tracking, WhenBehind)
from isthmus.errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, Error,
                            FailedPrecondition, Internal, InvalidArgument, NotFound, OutOfRange,
                            PermissionDenied, ResourceExhausted, Unauthenticated, Unavailable,
                            Unimplemented, Unknown)
from isthmus.map_records import (Anchor, Anchored, Component, Datum, Loop, ManualDecision, MapInfo,
                                 Match, MatchGraph, Placement, ReplicaState, Revision,
                                 RevisionDiff, SessionPair, StageTime, Submap, SubmapEdge,
                                 SubmapMove, Trajectory)
from isthmus.pose import Pose
from isthmus.push import Scan
from isthmus.records import (Ack, Backup, BackupContents, BackupState, Box, ExportSummary,
                             LocalisedScan, PushSummary, Rejection, ScanCounts, ScanTiming,
                             Session, StreamStats)
from isthmus.status_records import (CacheLoad, DegradedService, DiskLoad, Localising, MatchingLoad,
                                    ProcessUse, QueueLoad, RobotPlace, RunningCalls, ServerStatus,
                                    SessionLoad)
from isthmus.stream import ScanStream
from isthmus.times import to_datetime, to_ns
from isthmus._access import Token
from isthmus._changes import ChangedVolume, ChangeList
from isthmus._events import Event
from isthmus._regions import Corridor, OrientedBox, Polygon
from isthmus._tiles import MapStep, SubmapPlace, Tile, TileId, TileInfo
from isthmus._uploads import OwnSubmap
from isthmus.version import VERSION

__version__ = VERSION

__all__ = [
    "Aborted", "Ack", "AlreadyExists", "Anchor", "Anchored", "Backup", "BackupContents",
    "BackupState", "Box", "CacheLoad", "Cancelled", "ChangeList", "ChangedVolume", "Client",
    "Component", "Corridor", "DataLoss", "Datum", "DeadlineExceeded", "Decision", "DegradedService",
    "DiskLoad", "Error", "Event", "EventKind", "ExportSummary", "FailedPrecondition",
    "GuessSource", "Internal", "InvalidArgument", "Localisation", "LocalisationState",
    "LocalisedScan", "Localising", "Loop", "ManualDecision", "MapInfo", "MapStep", "Match", "MatchGraph",
    "MatchState", "MatchingLoad", "NotFound", "Odometry", "OrientedBox", "OutOfRange",
    "Outcome", "OwnSubmap", "PermissionDenied", "Placement", "Polygon", "Pose", "ProcessUse",
    "PushSummary", "QueueLoad", "Reason", "Rejection", "ReplicaState", "ResourceExhausted", "Revision",
    "RevisionDiff", "RobotPlace", "Role", "RunningCalls", "Scan", "ScanCounts", "ScanStream",
    "ScanTiming", "ServerStatus", "Session", "SessionLoad", "SessionPair", "SessionState",
    "StageTime", "StreamStats", "Submap", "SubmapEdge", "SubmapMove", "SubmapPlace", "Tile",
    "TileId", "TileInfo", "Token", "Tracking", "Trajectory", "Unauthenticated", "Unavailable",
    "Unimplemented", "Unknown", "WhenBehind", "connect", "to_datetime", "to_ns", "xyz",
]
