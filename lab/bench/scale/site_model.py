"""What one site asks of its server and of PostgreSQL: rates in steps over a day, from unit costs.

Units: seconds, cores (seconds of computing a second), MB = 1e6 bytes unless a name says otherwise.
The rules (which pairs are tried, and when) are the server's: docs/architecture.md, "Which pairs".
Costs are those of costs.json, parameters those of PARAMETERS; nothing here is measured.
"""
import dataclasses
import json
import math
import pathlib

import numpy

STEP_S = 300
DAY_S = 86400
STEPS = DAY_S // STEP_S
SEARCH_ALL = 12  # Sessions up to which all pairs are searched.
PAIR_GROWTH, INDEX_GROWTH, INDEX_FROM = 1.25, 1.5, 3
NEWEST_KEPT = 8  # Submaps of each session that are never retired.
UNDURABLE_SHARE = 0.5  # Share of a submap's scans on their way to be durable, on average.


@dataclasses.dataclass
class Parameters:
    """What no benchmark says: assumptions, each an option of scale_plan.py."""
    rate_hz: float = 10
    shift_h: float = 8
    second_shift: float = 0.5  # Share of sites with two shifts.
    retention_days: float = 7  # retention.max_age_days.
    outdoor: float = 0.25  # Share of sites that are like the campus rather than the museum.
    place_submaps_indoor: int = 68
    place_submaps_outdoor: int = 200
    merged: float = 0.7  # Share of sessions whose map is joined with others, so that ground retires.
    watchers: float = 0.1  # Viewers and readers for each robot that drives.
    worst_partners: bool = False  # Each session tried with 5 others rather than with about 3.
    ingest_owners: int = 1  # Servers among which a site's robots are spread: not built.
    workers: bool = False  # Other processes match, compare sessions, and help with loops.
    replicas: bool = False  # Readers and watchers are served by other processes.


def load_costs(path=pathlib.Path(__file__).with_name("costs.json")):
    """Name -> value."""
    return {name: entry["value"] for name, entry in json.loads(path.read_text())["costs"].items()}


def growth_steps(first, last, growth):
    """How often a count that rises from `first` to `last` has risen by a factor since the last time."""
    times, at = 0, first
    while at < last:
        at = max(at + 1, math.ceil(at * growth))
        times += at <= last
    return times


def pairs_of(sessions, partners):
    if sessions <= SEARCH_ALL:
        return sessions * (sessions - 1) / 2
    return min(sessions * partners, sessions * (sessions - 1) / 2)


def submaps_of_attempts(submaps, limit):
    """Submaps of both maps together, added up over all attempts at a pair while both of its sessions
    grow to so many submaps, of which the map keeps `limit` at most. An attempt is due when a map has
    grown by a quarter. (Up to eight sessions it is due with each submap; but a matching thread that
    has more to do than that comes to each pair about as seldom.)"""
    total, at = 0, 1
    while at <= submaps:
        total += 2 * min(at, limit)
        at = max(at + 1, math.ceil(at * PAIR_GROWTH))
    return total


@dataclasses.dataclass
class Site:
    robots: int
    outdoor: bool = False
    start_h: float = 7
    two_shifts: bool = False


