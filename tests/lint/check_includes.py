#!/usr/bin/env python3
"""Holds the table "who may include whom" of docs/architecture.md true, and locks to core/concurrency/mutex.h.

Usage: check_includes.py ROOT [--write]
Prints one line per violation and exits 1 if there is any, or if the document shows another table.
--write: writes the table into the document instead.
"""
import pathlib
import re
import sys
import textwrap

# Folder -> what its files may include: other folders of ours, and third-party families.
# The longest matching folder counts; a folder may always include itself.
STD_LIKE = {"eigen", "absl"}
ALLOWED = {
    "core": (set(), STD_LIKE),
    "core/io": ({"core"}, STD_LIKE | {"openssl", "zlib"}),
    "core/command_line": ({"core"}, STD_LIKE | {"cli11"}),
    "core/tls": ({"core/io"}, STD_LIKE | {"openssl"}),
    "core/codec": ({"core", "core/io"}, STD_LIKE | {"draco", "zstd"}),
    "core/formats": ({"core", "core/codec", "core/io"}, STD_LIKE | {"lzf"}),
    "core/floors": ({"core", "core/earth", "core/formats"}, STD_LIKE),
    # The map on the Earth.
    "core/earth": ({"core"}, STD_LIKE | {"geographic", "json"}),
    # Records and messages.
    "api/convert": ({"api", "core", "core/io"}, STD_LIKE | {"protobuf"}),
    "floam": ({"core"}, STD_LIKE),
    "storage": ({"core", "core/codec", "core/io"}, STD_LIKE | {"sqlite", "zstd"}),
    "server/ingest": ({"core", "core/codec", "floam", "server", "storage"}, STD_LIKE),
    # An algorithm below the stages, for matching and the pipeline to use; no stage itself.
    "server/pose_graph": ({"core"}, STD_LIKE | {"ceres"}),
    "server/matching": ({"core", "server/pose_graph"}, STD_LIKE | {"pcl", "fftw"}),
    "server/match_graph": ({"core"}, STD_LIKE),
    "server/placement": ({"core", "server/pose_graph"}, STD_LIKE),
    # An algorithm below the stages, too.
    "server/classes": ({"core"}, STD_LIKE),
    "server/composition": ({"core", "core/io", "server/classes"}, STD_LIKE),
    "server/query": ({"core", "core/formats"}, STD_LIKE),
    # The map's view and its one writer; who works on it; what is asked of it.
    "server/map": ({"core", "server", "server/match_graph", "server/placement", "storage"}, STD_LIKE),
    # Robots that are found in the map, beside those that make it.
    "server/localisation": (
        {"core", "core/codec", "floam", "server", "server/map"}, STD_LIKE),
    "server/jobs": (
        {"core", "core/codec", "server/map", "server/matching", "server/pose_graph", "storage"},
        STD_LIKE,
    ),
    "server/threads": (
        {"core", "core/codec", "core/io", "server", "server/composition", "server/ingest",
         "server/jobs", "server/map", "server/match_graph", "server/matching", "server/placement",
         "storage"},
        STD_LIKE,
    ),
    "server/pipeline": (
        {"core", "core/io", "floam", "server", "server/composition", "server/ingest",
         "server/localisation", "server/map", "server/match_graph", "server/placement", "server/query", "server/threads", "storage"},
        STD_LIKE,
    ),
    # server/pipeline.h and server/pipeline_options.h.
    "server": (
        {"core", "floam", "storage", "server/matching", "server/placement", "server/composition"},
        STD_LIKE,
    ),
    # Rights, and the tokens that carry them.
    "server/access": ({"core", "core/io"}, STD_LIKE),
    # HTTP, for the metrics and the web.
    "server/http": ({"core", "core/io", "core/tls"}, STD_LIKE | {"microhttpd", "gnutls"}),
    # Metrics for Prometheus.
    "server/metrics": ({"core", "core/io", "server", "server/http"}, STD_LIKE | {"prometheus"}),
    "server/rpc": (
        {"api", "api/convert", "core", "core/codec", "core/io", "core/tls", "server",
         "server/access", "server/map"},
        STD_LIKE | {"grpc", "protobuf"},
    ),
    # Browsers: calls go through the channel within the process, what is read for them through the gate.
    "server/web": (
        {"api", "api/convert", "core", "core/earth", "core/floors", "core/formats", "server",
         "server/http", "server/map", "server/rpc"},
        STD_LIKE | {"grpc", "protobuf", "json"},
    ),
    "server/main": (
        {"core", "core/command_line", "core/io", "core/tls", "storage", "server", "server/access",
         "server/metrics", "server/rpc", "server/web"},
        STD_LIKE | {"yaml", "spdlog", "cli11", "json"},
    ),
    "client/library": (
        {"api", "api/convert", "core", "core/codec", "core/io", "core/tls"},
        STD_LIKE | {"grpc", "protobuf"},
    ),
    "client/readers": (
        {"core", "core/codec", "core/formats", "core/io"},
        STD_LIKE | {"json", "bz2", "lz4", "pcap", "sqlite", "yaml", "zstd"},
    ),
    # Clouds with poses into submaps: no server, no connection.
    "client/cloud_upload": (
        {"core", "core/codec", "core/formats", "core/io", "client/readers", "server/pose_graph"},
        STD_LIKE,
    ),
    # Anchors from what GNSS receivers measured.
    "client/georeference": ({"core", "core/earth", "client/readers"}, STD_LIKE),
    # Files for other programs, made of what the server tells.
    "client/exports": (
        {"core", "core/codec", "core/earth", "core/floors", "core/formats", "core/io",
         "client/library"},
        STD_LIKE | {"json", "protobuf"},
    ),
    "client/evaluation": ({"core", "core/io"}, STD_LIKE | {"png"}),
    "client/examples": ({"core/formats", "client/library"}, STD_LIKE),
    # The one place where a client has odometry: for links that do not carry scans.
    "client/follower": ({"core", "core/codec", "floam"}, STD_LIKE),
    # Code that the programs of the command line share.
    "client/console": (
        {"api/convert", "core", "core/codec", "core/command_line", "core/io", "client/cloud_upload",
         "client/follower", "client/library", "client/readers", "server/pose_graph"},
        STD_LIKE | {"json", "cli11", "protobuf"},
    ),
    # Tables, figures and pages, for both.
    "client/report": (
        {"core", "core/formats", "core/io", "client/console", "client/evaluation",
         "client/exports", "client/library", "client/readers"},
        STD_LIKE | {"json", "cli11"},
    ),
    # No server, no store: this is what a robot carries.
    "client/certificates": ({"core/io", "core/tls"}, STD_LIKE | {"openssl"}),
    "client/cli": (
        {"api/convert", "core", "core/command_line", "core/earth", "core/floors", "core/formats",
         "core/io", "core/tls", "client/certificates", "client/cloud_upload", "client/console",
         "client/exports", "client/georeference", "client/library", "client/evaluation",
         "client/readers", "client/report", "server/access"},
        STD_LIKE | {"json", "cli11"},
    ),
    # The bridge to ROS 1.
    "client/ros1": ({"core", "client/library", "client/readers"}, STD_LIKE | {"ros"}),
    # These commands run an embedded server, or an algorithm of it on a file.
    "client/offline": (
        {"api/convert", "core", "core/codec", "core/formats", "core/io", "storage", "server",
         "server/main", "server/pose_graph", "server/rpc", "server/threads", "client/cloud_upload",
         "client/console", "client/library", "client/readers", "client/evaluation",
         "client/report"},
        STD_LIKE | {"json", "cli11"},
    ),
    # Many servers on one database. Nothing above includes it: server/main declares what it opens.
    "fleet/objects": ({"core", "core/io", "storage"}, STD_LIKE | {"curl"}),
    "fleet/postgresql": (
        {"core", "core/codec", "core/io", "fleet/objects", "storage"}, STD_LIKE | {"postgresql"}),
    "fleet/copy": (
        {"core/io", "client/console", "fleet/postgresql", "storage"}, STD_LIKE | {"cli11"}),
    "fleet/server": ({"fleet/objects", "fleet/postgresql", "server/main", "storage"}, STD_LIKE),
    "fleet/worker": (
        {"core", "core/command_line", "fleet/postgresql", "server/jobs", "server/main", "storage"},
        STD_LIKE | {"spdlog", "cli11"},
    ),
    # Experiments. Nothing but tests includes them.
    "lab/simulation": ({"core", "core/codec", "core/formats", "core/io"}, STD_LIKE | {"embree"}),
    "lab/commands": (
        {"core", "core/io", "client/console", "client/evaluation", "client/offline",
         "client/report", "lab/simulation"},
        STD_LIKE | {"cli11"},
    ),
    "lab/loadgen": (
        {"core", "core/codec", "core/command_line", "client/console", "client/library",
         "lab/simulation"},
        STD_LIKE | {"json", "cli11", "grpc"},
    ),
    "lab/bench": (
        {"api/convert", "core", "core/codec", "core/floors", "core/formats", "core/io", "floam", "storage", "server",
         "server/classes", "server/composition", "server/ingest", "server/jobs", "server/matching", "server/placement",
         "server/pose_graph", "server/query", "server/rpc", "server/threads", "server/pipeline", "client/evaluation",
         "client/library", "client/readers", "fleet/postgresql", "lab/simulation"},
        STD_LIKE | {"ceres", "cli11", "json", "octomap", "openssl", "png", "protobuf"},
    ),
}
# A folder's subfolders, from the ground up: each may include those before it, and the folder's own
# files any; what they may include of the folder's own files are its options alone, or in storage,
# which begins with its interface, all.
LEVELS = {
    "floam": ["rings", "state", "scan", "map", "match", "relocalise", "track", ".",
              "localise"],
    "server/matching": ["registration", "search", "prepared", "index", "paper", "pairs", "loops",
                        "asking"],
    "storage": [".", "records", "objects", "archive", "sql", "sqlite", "upkeep"],
    "client/library": ["spool", "stream", "."],
}
# Beside a folder's options, what its subfolders may include of its own files.
BASES = {f"client/library/{name}.h" for name in ("convert", "options", "records")}
# Only .cc files may include these, so that they never reach a neighbour's headers. A header named
# after the library (pcl_cloud.h) may too; it is then itself for .cc files only.
PRIVATE_TO_SOURCES = {"openssl", "ceres", "pcl", "octomap", "curl", "postgresql", "sqlite", "zstd", "draco", "lzf", "bz2", "lz4", "zlib",
                      "fftw", "embree", "pcap", "png", "geographic", "prometheus", "microhttpd", "gnutls"}
