#!/usr/bin/python3
"""Pushes a folder of scans as one robot, and says what became of them.

    01_push_folder.py ADDRESS ROBOT SENSOR FOLDER

The folder holds .pcd files, or KITTI's .bin files. Stamps come from times.txt in it (seconds, the
END of each scan); without one the scans are taken to be a tenth of a second apart.
"""
import sys
from pathlib import Path
from typing import Iterator, List

import isthmus
from isthmus.io import read_kitti_bin, read_pcd


def stamps_of(folder: Path, count: int) -> List[float]:
    times = folder / "times.txt"
    if times.exists():
        return [float(line) for line in times.read_text().split()]
    return [0.1 * (k + 1) for k in range(count)]


def scans_of(folder: Path) -> Iterator[isthmus.Scan]:
    """One after the other, so that the folder may be larger than memory."""
    files = sorted([*folder.glob("*.pcd"), *folder.glob("*.bin")])
    for stamp_s, file in zip(stamps_of(folder, len(files)), files):
        points = read_pcd(file).points if file.suffix == ".pcd" else read_kitti_bin(file)
        yield isthmus.Scan.at_seconds(stamp_s, points)


def show(ack: isthmus.Ack) -> None:
    """Called for every scan; T_odom_sensor is where the sensor was at its END."""
    if ack.sequence % 50 == 0 and ack.T_odom_sensor is not None:
        x, y, z = ack.T_odom_sensor.translation
        print(f"scan {ack.sequence}: at {x:.2f} {y:.2f} {z:.2f}, {ack.tracking}")


def main(address: str, robot: str, sensor: str, folder: str) -> None:
    with isthmus.connect(address) as client:
        # Waits for the server where it goes away meanwhile; rounds to 2 mm, a quarter of the bytes.
        summary = client.push(robot, scans_of(Path(folder)), sensor=sensor, on_ack=show)
    for rejection in summary.rejected:
        print(f"scan {rejection.sequence} was rejected: {rejection.reason}")
    print(f"{summary.session.id}: {summary.processed} scans processed, {len(summary.rejected)} "
          f"rejected, {summary.session.travelled_m:.1f} m, {summary.stats.sent_bytes / 1e6:.1f} MB")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
