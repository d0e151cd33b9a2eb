#!/usr/bin/env python3
"""Tests of lab/bench/scale. Usage: scale_plan_test.py FOLDER, that of scale_plan.py."""
import argparse
import contextlib
import io
import json
import pathlib
import sys
import unittest

import numpy

FOLDER = pathlib.Path(sys.argv.pop(1))
sys.path.insert(0, str(FOLDER))
import measure_load  # noqa: E402
import scale_plan  # noqa: E402
import site_model  # noqa: E402

COSTS = site_model.load_costs()
OPTIONS = argparse.Namespace(
    robots=300, sites=6, seed=5, draws=2, cores=16, memory_gb=64, most=0.7, disk_mb_s=200,
    mtbf_days=90, core_hour=0.04, gb_month=0.1)


def load(robots, **changes):
    return site_model.SiteLoad(site_model.Site(robots), COSTS, site_model.Parameters(**changes))


def said(what, options=OPTIONS):
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        getattr(scale_plan, what)(options, site_model.Parameters(), COSTS)
    return text.getvalue()


class Rules(unittest.TestCase):
    def test_a_count_that_grows_by_a_quarter(self):
        # 4, 5, 7, 9, 12 after 3.
        self.assertEqual(site_model.growth_steps(3, 12, 1.25), 5)
        self.assertEqual(site_model.growth_steps(3, 11, 1.25), 4)
        self.assertEqual(site_model.growth_steps(3, 3, 1.25), 0)

    def test_all_pairs_of_a_dozen_and_a_few_of_more(self):
        self.assertEqual(site_model.pairs_of(12, 3), 66)
        self.assertEqual(site_model.pairs_of(100, 3), 300)

    def test_what_attempts_take_until_maps_end_growing(self):
        # When a map has 1, 2, 3, 4, 5, 7, 9 and 12 submaps.
        self.assertEqual(site_model.submaps_of_attempts(13, 1000), 2 * 43)
        self.assertEqual(site_model.submaps_of_attempts(13, 5), 2 * 30)
        self.assertEqual(site_model.submaps_of_attempts(0, 5), 0)


class Thread(unittest.TestCase):
    def test_what_waits_is_worked_off_later_and_nothing_is_lost(self):
        asked = numpy.array([3.0, 0, 0, 0])
        taken, waiting = site_model.drain(asked, 1)
        self.assertEqual(list(taken), [1, 1, 1, 0])
        self.assertEqual(list(waiting), [2 * site_model.STEP_S, site_model.STEP_S, 0, 0])

    def test_what_is_more_than_a_day_of_it_is_carried_on(self):
        _, waiting = site_model.drain(numpy.full(4, 1.5), 1)
        self.assertAlmostEqual(waiting[-1], 8 * 0.5 * site_model.STEP_S)


class OneSite(unittest.TestCase):
    def test_robots_drive_as_long_as_their_shifts(self):
        for shifts, two in ((1, False), (2, True)):
            site = site_model.SiteLoad(site_model.Site(30, two_shifts=two), COSTS,
                                       site_model.Parameters())
            hours = site.robots.sum() * site_model.STEP_S / 3600
            self.assertAlmostEqual(hours, 30 * 8 * shifts, delta=0.5)
            self.assertAlmostEqual(site.begin.sum(), 30 * shifts)

    def test_work_of_sessions_is_all_done_some_time(self):
        site = load(30)
        self.assertAlmostEqual(site.pairs().sum() * site_model.STEP_S,
                               30 * site.pair_work_of_session(), places=3)

    def test_what_is_per_robot_grows_with_them_and_the_index_faster(self):
        few, many = load(50), load(100)
        self.assertAlmostEqual(many.ingest().max(), 2 * few.ingest().max())
        self.assertGreater(many.index().sum(), 3.9 * few.index().sum())

    def test_workers_take_from_the_owner_what_they_do(self):
        alone, shared = load(100), load(100, workers=True)
        self.assertAlmostEqual((alone.matching_thread() - shared.matching_thread()).sum(),
                               shared.elsewhere().sum())


