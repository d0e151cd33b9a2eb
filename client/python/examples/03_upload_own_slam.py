#!/usr/bin/python3
"""Uploads the map of a robot that has a SLAM of its own, and asks where another robot is in it.

    03_upload_own_slam.py ADDRESS ROBOT TRAJECTORY.tum SCANS_FOLDER [OTHER_ROBOT]

Scans are .pcd files, one for each pose of the trajectory (where the sensor was at the END of it).
Twenty scans at a time become a submap; a robot whose SLAM has submaps would send those.
"""
import sys
from pathlib import Path
from typing import Iterator, List

import numpy as np

import isthmus
from isthmus.io import read_pcd, read_tum

SCANS_PER_SUBMAP = 20
FIELDS = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("keyframe", "u2")]


def submap_of(files: List[Path], stamps: np.ndarray, poses: List[isthmus.Pose]
              ) -> isthmus.OwnSubmap:
    """The submap's frame is the sensor at its first scan."""
    T_submap_odom = poses[0].inverse()
    keyframes = [T_submap_odom @ T_odom_sensor for T_odom_sensor in poses]
    clouds = []
    for k, (file, T_submap_sensor) in enumerate(zip(files, keyframes)):
        points = read_pcd(file).points[::5]  # A fifth of the points is plenty.
        cloud = np.zeros(len(points), dtype=FIELDS)
        xyz = T_submap_sensor @ np.stack([points["x"], points["y"], points["z"]], axis=1)
        cloud["x"], cloud["y"], cloud["z"] = xyz.T
        cloud["keyframe"] = k  # From which of the keyframes it was seen: what lies between is free.
        clouds.append(cloud)
    return isthmus.OwnSubmap(np.concatenate(clouds), poses[0],
                             [(int(stamp), pose) for stamp, pose in zip(stamps, keyframes)],
                             int(stamps[0]), int(stamps[-1]))


def submaps_of(trajectory: str, folder: str) -> Iterator[isthmus.OwnSubmap]:
    stamps, matrices = read_tum(trajectory)
    poses = [isthmus.Pose.from_matrix(matrix) for matrix in matrices]  # T_odom_sensor.
    files = sorted(Path(folder).glob("*.pcd"))
    if len(files) != len(poses):
        raise SystemExit(f"{len(files)} scans, but {len(poses)} poses")
    for first in range(0, len(files), SCANS_PER_SUBMAP):
        part = slice(first, first + SCANS_PER_SUBMAP)
        yield submap_of(files[part], stamps[part], poses[part])


def main(address: str, robot: str, trajectory: str, folder: str, other: str = "") -> None:
    with isthmus.connect(address) as client:
        session = client.upload(robot, submaps_of(trajectory, folder), resolution=0.002)
        print(f"{session.id}: {session.submap_count} submaps, {session.point_count} points")
        client.wait("settled")
        if not other:
            return
        try:
            place = client.transform(robot, other).translation
            print(f"{other} set out from {place[0]:.2f} {place[1]:.2f} {place[2]:.2f}")
        except isthmus.FailedPrecondition as why:
            print(f"where {other} is is not known: {why}")


if __name__ == "__main__":
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    main(*sys.argv[1:])
