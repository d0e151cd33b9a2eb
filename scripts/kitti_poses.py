#!/usr/bin/env python3
"""KITTI pose rows as TUM, and the error of a found transform between two parts of a drive.

Usage: kitti_poses.py to-tum POSES.txt STAMPS.tum        (stamps are taken from a TUM file)
       kitti_poses.py compare POSES.txt GRAPH.json FIRST_A FIRST_B
"""
import json
import math
import sys


def read_poses(path):
    """Rows of 12 as (rotation 3x3, translation)."""
    with open(path, encoding="utf-8") as file:
        rows = [[float(v) for v in line.split()] for line in file if line.strip()]
    return [([r[0:3], r[4:7], r[8:11]], [r[3], r[7], r[11]]) for r in rows]


def quaternion(m):
    """x y z w of a rotation matrix."""
    q = [math.sqrt(max(0.0, 1 + m[0][0] - m[1][1] - m[2][2])) / 2,
         math.sqrt(max(0.0, 1 - m[0][0] + m[1][1] - m[2][2])) / 2,
         math.sqrt(max(0.0, 1 - m[0][0] - m[1][1] + m[2][2])) / 2,
         math.sqrt(max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2]
    q[0] = math.copysign(q[0], m[2][1] - m[1][2])
    q[1] = math.copysign(q[1], m[0][2] - m[2][0])
    q[2] = math.copysign(q[2], m[1][0] - m[0][1])
    return q


def matrix(q):
    x, y, z, w = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def transposed_times(a, b):
    """a^T b of 3x3 matrices."""
    return [[sum(a[k][i] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def to_tum(poses_path, stamps_path):
    with open(stamps_path, encoding="utf-8") as file:
        stamps = [line.split()[0] for line in file if line.strip() and line[0] != "#"]
    for stamp, (rotation, t) in zip(stamps, read_poses(poses_path)):
        print(stamp, *t, *quaternion(rotation))


def compare(poses_path, graph_path, first_a, first_b):
    poses = read_poses(poses_path)
    (r_a, t_a), (r_b, t_b) = poses[first_a], poses[first_b]
    true_r = transposed_times(r_a, r_b)
    true_t = [sum(r_a[k][i] * (t_b[k] - t_a[k]) for k in range(3)) for i in range(3)]
    with open(graph_path, encoding="utf-8") as file:
        match = json.load(file)["matches"][0]
    if (match["robot_a"], match["robot_b"]) != ("a", "b"):
        sys.exit("kitti_poses.py: the graph is not of robots a and b")
    rotation, translation = match["t_a_b"]["rotation"], match["t_a_b"]["translation"]
    found_r = matrix([rotation[axis] for axis in "xyzw"])
    found_t = [translation[axis] for axis in "xyz"]
    off = transposed_times(true_r, found_r)
    angle = math.acos(max(-1.0, min(1.0, (off[0][0] + off[1][1] + off[2][2] - 1) / 2)))
    print(f"error of the merge: {math.dist(true_t, found_t):.3f} m, {math.degrees(angle):.2f} deg "
          "(start frames, against the reference)")


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "to-tum":
        to_tum(sys.argv[2], sys.argv[3])
    elif len(sys.argv) == 6 and sys.argv[1] == "compare":
        compare(sys.argv[2], sys.argv[3], int(sys.argv[4]), int(sys.argv[5]))
    else:
        sys.exit(__doc__)
