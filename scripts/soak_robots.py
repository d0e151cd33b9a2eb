"""Robots and readers of a soak: programs that are started again whenever they end."""
import collections
import random
import re
import shutil
import subprocess
import threading
import time


class Robot(threading.Thread):
    """Drives again and again: each drive a session with a spool of its own, pushed by `isthmus
    push`. Whatever ends that program, killed or refused, the same command goes on, as a supervisor
    on the robot would have it; until the server has every scan."""

    def __init__(self, server, programs, name, site, drive, scans, pause_s, patience_s, seed):
        super().__init__(name=name)
        self.server, self.site, self.drive_folder, self.scans = server, site, drive, scans
        self._program, self._pause_s, self._patience_s = programs / "isthmus", pause_s, patience_s
        self._random = random.Random(seed)
        self._lock = threading.Lock()
        self._process = None
        self._is_over = threading.Event()
        self.token = server.out / f"{name}.token"
        self._drives = 0
        self.killed, self.refusals = 0, collections.Counter()
        self._done, self.broken = [], []

    def take_token(self, name, *args):
        """A new one, which the next start of the program reads."""
        self.token.write_text(self.server.make_token(
            name, "--role", "robot", "--robot", self.name, "--site", self.site, *args))

    def kill(self):
        with self._lock:
            if self._process and self._process.poll() is None:
                self._process.kill()
                self.killed += 1

    def take_done(self):
        """The drives that ended since the last call."""
        with self._lock:
            done, self._done = self._done, []
            return done

    def finish(self, now=False):
        """After the drive it is on, or at once."""
        self._is_over.set()
        if now:
            self._patience_s = 0
            self.kill()

    def run(self):
        try:
            while not self._is_over.is_set() and not self.broken:
                self._drive()
                self._is_over.wait(self._random.uniform(0, self._pause_s))
        except Exception as error:  # pylint: disable=broad-except
            self.broken.append(f"{self.name}: {error!r}")

    def _drive(self):
        self._drives += 1
        spool = self.server.out / "spools" / f"{self.name}-{self._drives}"
        begin = time.monotonic()
        while (code := self._push(spool)) != 0:
            if time.monotonic() - begin > self._patience_s:
                self.broken.append(f"{self.name}: drive {self._drives} does not end, exit {code}")
                return
            time.sleep(0.5)
        self._account()
        shutil.rmtree(spool, ignore_errors=True)

    def _push(self, spool):
        command = [self._program, "push", "--robot", self.name, "--rate", "10", "--spool", spool,
                   self.drive_folder]
        dies_s = self._random.uniform(0, self.scans / 10) if self._random.random() < 0.25 else None
        with self._lock:
            self._process = subprocess.Popen(
                command, env=self.server.environment(self.token, self.site), text=True,
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        try:
            _, said = self._process.communicate(timeout=dies_s)
        except subprocess.TimeoutExpired:
            self.kill()
            _, said = self._process.communicate()
        code = self._process.returncode
        if code > 0:
            lines = [line for line in said.splitlines() if line.startswith("isthmus:")]
            self.refusals[re.sub(r"\d+", "N", (lines or ["?"])[-1])[:160]] += 1
        return code

    def _account(self):
        """What the server says of the session that has just ended: the newest of the robot."""
        sessions = [one for one in self.server.sessions(self.site, self._patience_s).values()
                    if one["robot"] == self.name]
        if not sessions:
            self.broken.append(f"{self.name}: no session after drive {self._drives}")
            return
        last = max(sessions, key=lambda one: int(one["id"].rsplit("-", 1)[1]))
        counts = last["scan_counts"]
        processed = counts["ok"] + counts["degenerate"] + counts["lost"]
        with self._lock:
            self._done.append({"sent": self.scans, "processed": processed,
                               "skipped": counts["skipped"], "rejected": counts["rejected"]})
        if last["durable_sequence"] != self.scans or last["state"] != "FINISHED":
            self.broken.append(f"{last['id']}: {last['state']}, durable up to "
                               f"{last['durable_sequence']} of {self.scans}")


class Reader(threading.Thread):
    """Asks for the state, the sessions, a trajectory and the points, in turn."""

    def __init__(self, server, token, period_s):
        super().__init__(name="reader", daemon=True)
        self._server, self._token, self._period_s = server, token, period_s
        self._is_over = threading.Event()
        self.shut = False  # The server's certificate has expired: no answers are expected.
        self.answers, self.no_answers, self.broken = 0, 0, []

    def finish(self):
        self._is_over.set()

    def run(self):
        points = str(self._server.out / "points.pcd")
        asked = [["status"], ["robots"], ["trajectory", "alice", "-o", "/dev/null"],
                 ["query", "--robot", "alice", "-o", points]]
        turn = 0
        while not self._is_over.wait(self._period_s):
            may_fail = self.shut
            done = self._server.run(*asked[turn % len(asked)], token=self._token)
            # 3 and 6: nothing there yet, or no more.
            if done.returncode in (0, 3, 6):
                self.answers += 1
            elif may_fail or self.shut:
                self.no_answers += 1
            else:
                self.broken.append(f"reader: {asked[turn % len(asked)]}: {done.stderr.strip()}")
            turn += 1
