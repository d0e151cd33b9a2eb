#!/usr/bin/env python3
"""Merges finished maps of simulated furnished places, and compares with the truth.

    /usr/bin/python3 lab/bench/merging/finished_maps.py build/release/bin --kinds flat office \\
        --seeds 20800 20801 --folder maps

Each seed is one world of the kind in its turn, with two robots. A robot's finished map is every
fifth scan, moved by the true poses into a frame of its own, one point per 4 cm, with the poses
beside it; `isthmus merge` is given the two. Points nearer to the sensor than --near are left out,
as SLAM programs do; the carrier's body is beyond that in some worlds and leaves its trail.
Prints a line per pair, and how many were merged. Worlds in --folder are used again. With --mirrors
maps are merged with mirror images instead: what is merged then is wrong.

Needs numpy (python3-numpy).
"""

import argparse
import glob
import json
import os
import subprocess
import sys

import numpy

TYPES = {("F", "4"): "<f4", ("F", "8"): "<f8", ("U", "1"): "u1", ("U", "2"): "<u2",
         ("U", "4"): "<u4"}
HEADER = ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
          "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n")


def read_pcd(path):
    with open(path, "rb") as file:
        head, data = file.read().split(b"DATA binary\n", 1)
    rows = dict(line.split(" ", 1) for line in head.decode().splitlines() if " " in line)
    fields = zip(rows["FIELDS"].split(), rows["TYPE"].split(), rows["SIZE"].split())
    return numpy.frombuffer(data, [(name, TYPES[kind, size]) for name, kind, size in fields])


def turn(q, v):
    """Turns vectors by quaternions x y z w, both one per row."""
    t = 2 * numpy.cross(q[..., :3], v)
    return v + q[..., 3:] * t + numpy.cross(q[..., :3], t)


def times(q, r):
    """Products of quaternions: first r, then q."""
    v = (q[..., 3:] * r[..., :3] + r[..., 3:] * q[..., :3]
         + numpy.cross(q[..., :3], r[..., :3]))
    w = q[..., 3:] * r[..., 3:] - (q[..., :3] * r[..., :3]).sum(-1, keepdims=True)
    return numpy.concatenate([v, w], -1)


def interpolate(poses, stamps):
    """Poses at the stamps: between two of a scan's length, so quaternions may be mixed."""
    stamps = numpy.clip(stamps, poses[0, 0], poses[-1, 0])
    after = numpy.clip(numpy.searchsorted(poses[:, 0], stamps), 1, len(poses) - 1)
    a, b = poses[after - 1], poses[after]
    share = ((stamps - a[:, 0]) / (b[:, 0] - a[:, 0]))[:, None]
    sign = numpy.sign((a[:, 4:] * b[:, 4:]).sum(1, keepdims=True))
    q = (1 - share) * a[:, 4:] + share * sign * b[:, 4:]
    return a[:, 1:4] + share * (b[:, 1:4] - a[:, 1:4]), q / numpy.linalg.norm(q, axis=1)[:, None]


def own_frame(robot):
    """Quaternion and translation of T_map_world."""
    random = numpy.random.default_rng(robot + 1)
    half = random.uniform(-3, 3) / 2
    return (numpy.array([0, 0, numpy.sin(half), numpy.cos(half)]),
            random.uniform(-30, 30, 3) * [1, 1, 0.1])


def finish(world, robot, near, name):
    """Writes NAME.pcd and NAME.tum."""
    poses = numpy.loadtxt(f"{world}/robot_{robot}.truth.tum")
    q_map, p_map = own_frame(robot)
    parts = []
    for i, path in enumerate(sorted(glob.glob(f"{world}/robot_{robot}/*.pcd"))):
        if i % 5:
            continue
        scan = read_pcd(path)
        points = numpy.stack([scan["x"], scan["y"], scan["z"]], 1).astype(float)
        since = scan["time"].astype(float) - scan["time"].max()
        far = numpy.linalg.norm(points, axis=1) > near
        p, q = interpolate(poses, poses[i, 0] + since[far])
        parts.append(turn(q_map, turn(q, points[far]) + p) + p_map)
    points = numpy.concatenate(parts)
    _, first = numpy.unique(numpy.floor(points / 0.04).astype(int), axis=0, return_index=True)
    points = points[first].astype("<f4")
    with open(name + ".pcd", "wb") as file:
        file.write(HEADER.format(len(points)).encode() + points.tobytes())
    moved = [poses[:, :1], turn(q_map, poses[:, 1:4]) + p_map, times(q_map, poses[:, 4:])]
    numpy.savetxt(name + ".tum", numpy.hstack(moved), fmt="%.9f")


