"""Rigid transforms between frames.

A pose is named `T_target_source`: it takes the coordinates of a point in frame `source` to those in
frame `target`. Read from right to left the names of neighbours are the same:

    T_map_sensor = T_map_odom @ T_odom_sensor

Frames are right-handed, lengths metres; docs/concepts.md says where each frame lies.
"""
from __future__ import annotations

import math
from typing import Any, Optional, Tuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isthmus._arguments import numbers, wrong
from isthmus.errors import InvalidArgument

Array = NDArray[np.float64]
_ORTHOGONAL_TO = 1e-5  # Float32 matrices of other programs keep to it, hand-typed ones do not.


def _finite(what: str, values: ArrayLike, count: int) -> Tuple[float, ...]:
    wanted = f"{count} finite numbers"
    flat = values.ravel() if isinstance(values, np.ndarray) else values
    found = tuple(map(float, numbers(what, flat, (count,), wanted)))
    if not all(map(math.isfinite, found)):
        raise wrong(what, wanted, values)
    return found


class Pose:
    """A rotation followed by a translation. Immutable, hashable, thread safe.

    `translation`: x, y, z in metres. `quaternion`: x, y, z, w; it is normalised.
    `InvalidArgument` for numbers that are not finite, of another count, or a quaternion of zeros.
    """

    __slots__ = ("_translation", "_quaternion")

    def __init__(self, translation: ArrayLike = (0.0, 0.0, 0.0),
                 quaternion: ArrayLike = (0.0, 0.0, 0.0, 1.0)) -> None:
        self._translation = _finite("a translation", translation, 3)
        turn = _finite("a quaternion (x y z w)", quaternion, 4)
        norm = math.sqrt(sum(value * value for value in turn))
        if norm < 1e-9:
            raise InvalidArgument("a quaternion (x y z w) must not be all zeros")
        self._quaternion = tuple(value / norm for value in turn)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Pose:
        """Of a 4 x 4 matrix, or of a 3 x 3 rotation alone."""
        m = numbers("the matrix of a pose", matrix, (-1, -1), "a 4 x 4 matrix")
        if m.shape not in ((3, 3), (4, 4)) or not np.isfinite(m).all():
            raise InvalidArgument(f"a pose is a finite 4 x 4 matrix, not one of shape {m.shape}")
        turn = m[:3, :3]
        if (np.abs(turn @ turn.T - np.eye(3)).max() > _ORTHOGONAL_TO or np.linalg.det(turn) < 0
                or (m.shape == (4, 4) and np.abs(m[3] - (0, 0, 0, 1)).max() > _ORTHOGONAL_TO)):
            raise InvalidArgument("the matrix is no rigid transform: rotate and move only")
        return cls(m[:3, 3] if m.shape == (4, 4) else (0, 0, 0), _quaternion_of(turn))

    @classmethod
    def from_xyz_rpy(cls, x: float, y: float, z: float, roll: float = 0.0, pitch: float = 0.0,
                     yaw: float = 0.0) -> Pose:
        """Of a place in metres and angles in radians, turned about x, then y, then z."""
        angles = _finite("roll, pitch, yaw", (roll, pitch, yaw), 3)
        about = [cls((0, 0, 0), (*(math.sin(angle / 2) * axis), math.cos(angle / 2)))
                 for axis, angle in zip(np.eye(3), angles)]
        turn = about[2] @ about[1] @ about[0]
        return cls((x, y, z), turn.quaternion)

    @property
    def translation(self) -> Array:
        """x, y, z; metres. A copy."""
        return np.array(self._translation)

    @property
    def quaternion(self) -> Array:
        """x, y, z, w; normalised. A copy."""
        return np.array(self._quaternion)

    @property
    def rotation(self) -> Array:
        """The 3 x 3 rotation matrix."""
        x, y, z, w = self._quaternion
        return np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ])

    def matrix(self) -> Array:
        """The 4 x 4 matrix that takes homogeneous coordinates in `source` to `target`."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self._translation
        return matrix

    def inverse(self) -> Pose:
        """T_source_target of T_target_source."""
        x, y, z, w = self._quaternion
        back = (-x, -y, -z, w)
        return Pose(-(Pose((0, 0, 0), back).rotation @ self.translation), back)

    @overload
    def __matmul__(self, other: Pose) -> Pose: ...

    @overload
    def __matmul__(self, other: ArrayLike) -> Array: ...

    def __matmul__(self, other: Any) -> Any:
        """T_a_b @ T_b_c is T_a_c; T_a_b @ points takes points (3,) or (N, 3) from b to a."""
        if isinstance(other, Pose):
            ax, ay, az, aw = self._quaternion
            bx, by, bz, bw = other._quaternion
            turn = (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)
            return Pose(self.rotation @ other.translation + self.translation, turn)
        try:
            points = np.asarray(other, dtype=np.float64)
        except (TypeError, ValueError):
            raise wrong("what a pose moves", "a pose or points (N, 3)", other) from None
        if points.ndim not in (1, 2) or points.shape[-1] != 3:
            raise InvalidArgument(f"points are (3,) or (N, 3), not {points.shape}")
        return points @ self.rotation.T + self.translation

    def angle_to(self, other: Pose) -> float:
        """By how much the rotations differ; radians, [0, pi]."""
        turn = (self.inverse() @ other)._quaternion
        return 2 * math.atan2(math.sqrt(sum(v * v for v in turn[:3])), abs(turn[3]))

    def __eq__(self, other: object) -> bool:
        """Number by number; the two quaternions of one rotation are not told to be equal."""
        return (isinstance(other, Pose) and self._translation == other._translation
                and self._quaternion == other._quaternion)

    def __hash__(self) -> int:
        return hash((self._translation, self._quaternion))

    def __repr__(self) -> str:
        place = ", ".join(f"{value:.6g}" for value in self._translation)
        turn = ", ".join(f"{value:.6g}" for value in self._quaternion)
        return f"Pose(({place}), ({turn}))"


def _quaternion_of(turn: Array) -> Array:
    """Of a rotation matrix; from its largest component, so that nothing is divided by near zero."""
    trace = float(np.trace(turn))
    squares = np.array([*(1 + 2 * np.diag(turn) - trace), 1 + trace])  # 4 x^2, ..., 4 w^2.
    xy, xz, yz = turn[1, 0] + turn[0, 1], turn[2, 0] + turn[0, 2], turn[2, 1] + turn[1, 2]
    wx, wy, wz = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    rows = ((squares[0], xy, xz, wx), (xy, squares[1], yz, wy),
            (xz, yz, squares[2], wz), (wx, wy, wz, squares[3]))
    return np.array(rows[int(np.argmax(squares))])


def matrices(poses: Optional[Array]) -> Array:
    """(N, 4, 4) matrices of (N, 7) rows x y z qx qy qz qw with unit quaternions."""
    rows = np.zeros((0, 7)) if poses is None else np.asarray(poses, dtype=np.float64)
    x, y, z, w = rows[:, 3:].T
    out = np.zeros((len(rows), 4, 4))
    out[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], 1)
    out[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], 1)
    out[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], 1)
    out[:, :3, 3] = rows[:, :3]
    out[:, 3, 3] = 1
    return out
