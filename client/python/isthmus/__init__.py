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
from isthmus._reading import LABELS
from isthmus._regions import Corridor, OrientedBox, Polygon
from isthmus._tiles import MapStep, Tile, TileId, TileInfo
from isthmus._uploads import OwnSubmap
from isthmus.v1 import records as _records
from isthmus.v1.records import *
from isthmus.version import VERSION

__version__ = VERSION

__all__ = [
    "Aborted", "Ack", "AlreadyExists", "Backup", "BackupState", "Box", "Cancelled", "ChangeList",
    "ChangedVolume", "Client", "Corridor", "DataLoss", "DeadlineExceeded", "Error",
    "ExportSummary", "FailedPrecondition", "Internal", "InvalidArgument", "LABELS",
    "Localisation", "MapStep", "MatchGraph", "NotFound", "OrientedBox", "OutOfRange", "OwnSubmap",
    "PermissionDenied", "Polygon", "Pose", "PushSummary", "Rejection", "ResourceExhausted",
    "Scan", "ScanStream", "StreamStats", "Tile", "TileId", "TileInfo", "Trajectory",
    "Unauthenticated", "Unavailable", "Unimplemented", "Unknown", "connect", "to_datetime",
    "to_ns", "xyz",
]
__all__ += _records.__all__
