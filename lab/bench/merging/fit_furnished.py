#!/usr/bin/env python3
"""Fits kFurnished of server/matching/pairs/probability.cc; all other weights stay.

    merging_benchmark --wild 29 --seed 9240 --robots 3 --kind flat,office,storey,carpark,inn \\
        --whole --hypotheses a.csv                                              (and others)
    /usr/bin/python3 lab/bench/merging/fit_furnished.py a.csv b.csv ...

Needs numpy (python3-numpy). Prints what fit_probability.py prints: with the weight as it stands in
probability.cc, which tells how well it holds where these worlds are fresh; then of worlds left out
by eighths; and the weight that fits them all.
"""

import csv
import os
import re
import sys

import numpy

from fit_probability import NAMES, PARTS, UPSIDE_DOWN, best, measures, report

FOLDER = os.path.join(os.path.dirname(__file__), "../../server/matching/pairs")
ALIKE = ("exact twin", "bare twin")  # No measure tells them: see 0027.
# Places that are built alike and furnished otherwise are a fifth of the pairs, and rare in earnest.
TWIN_WEIGHT = 0.1
GROUND = NAMES.index("kSharedArea")


def compiled(name):
    """Weight and typical measure of a coefficient."""
    with open(os.path.join(FOLDER, "probability.cc")) as file:
        found = re.search(name + r"\{(-?[\d.]+), (-?[\d.]+)\}", file.read())
    return float(found[1]), float(found[2])


def limit(name):
    with open(os.path.join(FOLDER, "limits.h")) as file:
        return float(re.search(name + r" = (-?[\d.]+)", file.read())[1])


def held_weights():
    """Weights and typical measures, by NAMES, and the log odds of typical ones."""
    weights, typical = zip(*(compiled(name) for name in NAMES))
    return numpy.array(weights), numpy.array(typical), limit("kTypicalLogOdds")


ROOMS_M2, NO_ROOM_M2 = limit("kRoomsM2"), limit("kNoRoomM2")


def row_of(row, held):
    """What is fitted, as (measure, 1) under a roof and (0, 0) elsewhere; and the held log odds."""
    weights, typical, log_odds = held
    measured = numpy.array(measures(row))
    known = log_odds + (UPSIDE_DOWN if row["upside_down"] else 0)
    if row["outdoors"]:
        return (0, 0), known + weights @ (measured - typical)
    measured[GROUND] = numpy.log10(1 + max(row["shared_area_m2"], ROOMS_M2))
    ground = NO_ROOM_M2 + min(row["shared_area_m2"], ROOMS_M2)
    density = numpy.log10((1 + row["things_there"]) / (1 + row["things_gone"]) / ground)
    return (density, 1), known + weights @ (measured - typical)


def is_right(row):
    return row["joint_right"] > 0 or (row["right"] > 0 and row["error_m"] < 0.3)


def read(paths):
    """By pair: its world, weight, what is fitted, held log odds, and which places are right."""
    held, pairs = held_weights(), {}
    for path in paths:
        with open(path) as file:
            for row in csv.DictReader(file):
                if row["scenario"].endswith(ALIKE):
                    continue
                numbers = {k: float(v) for k, v in row.items() if k not in ("scenario", "source")}
                if numbers["is_joint"]:
                    weight = TWIN_WEIGHT if row["scenario"].endswith("twin") else 1
                    pair = pairs.setdefault((path, row["pair"]), (row["seed"], weight, []))
                    pair[2].append(numbers)
    result = []
    for seed, weight, rows in pairs.values():
        fitted, known = zip(*(row_of(r, held) for r in rows))
        right = numpy.array([is_right(r) for r in rows])
        result.append((seed, weight, numpy.array(fitted), numpy.array(known), right))
    return result


def fit(pairs):
    """Newton's method on the log likelihood of the conditional logit, held near zero by a hair."""
    at = numpy.zeros(2)
    for _ in range(50):
        gradient, hessian = -0.01 * at, 0.01 * numpy.eye(2)
        for _, weight, x, known, right in pairs:
            odds = numpy.exp(numpy.clip(x @ at + known, -40, 40))
            odds = odds / numpy.where(right, max(1, right.sum()), 1)  # Two right ones are one.
            share = odds / (1 + odds.sum())
            wanted = share * right / share[right].sum() if right.any() else 0 * share
            gradient += weight * (wanted - share) @ x
            mean = share @ x
            hessian += weight * ((x * share[:, None]).T @ x - numpy.outer(mean, mean))
        step = numpy.linalg.solve(hessian, gradient)
        at = at + step / max(1, numpy.abs(step).max())
        if numpy.abs(step).max() < 1e-6:
            break
    return at


def main():
    pairs = read(sys.argv[1:])
    worlds = sorted({pair[0] for pair in pairs})
    left_out = []
    for part in range(PARTS):
        out = set(worlds[part::PARTS])
        weights = numpy.append(fit([p for p in pairs if p[0] not in out]), 0)
        left_out += [best(weights, *rest) for seed, _, *rest in pairs if seed in out]
    weight, typical = compiled("kFurnished")
    print(f"{len(pairs)} pairs of {len(worlds)} worlds, as compiled")
    report([best(numpy.array([weight, -weight * typical, 0]), *rest) for _, _, *rest in pairs])
    print("left out by eighths")
    report(left_out)
    weight, constant = fit(pairs)
    print(f"kFurnished{{{weight:.2f}, {-constant / weight:.3f}}}")


if __name__ == "__main__":
    main()
