"""KITTI's LiDAR scans: files of float32 x y z reflectance, one point after the other."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Union

import numpy as np
from numpy.typing import NDArray

from isthmus.errors import InvalidArgument


def read_kitti_bin(path: Union[str, "os.PathLike[str]"]) -> NDArray[np.void]:
    """Structured array (N,) of x, y, z (metres, sensor frame) and intensity."""
    data = Path(path).read_bytes()
    if len(data) % 16 != 0:
        raise InvalidArgument(f"{os.fspath(path)} is no scan of KITTI: its {len(data)} bytes are "
                              "no whole number of points of 16 bytes")
    return np.frombuffer(data, dtype=[(name, "<f4") for name in ("x", "y", "z", "intensity")])
