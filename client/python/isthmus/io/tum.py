"""Trajectories as text, as of the TUM RGB-D benchmark: stamp tx ty tz qx qy qz qw per line."""
from __future__ import annotations

import os
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, Iterable, List, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isthmus.errors import InvalidArgument
from isthmus.io.whole import PathLike, replace_file
from isthmus.pose import Array, Pose
from isthmus.times import Moment, to_ns


def read_tum(path: PathLike) -> Tuple[NDArray[np.int64], Array]:
    """Stamps (N,) in nanoseconds, kept to the last one, and poses (N, 4, 4)."""
    stamps: List[int] = []
    matrices: List[Array] = []
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            if len(words) != 8:
                raise InvalidArgument("not eight numbers")
            stamps.append(int((Decimal(words[0]) * 10**9).to_integral_value()))
            values = [float(word) for word in words[1:]]
            matrices.append(Pose(values[:3], values[3:]).matrix())
        except (ValueError, OverflowError, InvalidOperation) as error:
            raise InvalidArgument(f"{os.fspath(path)}, line {number}: {error}") from None
    return np.array(stamps, dtype=np.int64), np.array(matrices).reshape(-1, 4, 4)


def write_tum(path: PathLike, stamps_ns: Sequence[Moment] | NDArray[Any],
              poses: Iterable[Union[Pose, ArrayLike]]) -> None:
    """`stamps_ns` (N,) in nanoseconds or as datetimes, `poses` N poses or (N, 4, 4)."""
    lines = []
    all_poses = list(poses)
    if len(stamps_ns) != len(all_poses):
        raise InvalidArgument(f"{len(stamps_ns)} stamps and {len(all_poses)} poses")
    for stamp, given in zip(stamps_ns, all_poses):
        pose = given if isinstance(given, Pose) else Pose.from_matrix(given)
        stamp_ns = to_ns(stamp, "a stamp")
        seconds, rest = divmod(abs(stamp_ns), 10**9)
        sign = "-" if stamp_ns < 0 else ""
        numbers = " ".join(f"{value:.9g}" for value in (*pose.translation, *pose.quaternion))
        lines.append(f"{sign}{seconds}.{rest:09d} {numbers}\n")
    replace_file(path, "".join(lines).encode())