THIRD_PARTY = [
    ("eigen", re.compile(r"^(Eigen|unsupported/Eigen)/")),
    ("absl", re.compile(r"^absl/")),
    ("ceres", re.compile(r"^ceres/")),
    ("pcl", re.compile(r"^pcl/")),
    ("octomap", re.compile(r"^octomap/")),
    ("sqlite", re.compile(r"^sqlite3")),
    ("curl", re.compile(r"^curl/")),
    ("postgresql", re.compile(r"^libpq-fe\.h$")),
    ("zstd", re.compile(r"^zstd|^zdict")),
    ("draco", re.compile(r"^draco/")),
    ("lzf", re.compile(r"lzf\.h$")),
    ("bz2", re.compile(r"^bzlib\.h$")),
    ("zlib", re.compile(r"^zlib\.h$")),
    ("lz4", re.compile(r"^lz4")),
    ("openssl", re.compile(r"^openssl/")),
    ("fftw", re.compile(r"^fftw3")),
    ("embree", re.compile(r"^embree3/")),
    ("geographic", re.compile(r"^GeographicLib/")),
    ("png", re.compile(r"^png\.h$")),
    ("pcap", re.compile(r"^pcap(\.h$|/)")),
    ("prometheus", re.compile(r"^prometheus/")),
    ("microhttpd", re.compile(r"^microhttpd\.h$")),
    ("gnutls", re.compile(r"^gnutls/")),
    ("grpc", re.compile(r"^(grpcpp|grpc)/")),
    ("protobuf", re.compile(r"^google/protobuf/")),
    ("yaml", re.compile(r"^yaml-cpp/")),
    ("spdlog", re.compile(r"^spdlog/")),
    ("cli11", re.compile(r"^CLI/")),
    ("json", re.compile(r"^nlohmann/")),
    ("ros", re.compile(r"^(ros|tf2|tf2_ros|\w+_msgs)/")),
]
NAMES = {
    "ceres": "Ceres", "pcl": "PCL", "octomap": "OctoMap", "sqlite": "SQLite", "curl": "libcurl", "postgresql": "libpq", "zstd": "zstd",
    "draco": "Draco",
    "lzf": "lzf", "bz2": "bzip2", "lz4": "LZ4", "zlib": "zlib", "openssl": "OpenSSL", "fftw": "FFTW",
    "embree": "Embree", "png": "libpng", "pcap": "libpcap", "geographic": "GeographicLib",
    "prometheus": "prometheus-cpp", "microhttpd": "libmicrohttpd", "gnutls": "GnuTLS", "grpc": "gRPC", "protobuf": "Protobuf", "yaml": "yaml-cpp", "spdlog": "spdlog",
    "cli11": "CLI11", "json": "nlohmann-json", "ros": "ROS",
}
# Locks that scripts/check-locks cannot check, or that ThreadSanitizer does not see.
UNCHECKED_LOCK = re.compile(r"^(mutex|shared_mutex|condition_variable|absl/synchronization/.*)$")
MAY_LOCK_UNCHECKED = {"core/concurrency/mutex.h"}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
ROOTS = ("core", "api", "floam", "storage", "server", "client", "fleet", "lab")


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
    # As a user of the installed library includes it.
    include = re.sub("^isthmus/client/", "client/library/", re.sub("^isthmus/core/", "core/", include))
    if include.split("/")[0] in ROOTS:
        return ("own", folder_of(include) or include)
    for family, pattern in THIRD_PARTY:
        if pattern.search(include):
            return ("third", family)
    return None


