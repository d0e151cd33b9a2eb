#!/usr/bin/env python3
"""Reads grid maps, tiles and tracks as the programs they are for do, and says what is wrong.

Usage: check_files.py MAP.yaml ... --tiles FOLDER --points N --kml FILE --geojson FILE
"""
import argparse
import json
import pathlib
import re
import sys
import xml.etree.ElementTree

import yaml


def grid(path):
    """Counts (occupied, free, unknown) as map_server's trinary mode has them."""
    described = yaml.safe_load(path.read_text())
    assert described["mode"] == "trinary" and len(described["origin"]) == 3, described
    raw = (path.parent / described["image"]).read_bytes()
    header = re.match(rb"P5\s(?:#[^\n]*\n)*(\d+)\s+(\d+)\s+255\s", raw)
    width, height = int(header[1]), int(header[2])
    pixels = raw[header.end():]
    assert len(pixels) == width * height, (width, height, len(pixels))
    counts = [0, 0, 0]
    for value, number in enumerate(map(pixels.count, (bytes([v]) for v in range(256)))):
        shade = value / 255 if described["negate"] else (255 - value) / 255
        occupied = shade > described["occupied_thresh"]
        free = shade < described["free_thresh"]
        counts[0 if occupied else 1 if free else 2] += number
    return counts


def tiles(folder, points):
    """The tiles that the metadata names hold all points, each within its own bounds."""
    import struct

    metadata = yaml.safe_load((folder / "pointcloud_map_metadata.yaml").read_text())
    size = metadata.pop("x_resolution"), metadata.pop("y_resolution")
    total = 0
    for name, corner in metadata.items():
        raw = (folder / "pointcloud_map" / name).read_bytes()
        head, data = raw.split(b"DATA binary\n", 1)
        count = int(re.search(rb"POINTS (\d+)", head)[1])
        assert len(data) == 20 * count, name
        for x, y, *_ in struct.iter_unpack("<4fI", data):
            for at, low, edge in ((x, corner[0], size[0]), (y, corner[1], size[1])):
                assert low <= at < low + edge, (name, x, y)
        total += count
    assert total == points, (total, points)
    assert len(metadata) == len(list((folder / "pointcloud_map").iterdir()))
    return len(metadata)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("maps", nargs="+", type=pathlib.Path)
    parser.add_argument("--tiles", type=pathlib.Path)
    parser.add_argument("--points", type=int)
    parser.add_argument("--kml", type=pathlib.Path)
    parser.add_argument("--geojson", type=pathlib.Path)
    options = parser.parse_args()
    for path in options.maps:
        occupied, free, unknown = grid(path)
        print(f"{path.name}: {occupied} occupied, {free} free, {unknown} unknown")
        assert occupied > 0 and free > occupied
    print(f"tiles: {tiles(options.tiles, options.points)}")
    space = "{http://www.opengis.net/kml/2.2}"
    lines = xml.etree.ElementTree.parse(options.kml).iter(space + "coordinates")
    places = [text.split(",") for line in lines for text in line.text.split()]
    features = json.loads(options.geojson.read_text())["features"]
    same = [place for feature in features for place in feature["geometry"]["coordinates"]]
    assert len(places) == len(same) > 0
    for kml, geojson in zip(places, same):
        assert all(abs(float(a) - b) < 1e-3 for a, b in zip(kml, geojson)), (kml, geojson)
    print(f"tracks: {len(features)} with {len(same)} places")


if __name__ == "__main__":
    sys.exit(main())