class Fleet(unittest.TestCase):
    def test_all_robots_are_on_sites_and_the_large_ones_are_there(self):
        sites = scale_plan.draw_sites(10000, 200, site_model.Parameters(),
                                      numpy.random.default_rng(3))
        sizes = sorted(site.robots for site in sites)
        self.assertEqual((len(sizes), sum(sizes)), (200, 10000))
        self.assertEqual(sizes[-6:], [500] * 6)

    def test_no_server_is_given_more_than_is_planned(self):
        loads = [load(n) for n in (60, 50, 40, 30, 20, 10, 1000)]
        servers, misfits = scale_plan.pack(loads, 16, 64, 0.7)
        self.assertEqual([m.site.robots for m in misfits], [1000])
        self.assertEqual(sum(len(server["loads"]) for server in servers), 6)
        for server in servers:
            self.assertLessEqual(sum(x.owner() for x in server["loads"]).max(), 0.7 * 16)

    def test_the_same_seed_is_the_same_plan_and_another_is_not(self):
        self.assertEqual(said("fleet"), said("fleet"))
        other = argparse.Namespace(**{**vars(OPTIONS), "seed": 50})
        self.assertNotEqual(said("fleet"), said("fleet", other))

    def test_the_size_that_breaks_is_the_first(self):
        self.assertEqual(scale_plan.first_size(lambda n: n >= 137), 137)
        self.assertIsNone(scale_plan.first_size(lambda n: False))


class Measured(unittest.TestCase):
    def test_a_run_is_what_came_since_its_beginning(self):
        def server(ingest, other, submaps):
            stage = {"count": 2, "sum": 3.0}
            return {"threads_s": {"ingest": ingest, "matching": 1.0}, "cpu_s": ingest + other + 1,
                    "stages": {"loop_search": {"count": 1, "sum": 1.0}, "match": stage},
                    "submaps": submaps, "retired": 1, "peak_mb": 100, "matches": {}}

        def postgres(much):
            return {"cpu_s": much, "busiest_cpu_s": much / 2, "commits": 10 * much,
                    "wal_syncs": much, "wal_bytes": 1e6 * much, "database_bytes": 2e6 * much}

        run = measure_load.summary({
            "load": ["--robots", "2", "--seconds", "30", "--world", "campus"], "became_idle": True,
            "before": server(1, 2, 0), "after": server(5, 8, 6), "postgres_before": postgres(1),
            "postgres_after": postgres(4),
            "report": {"robots": 2, "seconds": 31, "processed": 600,
                       "acknowledgement_ms": {"p50": 3, "max": 9}}})
        measured = run["measured"]
        self.assertEqual((run["world"], run["seconds"], run["scans"]), ("campus", 30, 600))
        self.assertEqual(measured["of these ingest"], 4)
        self.assertEqual(measured["of these streams"], 6)
        self.assertEqual(measured["CPU s of the server"], 10)
        self.assertEqual(measured["share of pairs in matching"], 0.75)
        self.assertEqual((measured["submaps"], measured["commits"], measured["WAL MB"]), (7, 30, 3))

    def test_each_cost_says_what_measured_it(self):
        entries = json.loads((FOLDER / "costs.json").read_text())["costs"]
        for name, entry in entries.items():
            self.assertTrue(entry["by"], name)
            self.assertGreater(entry["value"], 0, name)

    def test_the_model_is_near_the_runs_that_it_was_not_fed(self):
        runs = [run for run in json.loads((FOLDER / "runs.json").read_text())["runs"]
                if not run["fed"]]
        self.assertGreaterEqual(len(runs), 2)
        for run in runs:
            said_of_it = scale_plan.predict(run, COSTS)
            for name in ("CPU s of the server", "of these ingest", "of these matching", "submaps"):
                ratio = said_of_it[name] / run["measured"][name]
                self.assertTrue(0.6 < ratio < 1.67, f"{run['command']}: {name} {ratio:.2f}")


if __name__ == "__main__":
    unittest.main()
