"""Messages of the API to records, and back. Private to the package.

A record has the fields of its message, by their names: only T_... are written with a capital. So
one function reads them all, by what the message's description says of each field.
"""
from __future__ import annotations

import dataclasses
import functools
from typing import Any, Callable, Dict, Optional, Tuple, Type, TypeVar

import numpy as np

from isthmus import enums, map_records, records, status_records
from isthmus._arguments import numbers, wrong
from isthmus.pose import Array, Pose
from isthmus.v1 import types_pb2

T = TypeVar("T")

_ENUMS: Dict[str, Type[enums._Word]] = {
    "isthmus.v1.Tracking": enums.Tracking,
    "isthmus.v1.Odometry": enums.Odometry,
    "isthmus.v1.Session.State": enums.SessionState,
    "isthmus.v1.WhenBehind": enums.WhenBehind,
    "isthmus.v1.StreamScansResponse.Outcome": enums.Outcome,
    "isthmus.v1.LocaliseResponse.State": enums.LocalisationState,
    "isthmus.v1.Match.State": enums.MatchState,
    "isthmus.v1.Match.Reason": enums.Reason,
    "isthmus.v1.GuessSource": enums.GuessSource,
    "isthmus.v1.ManualDecision.Kind": enums.Decision,
}


def pose_from(message: types_pb2.Pose) -> Pose:
    """An absent rotation is none."""
    t, q = message.translation, message.rotation
    turn = (q.x, q.y, q.z, q.w)
    return Pose((t.x, t.y, t.z), turn if any(turn) else (0, 0, 0, 1))


def pose_to(what: str, pose: Pose) -> types_pb2.Pose:
    """`InvalidArgument`, which calls it `what`, for anything else."""
    if not isinstance(pose, Pose):
        raise wrong(what, "an isthmus.Pose, such as Pose.from_matrix makes", pose)
    x, y, z = pose.translation
    qx, qy, qz, qw = pose.quaternion
    return types_pb2.Pose(translation=types_pb2.Vector3(x=x, y=y, z=z),
                          rotation=types_pb2.Quaternion(x=qx, y=qy, z=qz, w=qw))


def vector_to(what: str, values: Any) -> types_pb2.Vector3:
    """Likewise."""
    x, y, z = numbers(what, values, (3,), "three numbers, (x, y, z)").tolist()
    return types_pb2.Vector3(x=x, y=y, z=z)


def symmetric(triangle: Any) -> Optional[Array]:
    """The 6 x 6 matrix of an upper triangle, row by row; None where nothing was told."""
    if len(triangle) != 21:
        return None
    upper = np.zeros((6, 6))
    upper[np.triu_indices(6)] = triangle
    matrix: Array = upper + np.triu(upper, 1).T
    return matrix


def _vector_from(message: types_pb2.Vector3) -> Tuple[float, float, float]:
    return (message.x, message.y, message.z)


def _nested(kind: Type[Any], message: Any) -> Any:
    return record(kind, message)


_MESSAGES: Dict[str, Callable[[Any], Any]] = {
    "isthmus.v1.Pose": pose_from,
    "isthmus.v1.Vector3": _vector_from,
}
for _kind in (records.Box, records.ScanCounts, records.ScanTiming, map_records.Component,
              map_records.Datum,
              map_records.StageTime, map_records.SubmapEdge, map_records.ManualDecision,
              map_records.Match, map_records.Placement, map_records.Revision,
              map_records.ReplicaState, map_records.SessionPair, map_records.SubmapMove, status_records.ProcessUse,
              status_records.RunningCalls, status_records.DegradedService,
              status_records.Localising, status_records.RobotPlace,
              status_records.SessionLoad, status_records.QueueLoad, status_records.MatchingLoad,
              status_records.CacheLoad, status_records.DiskLoad):
    _MESSAGES[f"isthmus.v1.{_kind.__name__}"] = functools.partial(_nested, _kind)
_MATRICES = ("covariance", "information")


def record(kind: Type[T], message: Any, **others: Any) -> T:
    """The message as a record; `others` are fields that it does not have."""
    described = message.DESCRIPTOR.fields_by_name
    values: Dict[str, Any] = dict(others)
    for field in dataclasses.fields(kind):
        description = described.get(field.name.lower())
        if field.name not in values and description is not None:
            values[field.name] = _value(message, description)
    return kind(**values)


def _value(message: Any, field: Any) -> Any:
    value = getattr(message, field.name)
    if field.name in _MATRICES:
        return symmetric(value)
    if field.message_type is not None:
        read = _MESSAGES[field.message_type.full_name]
    elif field.enum_type is not None:
        read = _ENUMS[field.enum_type.full_name]
    else:
        read = _itself
    if field.label == field.LABEL_REPEATED:
        return tuple(read(item) for item in value)
    if field.has_presence and not message.HasField(field.name):
        return None
    return read(value)


def _itself(value: Any) -> Any:
    return value