def error_m(match, world):
    """The farthest that a pose of b's drive lies from the truth in a's frame."""
    (q_a, p_a), (q_b, p_b) = own_frame(0), own_frame(1)
    way = numpy.loadtxt(f"{world}/robot_1.truth.tum")[:, 1:4]
    T = match["t_a_b"]
    rotation = numpy.array([T["rotation"][axis] for axis in "xyzw"])
    translation = numpy.array([T["translation"][axis] for axis in "xyz"])
    found = turn(rotation, turn(q_b, way) + p_b) + translation
    return numpy.linalg.norm(found - turn(q_a, way) - p_a, axis=1).max()


def mirror(name):
    """Writes NAME-mirror.pcd and NAME-mirror.tum: as the map is seen in a mirror on a wall."""
    with open(name + ".pcd", "rb") as file:
        head, data = file.read().split(b"DATA binary\n", 1)
    points = numpy.frombuffer(data, "<f4").reshape(-1, 3) * numpy.float32([1, -1, 1])
    with open(name + "-mirror.pcd", "wb") as file:
        file.write(head + b"DATA binary\n" + points.tobytes())
    poses = numpy.loadtxt(name + ".tum") * [1, 1, -1, 1, -1, 1, -1, 1]
    numpy.savetxt(name + "-mirror.tum", poses, fmt="%.9f")


def merge(options, a, b):
    """The pair, as the report has it."""
    command = [os.path.join(options.bin, "isthmus"), "merge", a + ".pcd", b + ".pcd", "-o",
               os.path.join(options.folder, "merged.pcd"), "--json"]
    if options.config:
        command += ["--config", options.config]
    done = subprocess.run(command, capture_output=True, text=True)
    if "{" not in done.stdout:
        sys.exit(done.stderr)
    return json.loads(done.stdout[done.stdout.index("{"):])["pairs"][0]


def text(pair):
    return f"{pair['state']} {pair['reason']}, confidence {pair['confidence'] or 0:.3f}"


def make_world(options, kind, seed):
    """The world's folder and its two maps' names."""
    world = os.path.join(options.folder, f"{kind}-{seed}")
    if not os.path.exists(f"{world}/robot_1.truth.tum"):
        subprocess.run([os.path.join(options.bin, "isthmus"), "simulate", "--world",
                        "wild-" + kind, "--robots", "2", "--seconds", options.seconds, "--seed",
                        str(seed), "-o", world], check=True, capture_output=True)
    maps = [f"{world}/{letter}-{options.near}" for letter in "ab"]
    for robot in range(2):
        if not os.path.exists(maps[robot] + "-mirror.tum"):
            finish(world, robot, options.near, maps[robot])
            mirror(maps[robot])
    return world, maps


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", help="folder of isthmus")
    parser.add_argument("--kinds", nargs="+", default=["flat", "office", "storey", "carpark"])
    parser.add_argument("--seeds", nargs="+", type=int, required=True)
    parser.add_argument("--seconds", default="60")
    parser.add_argument("--near", type=float, default=1.0, help="m")
    parser.add_argument("--folder", required=True)
    parser.add_argument("--mirrors", action="store_true",
                        help="merge each map with its own mirror image and with the other's")
    parser.add_argument("--config", help="settings of the server that merges")
    options = parser.parse_args()
    merged = wrong = enough = right = mirrors = mirrors_merged = 0
    for i, seed in enumerate(options.seeds):
        kind = options.kinds[i % len(options.kinds)]
        world, (a, b) = make_world(options, kind, seed)
        if options.mirrors:
            for one, other in (a, a), (b, b), (a, b), (b, a):
                pair = merge(options, one, other + "-mirror")
                mirrors += 1
                mirrors_merged += pair["accepted"]
                print(f"{kind} {seed}: {os.path.basename(one)[0]} and {os.path.basename(other)[0]} mirrored: {text(pair)}",
                      flush=True)
            continue
        pair = merge(options, a, b)
        with open(f"{world}/simulation.json") as file:
            overlap = json.load(file)["overlap"][0][1]
        error = error_m(pair, world)
        merged += pair["accepted"]
        wrong += pair["accepted"] and error > 1
        enough += overlap >= 0.3
        right += pair["accepted"] and overlap >= 0.3 and error <= 1
        print(f"{kind} {seed}: overlap {overlap:.2f}, {text(pair)}, {error:.2f} m off", flush=True)
    if options.mirrors:
        print(f"{mirrors_merged} of {mirrors} mirror images merged")
    else:
        print(f"{merged} of {len(options.seeds)} merged, {wrong} of them WRONG; of overlap 0.3 and "
              f"more {right} of {enough}")


if __name__ == "__main__":
    sys.exit(main())
