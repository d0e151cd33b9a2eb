"""What the tests share: a real server on a free port, and simulated drives to push.

The programs are those that ISTHMUS_SERVER_PROGRAM and ISTHMUS_PROGRAM name, else those in PATH.
"""
from __future__ import annotations

import atexit
import functools
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Iterator, List, Optional

import numpy as np

import isthmus
import isthmus.io

SERVER = os.environ.get("ISTHMUS_SERVER_PROGRAM", "isthmus-server")
CLI = os.environ.get("ISTHMUS_PROGRAM", "isthmus")


def temporary_folder() -> Path:
    """Removed at the end of the program."""
    folder = Path(tempfile.mkdtemp(prefix="isthmus-python-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.lru_cache(maxsize=None)
def drives(seconds: int = 6, robots: int = 2) -> Path:
    """A folder with robot_0, robot_1, ...: a VLP-16 in a museum, 10 scans a second."""
    folder = temporary_folder() / "drives"
    subprocess.run([CLI, "simulate", "--world", "museum", "--robots", str(robots), "--seconds",
                    str(seconds), "--seed", "1", "-o", str(folder)], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder


@functools.lru_cache(maxsize=None)
def scans(robot: int = 0, seconds: int = 6, robots: int = 2) -> List[isthmus.Scan]:
    """All scans of a drive."""
    folder = drives(seconds, robots) / f"robot_{robot}"
    stamps = np.loadtxt(folder / "times.txt")
    return [isthmus.Scan.at_seconds(stamp, isthmus.io.read_pcd(file).points)
            for stamp, file in zip(stamps, sorted(folder.glob("*.pcd")))]


class Server:
    """isthmus-server on a folder of its own; a context manager that stops it."""

    def __init__(self, copy_of: Optional[Path] = None, settings: Optional[Path] = None) -> None:
        self.data = temporary_folder() / "map"
        self._settings = [] if settings is None else ["--config", str(settings)]
        if copy_of is not None:
            shutil.copytree(copy_of, self.data)
        self._process: Optional[subprocess.Popen[str]] = None
        self.address = "127.0.0.1:0"
        self.start()

    def start(self) -> None:
        """Returns when it listens; after the first time, at the address that it had."""
        self._process = subprocess.Popen(
            [SERVER, "--data", str(self.data), "--listen", self.address, *self._settings],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if "listening on" not in line:
            raise RuntimeError(f"{SERVER} does not listen: {line!r}")
        self.address = line.split()[-1]

    def kill(self) -> None:
        """As a power cut would."""
        self._end(signal.SIGKILL)

    def stop(self) -> int:
        """As systemd does; returns the exit code."""
        return self._end(signal.SIGTERM)

    def _end(self, how: signal.Signals) -> int:
        process, self._process = self._process, None
        if process is None:
            return 0
        process.send_signal(how)
        code = process.wait(timeout=30)
        assert process.stdout is not None
        process.stdout.close()
        return code

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


def room(points: int = 2000, seed: int = 1) -> Iterator[np.ndarray]:
    """Clouds (N, 3) of a room of 12 x 8 x 3 m, as seen from its middle."""
    random = np.random.default_rng(seed)
    half = np.array([6.0, 4.0, 1.5])
    while True:
        cloud = random.uniform(-1, 1, (points, 3))
        axis = random.integers(0, 3, points)
        cloud[np.arange(points), axis] = np.sign(cloud[np.arange(points), axis])
        yield (cloud * half + random.normal(0, 0.01, cloud.shape)).astype(np.float32)
