#!/usr/bin/env python3
"""Runs the odometry benchmark on seconds of a museum and of a wild drive, checks what it writes.

Usage: check_odometry_benchmark.py PROGRAM OUTPUT.json
"""
import json
import subprocess
import sys

program, output = sys.argv[1:]
table = subprocess.run(
    [program, "--scenario", "museum", "--seeds", "7", "--seconds", "3", "-o", output],
    check=True, capture_output=True, text=True).stdout
with open(output, encoding="utf-8") as file:
    result = json.load(file)

assert result["cores"] >= 1 and result["compiler"]
(run,) = result["runs"]
assert (run["scenario"], run["mode"], run["sensor"], run["seed"]) == (
    "museum", "continuous", "vlp16", 7)
assert run["scans"] == 30 == sum(
    run["counts"][outcome] for outcome in ("ok", "degenerate", "lost", "rejected"))
assert run["counts"]["silent"] == run["counts"]["covered_ok"] == 0
assert run["cal_ms"] > 0
for unit in ("ms", "cal"):
    cost = run["cost"][unit]
    assert 0 < cost["median"] <= cost["p99"] <= cost["max"], cost
assert set(run["cost"]["stages_ms"]) == {"features", "matching", "map"}
assert run["cost"]["scans_200_300_ms"] is None  # There are no such scans.
assert 0 < run["memory_mb"]["odometry"] < run["memory_mb"]["peak"]
assert 0 < run["error"]["rigid"]["rmse_m"] < 0.05
for key in ("final_m", "heading_worst_deg", "tilt_worst_deg"):
    assert run["error"]["first_pose"][key] >= 0
assert run["corridor"] is None and run["laps"] == [] and run["scans_to_recover"] is None

rows = [line.count("|") for line in table.splitlines()]
assert len(rows) == 3 and len(set(rows)) == 1, table

subprocess.run(
    [program, "--wild", "1", "--seed", "4", "--kind", "house", "--sensor", "vlp16", "--seconds", "1",
     "-o", output], check=True, capture_output=True)
with open(output, encoding="utf-8") as file:
    result = json.load(file)
(drive,) = result["wild"]
assert result["runs"] == []
assert (drive["kind"], drive["seed"], drive["sensor"]) == ("house", 4, "vlp16")
assert drive["scans"] == 10 == sum(
    drive[outcome] for outcome in ("ok", "degenerate", "lost", "rejected"))
assert drive["path_length_m"] >= 0 and drive["cal_ms"] > 0

unknown = subprocess.run([program, "--scenario", "muse", "atlantis"], capture_output=True, text=True)
assert unknown.returncode == 1 and "museum, campus" in unknown.stderr, unknown.stderr
