#!/usr/bin/env python3
"""Plans for fleets: cores, servers, memory, PostgreSQL and money, and where one site breaks.

    lab/bench/scale/scale_plan.py fleet [--robots 10000 --sites 200 --seed 1 --draws 20]
    lab/bench/scale/scale_plan.py site                       # sites of 10 to 1,000 robots
    lab/bench/scale/scale_plan.py limits                     # which size breaks what, and what moves it
    lab/bench/scale/scale_plan.py validate                   # the model beside runs that it was not fed

Unit costs are those of costs.json, each with the command that measured it; all else are assumptions,
which are options. Needs numpy. docs/scale.md says what of this is measured and what is not.
"""
import argparse
import dataclasses
import json
import math
import pathlib

import numpy

from site_model import (DAY_S, INDEX_FROM, INDEX_GROWTH, SEARCH_ALL, Parameters, Site, SiteLoad,
                        drain, growth_steps, load_costs, pairs_of, submaps_of_attempts)

HERE = pathlib.Path(__file__).parent
LARGE_ROBOTS, LARGE_SHARE = 500, 0.3  # Robots of a large site; share of all robots on such sites.
SMALL = (20, 50)  # The other sites have so many robots.
SIZES = (10, 20, 50, 100, 200, 500, 1000)
WAITS_AT_MOST_S = 3600  # The matching thread may lag so far; later merges are of no use.
COMMITS_AT_MOST, DISK_AT_MOST = 0.7, 0.5  # Shares of a connection, of a disk, beyond which it queues.


def draw_sites(robots, sites, parameters, random):
    """Uneven: a few large ones; the sizes of the others are drawn, and scaled to the sum."""
    large = min(round(robots * LARGE_SHARE / LARGE_ROBOTS), sites - 1)
    small = random.integers(SMALL[0], SMALL[1] + 1, sites - large).astype(float)
    small *= (robots - large * LARGE_ROBOTS) / small.sum()
    sizes = numpy.floor(small).astype(int)
    short = robots - large * LARGE_ROBOTS - sizes.sum()
    sizes[numpy.argsort(sizes - small)[:short]] += 1
    return [Site(int(size), bool(random.random() < parameters.outdoor),
                 float(random.normal(7, 1)), bool(random.random() < parameters.second_shift))
            for size in [LARGE_ROBOTS] * large + list(sizes)]


def pack(loads, cores, memory_gb, most):
    """(servers, sites of them all that fit on none): first fit, the largest first, by the sum of all
    their steps' cores, so that sites with other hours share a server."""
    servers, misfits = [], []
    for load in sorted(loads, key=lambda load: -load.owner().max()):
        need, memory = load.owner(), load.memory_gb()
        if need.max() > most * cores or memory > memory_gb:
            misfits.append(load)
            continue
        for server in servers:
            if ((server["cores"] + need).max() <= most * cores
                    and server["memory"] + memory <= memory_gb):
                break
        else:
            server = {"cores": numpy.zeros(len(need)), "memory": 0.0, "loads": []}
            servers.append(server)
        server["cores"] = server["cores"] + need
        server["memory"] += memory
        server["loads"].append(load)
    return servers, misfits


def fail(servers, cores, mtbf_days, takeover_s, days, random):
    """Servers die at random over so many days: of each failure how many robots wait, and how long
    until they have their poses live again on a spare server of the same size."""
    waits = []
    for _ in range(random.poisson(len(servers) * days / mtbf_days)):
        server, step = servers[random.integers(len(servers))], random.integers(len(servers[0]["cores"]))
        busy = server["cores"][step]
        robots = sum(load.robots[step] for load in server["loads"])
        again = sum(load.again_s(step) for load in server["loads"])
        waits.append((robots, takeover_s + again / max(cores - busy, 1e-9)))
    return waits


