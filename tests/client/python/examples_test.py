"""The examples, as a user runs them."""
import os
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np

import isthmus.io
from servers import Server, drives, temporary_folder

EXAMPLES = Path(__file__).resolve().parents[3] / "client" / "python" / "examples"


def run(example: str, *arguments: object) -> str:
    """What it prints."""
    done = subprocess.run([sys.executable, str(EXAMPLES / example), *map(str, arguments)],
                          capture_output=True, text=True, check=False,
                          env={**os.environ, "MPLCONFIGDIR": str(temporary_folder())})
    if done.returncode != 0:
        raise AssertionError(f"{example} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def drive(robot: int, count: int) -> Path:
    """The first scans of a robot, and where it was, as another SLAM would tell."""
    folder = temporary_folder()
    (folder / "scans").mkdir()
    for k in range(count):
        name = f"{k:06}.pcd"
        (folder / "scans" / name).symlink_to(drives() / f"robot_{robot}" / name)
    lines = [line for line in (drives() / f"robot_{robot}.truth.tum").read_text().splitlines()
             if not line.startswith("#")]
    (folder / "poses.tum").write_text("\n".join(lines[:count]))
    return folder


class ExamplesTest(unittest.TestCase):
    def test_push_upload_and_plot(self) -> None:
        alice, bob = drive(0, 25), drive(1, 25)
        with Server() as server:
            said = run("01_push_folder.py", server.address, "alice", "vlp16",
                       alice / "scans")
            self.assertIn("alice-1: 25 scans processed, 0 rejected", said)
            said = run("03_upload_own_slam.py", server.address, "bob",
                       bob / "poses.tum", bob / "scans", "alice")
            self.assertIn("bob-1: 2 submaps", said)
            self.assertIn("alice", said.splitlines()[1])  # Its place, or that it is not known.
            picture = temporary_folder() / "map.png"
            said = run("02_query_and_plot.py", server.address, picture)
            self.assertIn("map.png", said)
            self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    def test_a_folder_of_kitti_scans(self) -> None:
        folder = temporary_folder()
        for k in range(3):
            points = isthmus.io.read_pcd(drives() / "robot_0" / f"{k:06}.pcd").points
            columns = [points[name] for name in ("x", "y", "z", "intensity")]
            np.stack(columns, axis=1).astype("<f4").tofile(folder / f"{k:06}.bin")
        with Server() as server:
            self.assertIn("3 scans processed",
                          run("01_push_folder.py", server.address, "k", "vlp16", folder))

    def test_say_how_they_are_used(self) -> None:
        for example in EXAMPLES.glob("0*.py"):
            done = subprocess.run([sys.executable, str(example)], capture_output=True, text=True,
                                  check=False)
            self.assertIn(example.name, done.stderr)
            self.assertEqual(done.returncode, 1)


if __name__ == "__main__":
    unittest.main()
