#!/usr/bin/env python3
"""What robots cost a server whose map is in PostgreSQL, and that PostgreSQL: computing time by
thread, stages, submaps, commits, write-ahead log, bytes.

    lab/bench/scale/measure_load.py --programs build/release/bin --robots 4 --seconds 300 [-o run.json]

Starts a PostgreSQL of its own (Debian's postgresql-15, its settings left as they are, fsync on), a
server on it, and isthmus-loadgen, to which all further arguments go; then waits until nothing is
left to match, place or compose, so that all that the robots caused is counted. Computing times are
those of the processes' own: they hold where the machine does other work as well. Linux only.
"""
import argparse
import json
import os
import pathlib
import pwd
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

POSTGRES = "/usr/lib/postgresql/15/bin/"
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# Metrics of work that waits. The server is idle when all have been 0 for IDLE_AFTER_S.
WAITING = ("matching_waiting_submaps", "matching_waiting_pairs", "placement_waiting",
           "composition_waiting", "queue_scans")
IDLE_AFTER_S, GIVE_UP_S = 2, 900


def cpu_of(path, children=False):
    """Seconds of a /proc/.../stat, with those of children that ended."""
    fields = path.read_text().rsplit(")", 1)[1].split()
    return sum(map(int, fields[11:15 if children else 13])) / TICKS_PER_S


def cpu_by_thread(pid):
    """Seconds by the threads' names, numbers at their ends left out; threads that ended are missing."""
    seconds = {}
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        try:
            name = re.sub(r"[\d:/_-]+$", "", (task / "comm").read_text().strip())
            seconds[name] = seconds.get(name, 0) + cpu_of(task / "stat")
        except OSError:
            pass  # It ended meanwhile.
    return seconds


def cpu_of_children(pid):
    """Seconds of each process that it started and that still lives."""
    seconds = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            if int(stat.read_text().rsplit(")", 1)[1].split()[1]) == pid:
                seconds.append(cpu_of(stat))
        except OSError:
            pass  # It ended meanwhile.
    return seconds


def memory_mb(pid, what):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(rf"{what}:\s+(\d+) kB", status)[1]) / 1024


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Postgres:
    """In a folder of its own, which it leaves to its caller; as `nobody` where we are root."""

    def __init__(self, folder):
        self.folder = folder
        self.user = "nobody" if os.geteuid() == 0 else None
        if self.user:
            os.chown(folder, pwd.getpwnam(self.user).pw_uid, -1)
        subprocess.run([POSTGRES + "initdb", "-D", f"{folder}/db", "-U", "isthmus", "-A", "trust", "-E",
                        "UTF8", "--locale=C"], check=True, user=self.user, stdout=subprocess.DEVNULL)
        self.process = subprocess.Popen(
            [POSTGRES + "postgres", "-D", f"{folder}/db", "-k", folder, "-c", "listen_addresses="],
            user=self.user, stderr=open(f"{folder}/postgres.log", "w"))
        self.url = f"postgresql:///postgres?user=isthmus&host={folder}"
        for _ in range(300):
            if subprocess.run([POSTGRES + "pg_isready", "-q", "-d", self.url]).returncode == 0:
                return
            time.sleep(0.1)
        sys.exit("PostgreSQL does not start: " + open(f"{folder}/postgres.log").read())

    def ask(self, sql):
        return subprocess.run([POSTGRES + "psql", "-XAtqc", sql, self.url], check=True, text=True,
                              capture_output=True).stdout.strip()

    def figures(self):
        wal, images, syncs = self.ask(
            "SELECT wal_bytes, wal_fpi, wal_sync FROM pg_stat_wal").split("|")
        children = cpu_of_children(self.process.pid)
        return {"commits": int(self.ask("SELECT sum(xact_commit) FROM pg_stat_database")),
                "wal_bytes": int(wal), "wal_page_images": int(images), "wal_syncs": int(syncs),
                "database_bytes": int(self.ask("SELECT pg_database_size('postgres')")),
                "cpu_s": cpu_of(pathlib.Path(f"/proc/{self.process.pid}/stat"), children=True)
                + sum(children), "busiest_cpu_s": max(children)}


