#!/usr/bin/env python3
"""Fits the weights of server/matching/pairs/probability.cc.

    merging_benchmark --wild 22 --seed 1100 --cache DIR --hypotheses a.csv   (and others)
    /usr/bin/python3 lab/bench/merging/fit_probability.py a.csv b.csv ...

Needs numpy (python3-numpy). Prints each weight with the median of right hypotheses, and how well
probabilities hold where they were not fitted: worlds are left out by eighths, the rest is fitted.
"""

import csv
import sys

import numpy

NAMES = ["kLooserThanOwn", "kUpright", "kContradictedRegions", "kClean", "kSharedArea",
         "kDistinctive", "kRepeats"]
# Closed places have a rule of their own: see 0027.
CLOSED = ("twins", "twins_large", "twins_wings")
UPSIDE_DOWN = -5.0  # Log odds of a sensor's hanging: kUpsideDownLogOdds.
PENALTY = 0.1  # On squared weights of standardised measures.
PARTS = 8


def measures(row):
    """What probability.cc measures of a hypothesis, in the order of NAMES."""
    own_residual = max(row["own_residual_m"] or 0, 0.025)
    own_upright = max(row["own_upright_ratio"] or 1, 0.3)
    in_front = row["free_space"] * row["comparisons"]
    return [
        10 * (row["residual_m"] - own_residual),
        numpy.log(0.1 + min(row["upright_ratio"] / own_upright, 1.1)),
        numpy.log10(1 + row["contradicted_regions"] / (1 + 0.005 * row["regions"])),
        min(0.5, max(0, numpy.log10((300 + row["comparisons"]) / (3 + in_front)) - 2.7)),
        numpy.log10(1 + row["shared_area_m2"]),
        numpy.log10(1 + row["distinctive"]),
        max(row["repeats_a"], row["repeats_b"]),
    ]


def read(paths):
    """By pair: the seed of its world, measures of its places, what is known of them beforehand, and
    which of them are right."""
    pairs = {}
    for path in paths:
        with open(path) as file:
            for row in csv.DictReader(file):
                if row["scenario"] in CLOSED:
                    continue
                numbers = {k: float(v) for k, v in row.items() if k not in ("scenario", "source")}
                if numbers["is_joint"]:
                    key = (path, row["pair"])
                    pairs.setdefault(key, (row["seed"], []))[1].append(numbers)
    return [(seed, numpy.array([measures(r) for r in rows]),
             UPSIDE_DOWN * numpy.array([r["upside_down"] for r in rows]),
             numpy.array([r["joint_right"] > 0 for r in rows])) for seed, rows in pairs.values()]


def likelihood(weights, pairs):
    """Negative log likelihood of the conditional logit, and its gradient."""
    value, gradient = PENALTY * weights[:-1] @ weights[:-1] / 2, numpy.zeros_like(weights)
    gradient[:-1] = PENALTY * weights[:-1]
    for _, x, known, right in pairs:
        odds = numpy.exp(numpy.clip(x @ weights[:-1] + weights[-1] + known, -40, 40))
        odds = odds / numpy.where(right, max(1, right.sum()), 1)  # Two right ones are one.
        share = odds / (1 + odds.sum())
        wanted = share * right / share[right].sum() if right.any() else numpy.zeros_like(share)
        value -= numpy.log(share[right].sum() if right.any() else 1 - share.sum())
        gradient[:-1] += (share - wanted) @ x
        gradient[-1] += (share - wanted).sum()
    return value, gradient


def fit(pairs):
    """BFGS with backtracking."""
    at = numpy.zeros(len(NAMES) + 1)
    inverse = 0.01 * numpy.eye(len(at))
    value, gradient = likelihood(at, pairs)
    for _ in range(200):
        step = -inverse @ gradient
        while True:
            new_value, new_gradient = likelihood(at + step, pairs)
            if new_value <= value + 1e-4 * step @ gradient or abs(step).max() < 1e-9:
                break
            step = step / 2
        change = new_gradient - gradient
        at, gain, value, gradient = at + step, value - new_value, new_value, new_gradient
        if gain < 1e-6:
            break
        if step @ change > 1e-12:
            left = numpy.eye(len(at)) - numpy.outer(step, change) / (step @ change)
            inverse = left @ inverse @ left.T + numpy.outer(step, step) / (step @ change)
    return at


def best(weights, x, known, right):
    """Probability of the most probable, and whether it is right."""
    odds = numpy.exp(numpy.clip(x @ weights[:-1] + weights[-1] + known, -40, 40))
    top = int(odds.argmax())
    return odds[top] / (1 + odds.sum()), bool(right[top])


def report(left_out):
    """How well probabilities hold: of pairs left out, the best one's, and whether it is right."""
    print("| probability | best hypotheses | right |\n|---|---|---|")
    error = 0
    for low in numpy.arange(10) / 10:
        within = [(p, r) for p, r in left_out if low <= p < low + 0.1 or (low == 0.9 and p == 1)]
        if within:
            p, r = numpy.mean(within, axis=0)
            error += len(within) * abs(p - r) / len(left_out)
            print(f"| {low:.1f}-{low + 0.1:.1f}: {p:.2f} | {len(within)} | {r:.2f} |")
    print(f"expected calibration error {error:.3f}")
    wrong = sorted((p for p, right in left_out if not right), reverse=True)
    print("most probable wrong ones: " + " ".join(f"{p:.3f}" for p in wrong[:5]))
    for least in (0.9, 0.95, 0.97, 0.985):
        above = [right for p, right in left_out if p >= least]
        print(f"from {least} on: {sum(above)} of {len(above)} right")


def main():
    pairs = read(sys.argv[1:])
    every = numpy.concatenate([pair[1] for pair in pairs])
    mean, spread = every.mean(0), every.std(0) + 1e-9
    scaled = [(seed, (x - mean) / spread, *rest) for seed, x, *rest in pairs]

    worlds = sorted({pair[0] for pair in pairs})
    left_out = []
    for part in range(PARTS):
        out = set(worlds[part::PARTS])
        weights = fit([p for p in scaled if p[0] not in out])
        left_out += [best(weights, *rest) for seed, *rest in scaled if seed in out]
    print(f"{len(pairs)} pairs of {len(worlds)} worlds")
    report(left_out)

    weights = fit(scaled)
    raw = weights[:-1] / spread
    typical = numpy.median([x[right][0] for _, x, _, right in pairs if right.any()], axis=0)
    print(f"kTypicalLogOdds = {weights[-1] + raw @ (typical - mean):.3f}")
    for name, weight, median in zip(NAMES, raw, typical):
        print(f"{name}{{{weight:.2f}, {median:.3f}}}")


if __name__ == "__main__":
    main()
