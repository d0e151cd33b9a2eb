#!/usr/bin/env python3
"""Holds every place that names the version of Isthmus to the newest one in CHANGELOG.md.

Usage: check_version.py ROOT
Prints one line per place that names another version, or none, and exits 1 if there is any.
"""
import pathlib
import re
import sys

NEWEST = re.compile(r"^## \[(\d+\.\d+\.\d+)\] - \d{4}-\d\d-\d\d$", re.MULTILINE)
PLACES = {
    "CMakeLists.txt": re.compile(r"project\(isthmus VERSION (\S+)"),
    "client/python/isthmus/version.py": re.compile(r'VERSION = "(\S+)"'),
    "client/ros1/package.xml": re.compile(r"<version>(\S+)</version>"),
}


def first(pattern, path):
    """The version that the file names first; None if it names none, or is missing."""
    found = pattern.search(path.read_text(encoding="utf-8")) if path.exists() else None
    return found.group(1) if found else None


def main():
    root = pathlib.Path(sys.argv[1])
    newest = first(NEWEST, root / "CHANGELOG.md")
    others = {place: first(pattern, root / place) for place, pattern in PLACES.items()}
    problems = [
        f"{place}: version {version}, not {newest} as in CHANGELOG.md"
        for place, version in others.items()
        if version != newest or newest is None
    ]
    print("\n".join(problems) if problems else f"all name version {newest}")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
