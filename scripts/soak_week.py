"""The days of a soak; scripts/soak builds what it needs and runs it."""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import soak_table
from soak_robots import Reader, Robot
from soak_server import SITES, Disk, Server

NAMES = ("alice", "bob", "carol", "dora", "emil", "frida")
NOTICED_S = 60  # Within which the server must say that its disk is full, and that it no longer is.


class Week:
    """`days` days at one server."""

    def __init__(self, options, out, disk):
        self._day_s, self._days = options.day, options.days
        self.broken = []
        self._rows, self._full, self._disk = [], [], disk
        if not disk.is_own:
            print("the map has no disk of its own, which takes root: none is filled", flush=True)
        drive_s = max(3, min(40, options.day * 0.25))
        subprocess.run([options.bin / "isthmus", "simulate", "--world", "museum", "--robots",
                        str(options.robots), "--seconds", str(drive_s), "--seed", "1", "-o",
                        out / "drives"], check=True, capture_output=True)
        self.server = Server(options.bin, out, disk, options.day)
        # The last one is alone at the second site.
        self._robots = [self._robot(number, SITES[number == options.robots - 1], options, out)
                        for number in range(options.robots)]
        reader = out / "reader.token"
        reader.write_text(self.server.make_token("reader", "--role", "reader"))
        self._reader = Reader(self.server, reader, max(0.5, options.day / 120))
        self._sampler = soak_table.Sampler(self.server, options.day / 60)
        self._token = ""  # Of bob.
        self._killed = self._refused = self._answers = 0

    def _robot(self, number, site, options, out):
        drive = out / "drives" / f"robot_{number}"
        scans = len((drive / "times.txt").read_text().split())
        return Robot(self.server, options.bin, NAMES[number], site, drive, scans,
                     pause_s=self._day_s * 0.05, patience_s=self._day_s * 0.7 + NOTICED_S,
                     seed=number)

    def _break(self, what):
        print(f"BROKEN: {what}", flush=True)
        self.broken.append(what)

    @staticmethod
    def _wait(holds, limit_s):
        """The seconds it took, or None."""
        begin = time.monotonic()
        while not holds():
            if time.monotonic() - begin > limit_s:
                return None
            time.sleep(0.2)
        return time.monotonic() - begin

    def _problem(self):
        return next((problem for site in SITES if (problem := self.server.problem(site))), "")

    def _renew(self, _):
        self.server.renew_certificates()

    def _let_expire(self, _):
        """One that is not renewed in time: no new connection, until somebody does."""
        self._reader.shut = True
        valid_s = max(0.02 * self._day_s, 3)
        self.server.renew_certificates(valid_s)
        time.sleep(valid_s + 2)
        if self.server.run("status").returncode == 0:
            self._break("a certificate that has expired is taken")
        self._robots[0].kill()

    def _renew_at_last(self, day):
        self._renew(day)
        if self._wait(lambda: self.server.run("status").returncode == 0, NOTICED_S) is None:
            self._break("no connection with the new certificate")
        self._reader.shut = False

    def _fill_disk(self, day):
        if not self._disk.is_own:
            return
        before = {site: self.server.sessions(site, 10) for site in SITES}

        def full():
            self._disk.fill()
            return self._problem()
        said_s = self._wait(full, NOTICED_S)
        if said_s is None:
            self._break(f"day {day}: the server does not say that its disk is full")
        held_until = time.monotonic() + self._day_s * 0.02
        while time.monotonic() < held_until:
            self._disk.fill()
            time.sleep(0.2)
        self._disk.free()
        again_s = self._wait(lambda: not self._problem(), NOTICED_S)
        if again_s is None:
            self._break(f"day {day}: it has space, and still {self._problem()}")
        self._full = [said_s or 0.0, again_s or 0.0]
        for site in SITES:
            after = self.server.sessions(site, 10)
            for name, was in before[site].items():
                if name in after and after[name]["durable_sequence"] < was["durable_sequence"]:
                    self._break(f"{name}: what was durable no longer is, after a full disk")

    def _new_day(self, day):
        self._robots[0].take_token(f"alice-{day}", "--expires", f"{round(self._day_s * 0.4)}s")

    def _after_refusal(self, robot, name):
        """It gets a new token once the old one was refused: by then its program has ended."""
        refused = robot.refusals.total()
        if self._wait(lambda: robot.refusals.total() > refused, NOTICED_S) is None:
            self._break(f"{robot.name} is served with a token that no longer holds")
        robot.take_token(name)

    def _revoke(self, day):
        bob = self._robots[1]
        if self.server.run("token", "revoke", self._token).returncode != 0:
            self._break(f"token {self._token} cannot be revoked")
        self._token = f"bob-{day}"
        self._after_refusal(bob, self._token)

    def _back_up(self, day):
        for site in SITES:
            folder = self.server.out / f"backup-{site}"
            done = self.server.run("backup", folder, site=site)
            if done.returncode != 0:
                self._break(f"day {day}: no backup: {done.stderr}")
            elif found := self.server.check(folder):
                self._break(f"day {day}: the backup of {site} is not sound: {found}")
            shutil.rmtree(folder, ignore_errors=True)

    def _events(self, day):
        lapses = day == self._days // 2 + 1 and self._days > 1
        return [(0, self._new_day), (0.05, self.server.rotate_log), (0.1, self._renew),
                (0.15, self._fill_disk),
                (0.41, lambda day: self._after_refusal(self._robots[0], f"alice-{day}-new")),
                (0.5, self._revoke), (0.6, self._back_up),
                *([(0.7, self._let_expire), (0.92, self._renew_at_last)] if lapses else [])]

    def _close_day(self, day):
        if self.server.process.poll() is not None:
            raise SystemExit(f"the server ended with {self.server.process.returncode}")
        done = [drive for robot in self._robots for drive in robot.take_done()]
        kept = sum(len(self.server.sessions(site, 10)) for site in SITES)
        total = {name: sum(drive[name] for drive in done)
                 for name in ("sent", "processed", "skipped", "rejected")}
        lost = total["sent"] - sum(total[name] for name in ("processed", "skipped", "rejected"))
        if lost != 0:
            self._break(f"day {day}: {lost} scans without an answer")
        killed = sum(robot.killed for robot in self._robots)
        refused = sum(robot.refusals.total() for robot in self._robots)
        row = {"day": day, "drives": len(done), **total, "lost": lost,
               "killed": killed - self._killed, "refused": refused - self._refused,
               "full: said, over after, s": "{:.1f}, {:.1f}".format(*self._full or (0, 0)),
               "sessions kept": kept, "answers to readers": self._reader.answers - self._answers,
               **self._sampler.take_day()}
        self._killed, self._refused, self._answers = killed, refused, self._reader.answers
        self._rows.append(row)
        print(soak_table.markdown([row]), flush=True)

    def run(self):
        self._token = "bob-0"
        for robot in self._robots:
            robot.take_token(f"{robot.name}-0")
        for thread in (*self._robots, self._reader, self._sampler):
            thread.start()
        begin = time.monotonic()
        for day in range(1, self._days + 1):
            for at, event in self._events(day):
                time.sleep(max(0, begin + (day - 1 + at) * self._day_s - time.monotonic()))
                event(day)
            time.sleep(max(0, begin + day * self._day_s - time.monotonic()))
            if day < self._days:
                self._close_day(day)
        self._end()

    def _end(self):
        self._reader.finish()
        for robot in self._robots:
            robot.finish()
        for robot in self._robots:
            robot.join()
        self._close_day(self._days)
        self._sampler.finish()
        drives = sum(row["drives"] for row in self._rows)
        if self._days > 1 and self._rows[-1]["sessions kept"] >= drives:
            self._break("no session was deleted for its age")
        for of in (*self._robots, self._reader):
            for what in of.broken:
                self._break(what)
        for what in soak_table.growth(self._rows):
            self._break(what)
        for number in range(1, self._days + 1):
            if "\0" in pathlib.Path(f"{self.server.log}.{number}").read_text(errors="replace"):
                self._break(f"log {number} has holes")
        if (code := self.server.stop()) != 0:
            self._break(f"the server ended with {code}")
        for folder in (self.server.data, self.server.data / "sites" / SITES[1]):
            if found := self.server.check(folder):
                self._break(f"{folder} is not sound: {found}")
        self._report()

    def _report(self):
        print("\n" + soak_table.markdown(self._rows))
        for robot in self._robots:
            for said, times in robot.refusals.most_common():
                print(f"{robot.name}, started again {times} times: {said}")
        print(f"readers without an answer while the certificate was expired: "
              f"{self._reader.no_answers}")
        if self._days < 3:
            print("nothing is said of growth: that takes a third day")

    def kill(self):
        """What still runs, after an error."""
        for robot in self._robots:
            robot.finish(now=True)
        if self.server.process.poll() is None:
            self.server.process.kill()
            self.server.process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--day", type=float, default=240, help="seconds of a day")
    parser.add_argument("--days", type=int, default=7)
    parser.add_argument("--robots", type=int, default=3, choices=range(2, len(NAMES) + 1))
    parser.add_argument("--disk-mb", type=int, default=512)
    parser.add_argument("--out", type=pathlib.Path, help="folder for logs, which is kept")
    options = parser.parse_args()
    out = options.out or pathlib.Path(tempfile.mkdtemp(prefix="isthmus-soak-"))
    out.mkdir(parents=True, exist_ok=True)
    out = out.resolve()
    disk, week = Disk(out / "disk", options.disk_mb), None
    try:
        week = Week(options, out, disk)
        week.run()
    finally:
        if week is not None:
            week.kill()
        disk.release()
    if week.broken:
        print(f"{len(week.broken)} things did not hold; the logs are in {out}")
        return 1
    print("all held, with nothing done by hand")
    if options.out is None:
        shutil.rmtree(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
