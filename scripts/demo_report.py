#!/usr/bin/env python3
"""Writes the demo's report as Markdown: this run beside Tables 3-5 of the paper.

Usage: demo_report.py DIR   (the folder scripts/demo wrote its JSON files to)
"""
import json
import pathlib
import sys


def load(path):
    return json.loads(path.read_text(encoding="utf-8"))


def main():
    folder = pathlib.Path(sys.argv[1])
    simulation = load(folder / "simulation" / "simulation.json")
    status = load(folder / "status.json")
    robots = load(folder / "robots.json")
    matches = load(folder / "graph.json")["matches"]
    merged = load(folder / "merged.eval.json")
    count = simulation["robots"]
    alone = [load(folder / f"robot_{i}.eval.json")["robots"][0] for i in range(count)]
    sessions = {s["robot"]: s for s in (robots["sessions"] if isinstance(robots, dict) else robots)}

    print(f"# {count} robots in the {simulation['world']}, seed {simulation['seed']}\n")
    print(f"{simulation['scans_per_robot']} scans of a simulated {simulation['sensor']} each; "
          "start poses unknown to the server.\n")
    print("## Trajectories (RMSE of the position after rigid alignment, eq. 3)\n")
    print("| robot | way | own odometry | in the merged map |")
    print("|---|---|---|---|")
    for i in range(count):
        session = sessions[f"robot_{i}"]
        print(f"| robot_{i} | {session['travelled_m']:.1f} m | {alone[i]['rmse_m']:.4f} m "
              f"| {merged['robots'][i]['rmse_m']:.4f} m |")
    print(f"| all in one frame | | | {merged['merged']['rmse_m']:.4f} m |\n")
    print("The paper's simulated museum: 0.96 m and 0.71 m.\n")
    print("## Computing time\n")
    print("| | this run | the paper |")
    print("|---|---|---|")
    for i in range(count):
        print(f"| odometry of robot_{i}, per scan | {sessions[f'robot_{i}']['odometry_ms_mean']:.1f} ms "
              "| |")
    print(f"| composition of the global map, the longest of {status['compositions']} "
          f"| {status['composition_max_ms']:.0f} ms | 296 ms |")
    print(f"| estimation of the transforms, last round | {status['estimation_ms'] / 1000:.1f} s "
          "| |\n")
    print("## Matches\n")
    print("| robots | state | found by | overlap | free space contradicted | of comparisons |")
    print("|---|---|---|---|---|---|")
    for match in matches:
        overlap, contradicted = match["overlap"], match["free_space"]
        matcher = match["matcher"].removeprefix("GUESS_SOURCE_").lower().replace("_", " ")
        print(f"| {match['robot_a']} ~ {match['robot_b']} | {match['state']} | {matcher} "
              f"| {'' if overlap < 0 else f'{100 * overlap:.0f} %'} "
              f"| {'' if contradicted < 0 else f'{100 * contradicted:.2f} %'} "
              f"| {match['comparisons'] if match['comparisons'] > 0 else ''} |")


if __name__ == "__main__":
    main()