def fleet_of(options, parameters, costs, seed):
    random = numpy.random.default_rng(seed)
    loads = [SiteLoad(site, costs, parameters)
             for site in draw_sites(options.robots, options.sites, parameters, random)]
    servers, misfits = pack(loads, options.cores, options.memory_gb, options.most)
    step_s = DAY_S / len(loads[0].robots)
    robot_hours = sum(load.robots.sum() for load in loads) * step_s / 3600
    work = {name: sum(getattr(load, name)().sum() for load in loads) * step_s / robot_hours
            for name in ("ingest", "streams", "storing", "loops", "pairs", "index", "composition",
                         "placement", "readers", "database")}
    peak = sum(load.owner() + load.elsewhere() for load in loads)
    waits = fail(servers, options.cores, options.mtbf_days, costs["takeover_s"], 365, random)
    database_gb = sum(load.database_gb() for load in loads)
    bought = (len(servers) * options.cores
              + sum(load.owner().max() / options.most for load in misfits))
    return {
        "robots driving, most": sum(load.robots for load in loads).max(),
        "cores of servers, most": peak.max(),
        "cores of PostgreSQL, most": sum(load.database() for load in loads).max(),
        f"servers of {options.cores} cores": len(servers),
        "sites that fit on none": len(misfits),
        "robots on these": sum(load.site.robots for load in misfits),
        "GB of memory": sum(load.memory_gb() for load in loads),
        "GB of database": database_gb,
        "GB of WAL a day": sum(load.wal_mb_per_s().sum() for load in loads) * step_s / 1e3,
        "MB of WAL a second, most": sum(load.wal_mb_per_s() for load in loads).max(),
        "commits a second, most": sum(load.commits_per_s() for load in loads).max(),
        "sites whose matching never ends": sum(
            load.matching_thread().mean() > 1 for load in loads),
        "servers that die in a year": len(waits),
        "robots that wait at a time, mean": numpy.mean([w[0] for w in waits]) if waits else 0,
        "s until they are live, worst": max((w[1] for w in waits), default=0),
        **{f"core-s a robot-hour: {name}": value for name, value in work.items()},
        "core-s a robot-hour": sum(work.values()),
        "price of 1,000 robot-hours: computing": sum(work.values()) / 3.6 * options.core_hour,
        "the same, servers paid for day and night":
            1e3 * bought * 24 * options.core_hour / robot_hours,
        "price of 1,000 robot-hours: the database's disk":
            1e3 * database_gb * options.gb_month / 30.4 / robot_hours,
    }


def number(value):
    if isinstance(value, (int, numpy.integer)) or value >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}" if value >= 0.001 or value == 0 else f"{value:.1e}"


def table(head, rows):
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(x if isinstance(x, str) else number(x) for x in row) + " |")


def fleet(options, parameters, costs):
    draws = [fleet_of(options, parameters, costs, options.seed + i) for i in range(options.draws)]
    rows = []
    for name in draws[0]:
        values = [draw[name] for draw in draws]
        rows.append([name, float(numpy.median(values)), max(values)])
    table([f"{options.robots:,} robots on {options.sites} sites", "median", "worst"], rows)


def figures(robots, parameters, costs):
    load = SiteLoad(Site(robots, parameters.outdoor >= 1, 7, parameters.second_shift >= 0.5), costs,
                    parameters)
    asked = load.matching_thread()
    return {
        "cores": load.owner().max(),
        "of these ingest": load.ingest().max() / parameters.ingest_owners,
        "matching asked, share of its thread over the day": asked.mean(),
        "its work waits, h": drain(asked, 1)[1].max() / 3600 if asked.mean() < 1 else math.inf,
        "share of the writing connection": load.commit_share().max(),
        "WAL, MB/s": load.wal_mb_per_s().max(),
        "memory, GB": load.memory_gb(),
        "database, GB": load.database_gb(),
        "placing the whole, s": load.placing_s(),
        "cores elsewhere": load.elsewhere().max(),
    }


def site(options, parameters, costs):
    columns = {n: figures(n, parameters, costs) for n in SIZES}
    rows = [[name] + [columns[n][name] for n in SIZES] for name in columns[SIZES[0]]]
    table(["robots on one site"] + [f"{n:,}" for n in SIZES], rows)


def first_size(breaks, most=20000):
    """The smallest number of robots at which it breaks; None: none does up to `most`."""
    if not breaks(most):
        return None
    low, high = 0, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if breaks(middle) else (middle, high)
    return high


BREAKS = {
    "cores of the owner": lambda f, o: f["cores"] > o.most * o.cores,
    "matching an hour behind": lambda f, o: f["its work waits, h"] * 3600 > WAITS_AT_MOST_S,
    "commits": lambda f, o: f["share of the writing connection"] > COMMITS_AT_MOST,
    "disk of PostgreSQL": lambda f, o: f["WAL, MB/s"] > DISK_AT_MOST * o.disk_mb_s,
    "memory": lambda f, o: f["memory, GB"] > o.memory_gb,
}
CONFIGURATIONS = {
    "one owner": {},
    "+ replicas for readers": {"replicas": True},
    "+ workers": {"replicas": True, "workers": True},
    "+ ingest on 4 owners": {"replicas": True, "workers": True, "ingest_owners": 4},
}