def breaks_levels(folder, path, include):
    """Whether `include` lies on a higher level of the folder than the file that includes it."""
    levels = LEVELS.get(folder)
    if levels is None or include.endswith("_options.h") or include in BASES:
        return False

    def level(file):
        inside = file[len(folder) + 1:].split("/")
        return levels.index(inside[0] if len(inside) > 1 else ".")

    return level(include) > level(path)


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
        if found and UNCHECKED_LOCK.match(found.group(1)) and not {relative, folder} & MAY_LOCK_UNCHECKED:
            problems.append(f"{relative}:{number}: {folder} may not include <{found.group(1)}>, but core/concurrency/mutex.h")
        what = classify(found.group(1)) if found else None
        if what is None:
            continue
        kind, name = what
        place = f"{relative}:{number}"
        if kind == "own" and name != folder and name not in ours:
            problems.append(f"{place}: {folder} may not include {name}")
        if kind == "own" and name == folder and breaks_levels(folder, relative, found.group(1)):
            problems.append(f"{place}: {found.group(1)} lies on a higher level of {folder}")
        if kind == "third" and name not in families:
            problems.append(f"{place}: {folder} may not include {name}")
        if not path.name.endswith(".h"):
            continue
        if kind == "third" and name in PRIVATE_TO_SOURCES and not path.name.startswith(name):
            problems.append(f"{place}: {name} may be included by .cc files only")
        if kind == "own" and is_adapter(root / found.group(1)):
            problems.append(f"{place}: {found.group(1)} may be included by .cc files only")
    return problems