class SiteLoad:
    """A day of a site, in arrays of STEPS."""

    def __init__(self, site, costs, parameters):
        self.site, self.costs, self.p = site, costs, parameters
        self.kind = "campus" if site.outdoor else "museum"
        self.place = (parameters.place_submaps_outdoor if site.outdoor
                      else parameters.place_submaps_indoor)
        self.shifts = 2 if site.two_shifts else 1
        self._presence()
        self._sizes()

    def of_kind(self, name):
        return self.costs[f"{name}_{self.kind}"]

    def _presence(self):
        """Robots that drive, sessions that begin: they come within half an hour."""
        shift_steps, ramp = round(self.p.shift_h * 3600 / STEP_S), 1800 // STEP_S
        self.robots, self.begin = numpy.zeros(STEPS), numpy.zeros(STEPS)
        for shift in range(self.shifts):
            first = round((self.site.start_h + shift * self.p.shift_h) * 3600 / STEP_S)
            for i in range(ramp):
                steps = (first + i + numpy.arange(shift_steps)) % STEPS
                self.robots[steps] += self.site.robots / ramp
                self.begin[(first + i) % STEPS] += self.site.robots / ramp
        self.end = numpy.roll(self.begin, shift_steps)

    def _sizes(self):
        p, n = self.p, self.site.robots
        self.submaps_per_s = self.of_kind("submaps_per_minute") / 60
        self.session_submaps = self.submaps_per_s * p.shift_h * 3600
        kept = min(self.session_submaps, self.place)
        self.kept_per_session = p.merged * min(NEWEST_KEPT, kept) + (1 - p.merged) * kept
        self.sessions_kept = max(n * self.shifts * p.retention_days, n)
        self.map_submaps = self.place + self.sessions_kept * self.kept_per_session

    # Cores.

    def ingest(self):
        return self.robots * self.p.rate_hz * self.of_kind("ingest_s_per_scan")

    def streams(self):
        return self.robots * self.p.rate_hz * self.costs["streams_s_per_scan"]

    def storing(self):
        return self.robots * self.submaps_per_s * self.costs["storing_s_per_submap"]

    def loops_of_workers(self):
        """Those that the owner's matching thread has no time for."""
        return numpy.maximum(0, self.loops() - 1)

    def loops(self):
        return self.robots * self.submaps_per_s * self.of_kind("loops_s_per_submap")

    def pair_work_of_session(self):
        """Seconds of computing that a session's pairs take, its share of each, up to its end."""
        partners = 5 if self.p.worst_partners else self.costs["partners_per_session"]
        pairs = pairs_of(self.sessions_kept, partners)
        total = submaps_of_attempts(self.session_submaps, self.place)
        return pairs / self.sessions_kept * total * self.of_kind("pair_s_per_submap")

    def index_work_of_session(self):
        if self.sessions_kept <= SEARCH_ALL:
            return 0
        times = 2 + growth_steps(INDEX_FROM, int(self.session_submaps), INDEX_GROWTH)
        held = self.costs["index_plan_mb"] * self.sessions_kept <= self.costs["index_held_mb"]
        each = self.costs["index_comparison_s"] + (0 if held else self.costs["index_plan_s"])
        return times * (self.sessions_kept - 1) * each

    def _spread(self, per_session):
        """Of that work of each session, half comes in its first tenth: growth by a factor is soonest
        then. The rest evenly up to its end, where the last search is."""
        duration = max(round(self.p.shift_h * 3600 / STEP_S), 1)
        early = max(duration // 10, 1)
        profile = numpy.zeros(duration + 1)
        profile[:early] += 0.5 / early
        profile[early:] += 0.5 / (duration + 1 - early)
        work = numpy.zeros(STEPS)
        for offset, share in enumerate(profile):
            work += numpy.roll(self.begin, offset) * share * per_session
        return work / STEP_S

    def pairs(self):
        return self._spread(self.pair_work_of_session())

    def index(self):
        return self._spread(self.index_work_of_session())

    def composition(self):
        """A thread that rests four times as long as it worked."""
        asked = self.robots * self.submaps_per_s * self.of_kind("composition_s_per_submap")
        return numpy.minimum(asked, 0.2)

    def placement(self):
        """What is new is placed together: one thread at most."""
        return numpy.minimum(self.robots * self.submaps_per_s * self.costs["placement_s_per_submap"], 1)

    def readers(self):
        return self.robots * self.p.watchers * self.costs["reader_s_per_s"]

    def matching_thread(self):
        """What the one thread of matching of the owner is asked for."""
        if self.p.workers:
            return self.loops() - self.loops_of_workers()
        return self.loops() + self.pairs() + self.index()

    def owner(self):
        """All cores of the server, the matching that waits not counted."""
        taken, _ = drain(self.matching_thread(), 1)
        cores = ((self.ingest() + self.streams()) / self.p.ingest_owners + self.storing() + taken
                 + self.composition() + self.placement())
        return cores if self.p.replicas else cores + self.readers()

    def elsewhere(self):
        """Cores of workers and replicas."""
        cores = numpy.zeros(STEPS)
        if self.p.workers:
            cores = self.pairs() + self.index() + self.loops_of_workers()
        return cores + self.readers() if self.p.replicas else cores

    # A single change, when the map is as large as it becomes.

    def placing_s(self):
        """How long the whole is placed anew: every tenth time."""
        return self.costs["placement_whole_s_per_submap"] * self.map_submaps

    # PostgreSQL and memory.

    def database(self):
        return self.robots * self.submaps_per_s * self.of_kind("postgres_s_per_submap")

    def commits_per_s(self):
        return (self.robots * self.submaps_per_s * self.of_kind("commits_per_submap")
                + self.costs["lease_commits_per_s"])

    def commit_share(self):
        """Of the time of the one connection that writes: what it computes, and syncing."""
        return (self.database() * self.costs["writer_share"]
                + self.commits_per_s() * self.costs["sync_s"])

    def wal_mb_per_s(self):
        return self.robots * self.submaps_per_s * self.of_kind("wal_mb_per_submap")

    def database_gb(self):
        return self.map_submaps * self.of_kind("database_mb_per_submap") / 1e3

    def memory_gb(self):
        """Of the owner: what a session that is open holds, and the records of the map."""
        c = self.costs
        return (c["memory_base_mb"] + c["memory_cache_mb"]
                + self.robots.max() * c["memory_mb_per_robot"]
                + self.map_submaps * c["memory_kb_per_submap"] / 1e3) / 1e3

    # A server that dies.

    def again_s(self, step):
        """Seconds of computing for what robots send again: what was on its way to be durable."""
        scans = self.robots[step] * UNDURABLE_SHARE * self.p.rate_hz / self.submaps_per_s
        return scans * (self.of_kind("ingest_s_per_scan") + self.costs["streams_s_per_scan"])


def drain(asked, limit):
    """(cores taken, seconds of work that wait) per step, where a thread gives `limit` cores: of the
    second of two like days."""
    taken, waiting, backlog = [], [], 0.0
    for cores in numpy.concatenate([asked, asked]):
        work = backlog + cores * STEP_S
        done = min(work, limit * STEP_S)
        backlog = work - done
        taken.append(done / STEP_S)
        waiting.append(backlog)
    half = len(asked)
    return numpy.array(taken[half:]), numpy.array(waiting[half:])