def limits(options, parameters, costs):
    rows = []
    for name, changes in CONFIGURATIONS.items():
        changed = dataclasses.replace(parameters, **changes)
        sizes = {what: first_size(lambda n, broken=broken: n > 0 and broken(
            figures(n, changed, costs), options)) for what, broken in BREAKS.items()}
        reached = {what: size for what, size in sizes.items() if size is not None}
        first = min(reached, key=reached.get) if reached else "none"
        rows.append([name, first] + ["none" if size is None else size for size in sizes.values()])
    table(["from so many robots on one site on", "first"] + list(BREAKS), rows)


def predict(run, costs):
    """What the model says of a run of measure_load.py: robots that begin together, and the work until
    nothing waits."""
    n, kind = run["robots"], run["world"]
    scans = run["scans"]
    submaps_each = costs[f"submaps_per_minute_{kind}"] * run["seconds"] / 60
    submaps = n * submaps_each
    each = max(round(submaps_each), 1)
    pairs = pairs_of(n, costs["partners_per_session"])
    index = 0
    if n > SEARCH_ALL:
        times = 2 + growth_steps(INDEX_FROM, each, INDEX_GROWTH)
        index = n * (n - 1) / 2 * times * costs["index_comparison_s"]
    cpu = {
        "ingest": scans * costs[f"ingest_s_per_scan_{kind}"],
        "streams": scans * costs["streams_s_per_scan"],
        "storing": submaps * costs["storing_s_per_submap"],
        "matching": submaps * costs[f"loops_s_per_submap_{kind}"] + index
        + pairs * submaps_of_attempts(each, math.inf) * costs[f"pair_s_per_submap_{kind}"],
        "composition": min(submaps * costs[f"composition_s_per_submap_{kind}"], 0.2 * run["seconds"]),
        "placement": submaps * costs["placement_s_per_submap"],
    }
    return {"CPU s of the server": sum(cpu.values()), **{f"of these {k}": v for k, v in cpu.items()},
            "submaps": submaps, "CPU s of PostgreSQL": submaps * costs[f"postgres_s_per_submap_{kind}"],
            "commits": submaps * costs[f"commits_per_submap_{kind}"]
            + run["seconds"] * costs["lease_commits_per_s"],
            "WAL MB": submaps * costs[f"wal_mb_per_submap_{kind}"],
            "database MB": submaps * costs[f"database_mb_per_submap_{kind}"]}


def validate(options, parameters, costs):
    for run in json.loads((HERE / "runs.json").read_text())["runs"]:
        if run["fed"]:
            continue
        said, was = predict(run, costs), run["measured"]
        rows = [[name, said[name], was[name], f"{100 * (said[name] / was[name] - 1):+.0f} %"]
                for name in said if was.get(name)]
        table([f"{run['robots']} robots, {run['seconds']:.0f} s, {run['world']}", "predicted",
               "measured", "error"], rows)
        print()


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["fleet", "site", "limits", "validate"])
    parser.add_argument("--robots", type=int, default=10000)
    parser.add_argument("--sites", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--cores", type=int, default=16, help="of a server")
    parser.add_argument("--memory-gb", type=float, default=64, help="of a server")
    parser.add_argument("--most", type=float, default=0.7, help="share of its cores that is planned")
    parser.add_argument("--disk-mb-s", type=float, default=200, help="that PostgreSQL's disk writes")
    parser.add_argument("--mtbf-days", type=float, default=90, help="between failures of a server")
    parser.add_argument("--core-hour", type=float, default=0.04, help="price of a core for an hour")
    parser.add_argument("--gb-month", type=float, default=0.10, help="price of a GB of disk")
    for field in dataclasses.fields(Parameters):
        name = "--" + field.name.replace("_", "-")
        if isinstance(field.default, bool):
            parser.add_argument(name, action="store_true")
        else:
            parser.add_argument(name, type=type(field.default), default=field.default)
    options = parser.parse_args()
    parameters = Parameters(**{f.name: getattr(options, f.name)
                               for f in dataclasses.fields(Parameters)})
    globals()[options.what](options, parameters, load_costs())


if __name__ == "__main__":
    main()