def table():
    """The table as Markdown."""
    lines = ["| folder | of ours | third party |", "|---|---|---|"]
    for folder, (ours, families) in ALLOWED.items():
        third = ", ".join(sorted((NAMES[f] for f in families - STD_LIKE), key=str.lower))
        lines.append(f"| `{folder}/` | {', '.join(sorted(ours))} | {third} |")
    for folder, levels in LEVELS.items():
        steps = ", ".join("its own files" if step == "." else f"`{step}/`" for step in levels)
        inside = f"Inside `{folder}/`, each may include those before it: {steps}."
        lines += ["", textwrap.fill(inside, 100, break_long_words=False, break_on_hyphens=False)]
    return "\n".join(lines)


def check_document(root, write):
    """Problems of the table in the document; none where there is no document."""
    document = root / "docs" / "architecture.md"
    if not document.is_file():
        return []
    begin, end = "<!-- from tests/lint/check_includes.py -->\n", "\n<!-- end -->"
    text = document.read_text(encoding="utf-8")
    before, rest = text.split(begin)
    shown, after = rest.split(end)
    if write:
        document.write_text(before + begin + table() + end + after, encoding="utf-8")
    elif shown != table():
        return ["docs/architecture.md: shows another table; run tests/lint/check_includes.py . --write"]
    return []


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [f for top in ROOTS for f in sorted((root / top).rglob("*")) if f.suffix in (".h", ".cc")]
    problems = [problem for f in files for problem in check_file(root, f)]
    problems += check_document(root, write="--write" in sys.argv[2:])
    print("\n".join(problems) if problems else f"{len(files)} files keep to the table")
    sys.exit(1 if problems or not files else 0)


if __name__ == "__main__":
    main()
