#!/usr/bin/env python3
"""Holds the table "who may include whom" of docs/architecture.md true.

Usage: check_includes.py ROOT
Prints one line per violation and exits 1 if there is any.
"""
import pathlib
import re
import sys

# Folder -> what its files may include: other folders of ours, and third-party families.
# The longest matching folder counts; a folder may always include itself.
STD_LIKE = {"eigen", "absl"}
ALLOWED = {
    "core": (set(), STD_LIKE),
    "core/codec": ({"core"}, STD_LIKE | {"zstd", "lzf", "openssl"}),
    "floam": ({"core"}, STD_LIKE),
    "storage": ({"core", "core/codec"}, STD_LIKE | {"sqlite", "zstd"}),
    "server/ingest": ({"core", "core/codec", "floam"}, STD_LIKE),
    # An algorithm below the stages, for matching and the pipeline to use; no stage itself.
    "server/pose_graph": ({"core"}, STD_LIKE | {"ceres"}),
    "server/matching": ({"core", "server/pose_graph"}, STD_LIKE | {"pcl", "fftw"}),
    "server/match_graph": ({"core"}, STD_LIKE),
    "server/placement": ({"core", "server/pose_graph"}, STD_LIKE),
    "server/composition": ({"core"}, STD_LIKE | {"octomap"}),
    "server/query": ({"core", "core/codec"}, STD_LIKE),
    "server/pipeline": (
        {"core", "core/codec", "floam", "storage", "server", "server/ingest", "server/matching",
         "server/match_graph", "server/composition", "server/query", "server/pose_graph",
         "server/placement"},
        STD_LIKE,
    ),
    # server/pipeline.h and server/pipeline_options.h.
    "server": (
        {"core", "floam", "storage", "server/matching", "server/placement", "server/composition"},
        STD_LIKE,
    ),
    "server/rpc": ({"api", "core", "core/codec", "server"}, STD_LIKE | {"grpc", "protobuf"}),
    "server/main": (
        {"core", "floam", "storage", "server", "server/rpc", "server/matching",
         "server/placement", "server/composition"},
        STD_LIKE | {"yaml", "spdlog", "cli11"},
    ),
    "client/library": ({"api", "core", "core/codec"}, STD_LIKE | {"grpc", "protobuf"}),
    "client/readers": ({"core", "core/codec"}, STD_LIKE | {"json"}),
    "client/simulation": ({"core", "core/codec"}, STD_LIKE | {"embree"}),
    "client/evaluation": ({"core", "core/codec"}, STD_LIKE | {"png"}),
    "client/examples": ({"core", "core/codec", "client/library"}, STD_LIKE),
    # The offline commands run an embedded server, or an algorithm of it on a file.
    "client/cli": (
        {"core", "core/codec", "floam", "storage", "server", "server/main", "server/pose_graph",
         "server/rpc", "client/library", "client/readers", "client/simulation", "client/evaluation"},
        STD_LIKE | {"json", "cli11"},
    ),
}
# Only .cc files may include these, so that they never reach a neighbour's headers. A header named
# after the library (pcl_cloud.h) may too; it is then itself for .cc files only.
PRIVATE_TO_SOURCES = {"openssl", "ceres", "pcl", "octomap", "sqlite", "zstd", "lzf", "fftw", "embree", "png"}
THIRD_PARTY = [
    ("eigen", re.compile(r"^(Eigen|unsupported/Eigen)/")),
    ("absl", re.compile(r"^absl/")),
    ("ceres", re.compile(r"^ceres/")),
    ("pcl", re.compile(r"^pcl/")),
    ("octomap", re.compile(r"^octomap/")),
    ("sqlite", re.compile(r"^sqlite3")),
    ("zstd", re.compile(r"^zstd|^zdict")),
    ("lzf", re.compile(r"lzf\.h$")),
    ("openssl", re.compile(r"^openssl/")),
    ("fftw", re.compile(r"^fftw3")),
    ("embree", re.compile(r"^embree3/")),
    ("png", re.compile(r"^png\.h$")),
    ("grpc", re.compile(r"^(grpcpp|grpc)/")),
    ("protobuf", re.compile(r"^google/protobuf/")),
    ("yaml", re.compile(r"^yaml-cpp/")),
    ("spdlog", re.compile(r"^spdlog/")),
    ("cli11", re.compile(r"^CLI/")),
    ("json", re.compile(r"^nlohmann/")),
]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
ROOTS = ("core", "floam", "storage", "server", "client")


def folder_of(path):
    """The longest folder of the table that holds the path; None outside the table."""
    parts = path.split("/")[:-1]
    while parts:
        if "/".join(parts) in ALLOWED:
            return "/".join(parts)
        parts.pop()
    return None


def classify(include):
    """('own', folder), ('third', family) or None for the standard library and the system."""
    if include.startswith("isthmus/v1/"):
        return ("own", "api")
    if include.split("/")[0] in ROOTS:
        return ("own", folder_of(include) or include)
    for family, pattern in THIRD_PARTY:
        if pattern.search(include):
            return ("third", family)
    return None


def is_adapter(header):
    """Whether a header of ours includes one of the libraries kept to .cc files."""
    if not header.is_file():
        return False
    includes = (INCLUDE.match(line) for line in header.read_text(encoding="utf-8").splitlines())
    kinds = (classify(found.group(1)) for found in includes if found)
    return any(kind and kind[0] == "third" and kind[1] in PRIVATE_TO_SOURCES for kind in kinds)


def check_file(root, path):
    relative = path.relative_to(root).as_posix()
    folder = folder_of(relative)
    if folder is None:
        return [f"{relative}: no row of the table covers this folder; add one"]
    ours, families = ALLOWED[folder]
    problems = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        found = INCLUDE.match(line)
        what = classify(found.group(1)) if found else None
        if what is None:
            continue
        kind, name = what
        place = f"{relative}:{number}"
        if kind == "own" and name != folder and name not in ours:
            problems.append(f"{place}: {folder} may not include {name}")
        if kind == "third" and name not in families:
            problems.append(f"{place}: {folder} may not include {name}")
        if not path.name.endswith(".h"):
            continue
        if kind == "third" and name in PRIVATE_TO_SOURCES and not path.name.startswith(name):
            problems.append(f"{place}: {name} may be included by .cc files only")
        if kind == "own" and is_adapter(root / found.group(1)):
            problems.append(f"{place}: {found.group(1)} may be included by .cc files only")
    return problems


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [f for top in ROOTS for f in sorted((root / top).rglob("*")) if f.suffix in (".h", ".cc")]
    problems = [problem for f in files for problem in check_file(root, f)]
    print("\n".join(problems) if problems else f"{len(files)} files keep to the table")
    sys.exit(1 if problems or not files else 0)


if __name__ == "__main__":
    main()
