"""Isthmus joins the LiDAR maps of many robots into one; this is its client for Python.

    import isthmus

    with isthmus.connect("127.0.0.1:50051") as client:
        client.push("alice", scans, sensor="vlp16")
        client.export("merged.pcd")

`connect` gives a `Client`; its methods are the server's services, see docs/python.md.
"""
import os

os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # Our errors carry what matters of gRPC's log.

# pylint: disable=wrong-import-position
from isthmus.client import Client, connect
from isthmus.cloud import xyz
from isthmus._basics import Box
from isthmus._localisation import Localisation
from isthmus.errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, Error,
                            FailedPrecondition, Internal, InvalidArgument, NotFound, OutOfRange,
                            PermissionDenied, ResourceExhausted, Unauthenticated, Unavailable,
                            Unimplemented, Unknown)
from isthmus.pose import Pose
from isthmus.push import Scan
from isthmus.records import (Ack, Backup, BackupState, ExportSummary, MatchGraph, PushSummary,
                             Rejection, StreamStats, Trajectory)
from isthmus.stream import ScanStream
from isthmus.times import to_datetime, to_ns
from isthmus._changes import ChangedVolume, ChangeList
from isthmus._regions import Corridor, OrientedBox, Polygon
from isthmus._tiles import MapStep, Tile, TileId, TileInfo
from isthmus._uploads import OwnSubmap
from isthmus.v1.records import (Anchor, Anchored, BackupContents, CacheLoad, Component, Datum,
                                Decision, DegradedService, DiskLoad, Event, EventKind, GuessSource,
                                LocalisationState, LocalisedScan, Localising, Loop, ManualDecision,
                                MapInfo, Match, MatchingLoad, MatchState, Odometry, Outcome,
                                Placement, ProcessUse, QueueLoad, Reason, RefusedMethod,
                                ReplicaState, Revision, RevisionDiff, RobotPlace, Role,
                                RunningCalls, ScanCounts, ScanTiming, ServerStatus, Session,
                                SessionLoad, SessionPair, SessionState, StageTime, Submap,
                                SubmapEdge, SubmapMove, SubmapPlace, Token, Tracking, WhenBehind)
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
    "PushSummary", "QueueLoad", "Reason", "RefusedMethod", "Rejection", "ReplicaState",
    "ResourceExhausted", "Revision", "RevisionDiff", "RobotPlace", "Role", "RunningCalls", "Scan", "ScanCounts", "ScanStream",
    "ScanTiming", "ServerStatus", "Session", "SessionLoad", "SessionPair", "SessionState",
    "StageTime", "StreamStats", "Submap", "SubmapEdge", "SubmapMove", "SubmapPlace", "Tile",
    "TileId", "TileInfo", "Token", "Tracking", "Trajectory", "Unauthenticated", "Unavailable",
    "Unimplemented", "Unknown", "WhenBehind", "connect", "to_datetime", "to_ns", "xyz",
]