class Server:
    def __init__(self, programs, folder, url, settings):
        port = free_port()
        self.metrics = f"http://127.0.0.1:{port}/metrics"
        config = pathlib.Path(folder, "server.yaml")
        config.write_text(f'metrics: {{listen: "127.0.0.1:{port}"}}\n{settings}\n')
        self.out = pathlib.Path(folder, "server.out")
        self.process = subprocess.Popen(
            [f"{programs}/isthmus-server", "--data", f"{folder}/data", "--listen", "127.0.0.1:0",
             "--store", url, "--config", config],
            stdout=self.out.open("w"), stderr=open(f"{folder}/server.log", "w"))
        for _ in range(300):
            found = re.search(r"listening on (\S+)", self.out.read_text())
            if found:
                self.address = found[1]
                return
            time.sleep(0.1)
        sys.exit("the server does not start: " + open(f"{folder}/server.log").read())

    def values(self):
        """Name with labels -> value; without the prefix."""
        with urllib.request.urlopen(self.metrics, timeout=20) as page:
            lines = page.read().decode().splitlines()
        return {line.rsplit(" ", 1)[0].removeprefix("isthmus_"): float(line.rsplit(" ", 1)[1])
                for line in lines if line and not line.startswith("#")}

    def wait_until_idle(self):
        idle_since, until = None, time.monotonic() + GIVE_UP_S
        while time.monotonic() < until:
            values = self.values()
            if any(value for name, value in values.items() if name.split("{")[0] in WAITING):
                idle_since = None
            elif idle_since is None:
                idle_since = time.monotonic()
            elif time.monotonic() - idle_since >= IDLE_AFTER_S:
                return True
            time.sleep(0.5)
        return False

    def figures(self):
        values, stages = self.values(), {}
        for name, value in values.items():
            found = re.match(r'stage_duration_seconds_(count|sum)\{.*stage="(\w+)"', name)
            if found:
                stage = stages.setdefault(found[2], {"count": 0, "sum": 0})
                stage[found[1]] += value
        submaps = sum(v for n, v in values.items() if n.split("{")[0] == "map_submaps")
        retired = sum(v for n, v in values.items() if n.split("{")[0] == "retired_submaps_total")
        revision = sum(v for n, v in values.items() if n.split("{")[0] == "map_revision")
        matches = {re.search(r'state="(\w+)"', n)[1]: v for n, v in values.items()
                   if n.startswith("matches{") and v}
        return {"threads_s": cpu_by_thread(self.process.pid),
                "cpu_s": cpu_of(pathlib.Path(f"/proc/{self.process.pid}/stat")),
                "resident_mb": memory_mb(self.process.pid, "VmRSS"),
                "peak_mb": memory_mb(self.process.pid, "VmHWM"), "stages": stages,
                "submaps": submaps, "retired": retired, "revision": revision, "matches": matches}


def summary(raw):
    """What scale_plan.py reads of a run: sums over the whole of it."""
    option = dict(zip(raw["load"], raw["load"][1:]))
    before, after, report = raw["before"], raw["after"], raw["report"]
    threads = {name: seconds - before["threads_s"].get(name, 0)
               for name, seconds in after["threads_s"].items()}
    database = {name: value - raw["postgres_before"][name]
                for name, value in raw["postgres_after"].items()}
    stages, cpu_s = after["stages"], after["cpu_s"] - before["cpu_s"]
    loops, pairs = stages["loop_search"]["sum"], stages["match"]["sum"]
    own = {name: threads.get(name, 0) for name in ("ingest", "storing", "matching", "composition",
                                                   "placement")}
    measured = {
        "CPU s of the server": cpu_s, **{f"of these {name}": value for name, value in own.items()},
        "of these streams": cpu_s - sum(own.values()),
        "share of pairs in matching": pairs / (loops + pairs) if loops + pairs else 0,
        "attempts at pairs": stages["match"]["count"],
        "submaps": after["submaps"] + after["retired"],
        "CPU s of PostgreSQL": database["cpu_s"],
        "CPU s of its busiest connection": database["busiest_cpu_s"], "commits": database["commits"],
        "synced": database["wal_syncs"], "WAL MB": database["wal_bytes"] / 1e6,
        "database MB": database["database_bytes"] / 1e6, "memory MB": after["peak_mb"] * 1.048576,
        "ms until acknowledged, median": report["acknowledgement_ms"]["p50"],
        "ms until acknowledged, worst": report["acknowledgement_ms"]["max"],
    }
    return {"command": "lab/bench/scale/measure_load.py " + " ".join(raw["load"]),
            "robots": report["robots"], "seconds": float(option.get("--seconds", report["seconds"])),
            "world": option.get("--world", "museum"), "scans": report["processed"],
            "became idle": raw["became_idle"], "cores": cpu_s / report["seconds"],
            "matches": after["matches"],
            "measured": {name: round(value, 3) for name, value in measured.items()}}


def end(process, signal_s=60):
    process.terminate()
    try:
        process.wait(signal_s)
    except subprocess.TimeoutExpired:
        process.kill()


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", default="build/release/bin", help="folder of the programs")
    parser.add_argument("--settings", default="", help="YAML of further settings of the server")
    parser.add_argument("-o", "--output", help="file for the JSON, in place of stdout")
    arguments, load = parser.parse_known_args()
    folder = tempfile.mkdtemp(prefix="isthmus-scale-")
    postgres = server = None
    try:
        postgres = Postgres(folder)
        server = Server(arguments.programs, folder, postgres.url, arguments.settings)
        postgres_before, before = postgres.figures(), server.figures()
        report = subprocess.run(
            [f"{arguments.programs}/isthmus-loadgen", "--server", server.address, "--server-pid",
             str(server.process.pid), "--json", *load], check=True, text=True, stdout=subprocess.PIPE)
        idle = server.wait_until_idle()
        result = {"load": load, "became_idle": idle, "before": before, "after": server.figures(),
                  "postgres_before": postgres_before, "postgres_after": postgres.figures(),
                  "report": json.loads(report.stdout)}
        text = json.dumps(summary(result), indent=1)
        if arguments.output:
            pathlib.Path(arguments.output).write_text(text)
        else:
            print(text)
    finally:
        for started in (server, postgres):
            if started:
                end(started.process)
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
