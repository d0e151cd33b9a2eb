"""Messages of the API to records, and back. Private to the package.

A record has the fields of its message, by their names: only T_... are written with a capital, and
`from_` is no word of Python. So one function reads them all, by what the message's description says
of each field.
"""
from __future__ import annotations

import dataclasses
from typing import Any, Optional, Tuple, Type, TypeVar

import numpy as np

from isthmus._arguments import numbers, request, word, wrong
from isthmus._basics import Box
from isthmus.pose import Array, Pose
from isthmus.v1 import types_pb2
from isthmus.v1.records import RECORDS, WORDS

T = TypeVar("T")
_MATRICES = ("covariance", "information")


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


def message(kind: Type[T], **fields: Any) -> T:
    """A message of the API whose fields have these names, T_... with a capital, and are as users
    have them: words or their names, poses. Those that are None are left out. `InvalidArgument` for
    a value, `TypeError` for a name that is none."""
    described: Any = kind
    known = {"T_" + name[2:] if name.startswith("t_") else name: field
             for name, field in described.DESCRIPTOR.fields_by_name.items()}
    unknown = [name for name in fields if name not in known]
    if unknown:
        raise TypeError(f"{unknown[0]} is none of {', '.join(known)}")
    return request(kind, **{known[name].name: _value_to(name, value, known[name])
                            for name, value in fields.items() if value is not None})


def _value_to(name: str, value: Any, field: Any) -> Any:
    if field.enum_type is not None:
        return word(name, WORDS[field.enum_type.full_name], value)
    if field.message_type is not None and field.message_type.full_name == "isthmus.v1.Pose":
        return pose_to(name, value)
    return value


def _vector_from(message: types_pb2.Vector3) -> Tuple[float, float, float]:
    return (message.x, message.y, message.z)


def record(kind: Type[T], message: Any, **others: Any) -> T:
    """The message as a record; `others` are fields that it does not have. What is absent has the
    record's default."""
    described = message.DESCRIPTOR.fields_by_name
    for field in dataclasses.fields(kind):
        description = described.get(field.name.lower().rstrip("_"))
        if field.name in others or description is None:
            continue
        is_repeated = description.label == description.LABEL_REPEATED
        if is_repeated or not description.has_presence or message.HasField(description.name):
            others[field.name] = _value(getattr(message, description.name), description)
    return kind(**others)


def _value(value: Any, field: Any) -> Any:
    if field.name in _MATRICES:
        return symmetric(value)
    if field.label == field.LABEL_REPEATED:
        return tuple(_one(item, field) for item in value)
    return _one(value, field)


def _one(value: Any, field: Any) -> Any:
    if field.enum_type is not None:
        return WORDS[field.enum_type.full_name](value)
    if field.message_type is None:
        return value
    name = field.message_type.full_name
    if name == "isthmus.v1.Pose":
        return pose_from(value)
    if name == "isthmus.v1.Vector3":
        return _vector_from(value)
    kind: Any = Box if name == "isthmus.v1.Box" else RECORDS[name]
    return record(kind, value)
