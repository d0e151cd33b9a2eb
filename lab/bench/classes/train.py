#!/usr/bin/python3
"""Trains the forest that tells what points are of; see lab/docs/classes.md.

Usage: train.py SAMPLES... FOREST
SAMPLES are files that classes_benchmark --samples wrote. Needs Debian's python3-sklearn.
"""
import struct
import sys

import numpy
from sklearn.ensemble import RandomForestClassifier

FEATURES = 45  # kFeatures of server/classes/features.h.
CLASSES = 10   # PointClass's.
LEAF = 0xffff
POWERS = numpy.arange(0.8, 2.5, 0.1)  # Probabilities are taken to one of these.


def read(path, number):
    """Rows of the features, the true class and the world's number. Unknown ones teach nothing."""
    rows = numpy.fromfile(path, dtype=numpy.float32).reshape(-1, FEATURES + 2)
    rows[:, -1] += 1000 * number
    return rows[rows[:, -2] > 0]


def fit(rows):
    truth = rows[:, -2].astype(int)
    # Rare classes weigh more than their points, but less than common ones.
    counts = numpy.bincount(truth, minlength=CLASSES)
    weights = (counts.max() / numpy.maximum(counts, 1)) ** 0.25
    forest = RandomForestClassifier(n_estimators=24, max_leaf_nodes=2000, min_samples_leaf=10,
                                    max_features=8, max_samples=0.3, n_jobs=-1, random_state=1)
    return forest.fit(rows[:, :FEATURES], truth, sample_weight=weights[truth])


def calibration_error(shares, is_right, power):
    """Expected calibration error, ten bins, of probabilities to that power."""
    sharper = shares ** power
    told = sharper.max(1) / sharper.sum(1)
    bins = numpy.minimum((10 * told).astype(int), 9)
    sums = [abs((told - is_right)[bins == number].sum()) for number in range(10)]
    return sum(sums) / len(told)


def power_of(rows):
    """The power at which worlds left out, a third of them, find probabilities true."""
    left_out = rows[:, -1].astype(int) % 3 == 0
    forest = fit(rows[~left_out])
    shares = forest.predict_proba(rows[left_out, :FEATURES])
    is_right = forest.classes_[shares.argmax(1)] == rows[left_out, -2]
    errors = [calibration_error(shares, is_right, power) for power in POWERS]
    print(f"worlds left out: {is_right.mean():.3f} right, calibration {min(errors):.3f}")
    return POWERS[numpy.argmin(errors)]


def tree_bytes(tree, classes):
    """Nodes in an order in which both children of one follow each other, later than it."""
    nodes, leaves, order = [], [], [0]
    for at in range(tree.node_count):
        node = order[at]
        left = tree.children_left[node]
        if left < 0:
            shares = tree.value[node][0] / tree.value[node][0].sum()
            row = [0] * CLASSES
            for share, number in zip(shares, classes):
                row[int(number)] = int(round(255 * share))
            nodes.append((0.0, LEAF, len(leaves)))
            leaves.append(row)
        else:
            nodes.append((tree.threshold[node], tree.feature[node], len(order)))
            order += [left, tree.children_right[node]]
    data = struct.pack("<HH", len(nodes), len(leaves))
    data += b"".join(struct.pack("<fHH", *node) for node in nodes)
    return data + b"".join(bytes(row) for row in leaves)


def main():
    *sources, target = sys.argv[1:]
    rows = numpy.concatenate([read(path, number) for number, path in enumerate(sources)])
    power = power_of(rows)
    forest = fit(rows)
    data = struct.pack("<IIIIIf", 0x524f4649, 1, FEATURES, CLASSES, len(forest.estimators_), power)
    data += b"".join(tree_bytes(t.tree_, forest.classes_) for t in forest.estimators_)
    with open(target, "wb") as file:
        file.write(data)
    worlds = len(set(rows[:, -1]))
    print(f"{len(rows)} points of {worlds} worlds, power {power:.1f}, {len(data)} bytes")


if __name__ == "__main__":
    main()
