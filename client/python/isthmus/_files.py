"""The part of Client that fetches files: the map, its pose graph, backups."""
from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from crc32c import crc32c

from isthmus import convert
from isthmus._arguments import listed, number, numbers, request, text, wrong
from isthmus._program import run
from isthmus._regions import Corridor, MapName, OrientedBox, Polygon, map_of, put_region
from isthmus.errors import (Aborted, AlreadyExists, DataLoss, InvalidArgument, OutOfRange,
                            ResourceExhausted)
from isthmus.io.pcd import pcd_bytes
from isthmus.io.whole import PathLike, WholeFile, naming
from isthmus.link import Link, check_size
from isthmus.records import Backup, BackupState, ExportSummary
from isthmus.v1 import admin_service_pb2, map_service_pb2 as pb
from isthmus.v1.records import BackupContents

_FORMATS = {
    "pcd": pb.ExportMapRequest.PCD_BINARY_COMPRESSED,
    "pcd-compressed": pb.ExportMapRequest.PCD_BINARY_COMPRESSED,
    "pcd-binary": pb.ExportMapRequest.PCD_BINARY,
    "pcd-ascii": pb.ExportMapRequest.PCD_ASCII,
    "ply": pb.ExportMapRequest.PLY,
    "bt": pb.ExportMapRequest.OCTOMAP_BINARY,
    "octomap": pb.ExportMapRequest.OCTOMAP_BINARY,
    "ot": pb.ExportMapRequest.OCTOMAP_FULL,
}
_BY_PROGRAM = ("las", "mcap", "geojson", "kml")  # Formats that the program `isthmus` writes.
# The ends of names that files of each format may have; the first format of an end is what it tells.
_ENDS = {**{name: (f".{name.partition('-')[0]}",) for name in (*_FORMATS, *_BY_PROGRAM)},
         "octomap": (".bt",), "geojson": (".geojson", ".json")}
_OTHER_WAYS = {".pgm": "export_floors", ".yaml": "export_floors", ".g2o": "export_pose_graph",
               ".png": "`isthmus picture`"}
_WRITTEN_HERE = {"pcd": "binary", "pcd-binary": "binary", "pcd-ascii": "ascii"}


_Region = Tuple[Any, Any, Any]  # A box, a sphere or a shape.


class Files:
    """Part of Client."""

    _link: Link
    query_region: Callable[..., Iterator[Any]]

    def export(self, path: PathLike, format: Optional[str] = None, *, component: MapName = 0,
               resolution: float = 0.0, robots: Union[str, Iterable[str], None] = None,
               progress: Optional[Callable[[int], None]] = None, dropped: bool = False,
               box: Optional[Sequence[Sequence[float]]] = None,
               sphere: Optional[Tuple[Sequence[float], float]] = None,
               shape: Union[OrientedBox, Polygon, Corridor, None] = None) -> ExportSummary:
        """The merged map as a file.

        `format`: "pcd" (compressed), "pcd-binary", "pcd-ascii", "ply", "octomap" or "bt" (free,
        occupied, unknown), "ot" (OctoMap with log-odds); "las", "mcap", "geojson" and "kml", which
        the program `isthmus` writes as it does for docs/cli.md (`Unimplemented` where it is not in
        PATH); without it what the name of the file ends with. `InvalidArgument` where the name ends
        with something else, or tells no format and none is given. `resolution`: thinning of
        clouds, 0 as composed; leaf size of OctoMaps, 0 for 0.2 m. The file is PATH.part until it is
        complete and verified, so that PATH never holds half a map. `progress` receives the bytes so
        far.

        `component`: which map, by the id of any session in it, which goes on naming it, or by its
        number, 0 the largest now. `box`, `sphere`, `shape`: as in `query`; no shape of what the
        program writes, and no part at all of "geojson" and "kml". `robots`: only what they saw, one
        of them or several; several are queried and written here, so that only "pcd", "pcd-binary"
        (both uncompressed then) and "pcd-ascii" go.

        `dropped`: instead of the map what was measured but is not in it, because other looks went
        through it. Clouds only, and not with `robots`.
        """
        format = _format_of(path, format)
        if dropped and (robots is not None or format in _BY_PROGRAM):
            raise InvalidArgument("what was dropped is exported as a cloud, of all robots together")
        names = [""] if robots is None else listed("robots", robots)
        if not names:
            raise InvalidArgument("no robots are named")
        region = (box, sphere, shape)
        if format in _BY_PROGRAM:
            return self._by_program(path, format, component, resolution, names, region, progress)
        if len(names) > 1:
            return self._export_robots(path, format, component, resolution, names, region)
        asked = request(pb.ExportMapRequest, format=_FORMATS[format], resolution_m=resolution,
                        dropped=dropped, robot=names[0], **map_of(component))
        put_region(asked, *region)
        return self._to_file(self._link.maps.ExportMap, asked, path, progress)

    def export_to_file(self, path: PathLike, format: Optional[str] = None, **options: Any) -> ExportSummary:
        """The C++ library's name of `export`."""
        return self.export(path, format, **options)

    def export_floors(self, path: PathLike, *, component: MapName = 0, resolution: float = 0.0,
                      heights: Optional[Tuple[float, float]] = None,
                      box: Optional[Sequence[Sequence[float]]] = None) -> List[Path]:
        """Grid maps as Nav2's map_server reads them, a `.yaml` and a `.pgm` per floor, the lowest
        first: PATH_floor0.yaml, ...; the `.yaml` files. PATH_floor0_rooms.geojson, ... have the
        rooms.

        `resolution`: metres of a cell, 0 for 0.05; `heights`: one map, PATH.yaml, of what lies
        between these heights of the map; `box`: two corners, as in `query`. The program `isthmus`
        writes them, see `export`.
        """
        band = [] if heights is None else ["--height-band", *numbers(
            "heights", heights, (2,), "the lowest and the highest").astype(str)]
        said = run(self._link, "export", "--format", "nav2", *_map_options(component, resolution),
                   *_region_options("nav2", (box, None, None)), *band, "-o", os.fspath(path))
        return [Path(one["file"]) for one in said["maps"]]

    def export_pose_graph(self, path: PathLike, component: MapName = 0) -> ExportSummary:
        """The pose graph of a map as a g2o file, likewise: PATH ends with .g2o, or with nothing."""
        _check_name(path, (".g2o",))
        asked = request(pb.ExportPoseGraphRequest, **map_of(component))
        return self._to_file(self._link.maps.ExportPoseGraph, asked, path, None)

    def back_up(self, folder: PathLike,
                progress: Optional[Callable[[BackupState], None]] = None, *,
                tokens: bool = False) -> Backup:
        """A copy of all that the server stores, as of one moment, while robots and readers go on:
        into the new folder `folder`, which isthmus-server can serve. It is FOLDER.part until it is
        complete. `tokens`: with the server's tokens, where it has any; a folder without tokens is
        open to whoever reaches the server that serves it. `AlreadyExists` when there is a
        `folder`."""
        target, part = Path(folder), Path(f"{os.fspath(folder)}.part")
        if target.exists():
            raise AlreadyExists(f"{target} exists already; a backup makes its own folder")
        shutil.rmtree(part, ignore_errors=True)  # A program that died may have left it.
        with naming(target):
            part.mkdir(parents=True)
        last: Any = None
        state = BackupState(0.0, 0, 0)

        def note(response: Any) -> None:
            nonlocal last, state
            last = response
            if response is None:
                state = BackupState(0.0, 0, 0)
                return
            state = BackupState(max(state.copied, response.copied),
                                state.bytes + len(response.data),
                                max(state.total_bytes, response.total_bytes))
            _check_backup(state, part)
            if progress is not None:
                progress(state)

        try:
            file = self._to_file(self._link.admin.BackUp,
                                 request(admin_service_pb2.BackUpRequest, tokens=tokens),
                                 part / "isthmus.db", None, note, 1 << 63, called=target)
            with naming(target):
                if last.tokens:
                    with open(part / "tokens", "wb", opener=_private) as token_file:
                        token_file.write(last.tokens)
                part.rename(target)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        return Backup(file, convert.record(BackupContents, last.contents), bool(last.tokens))

    def _to_file(self, method: Callable[..., Any], asked: Any, path: PathLike,
                 progress: Optional[Callable[[int], None]],
                 note: Optional[Callable[[Any], None]] = None,
                 most: Optional[int] = None, called: Optional[PathLike] = None) -> ExportSummary:
        """Again and again until it is whole; nothing is left where it fails. `note` sees every
        response, and None where it begins anew. `called`: see WholeFile."""
        most = self._link.max_file_bytes if most is None else most

        def attempt() -> ExportSummary:
            assert most is not None
            file.begin()
            size, checksum, last = 0, 0, None
            if note is not None:
                note(None)
            for last in method(asked, timeout=self._link.transfer_timeout_s):
                check_size(size + len(last.data), most)
                file.write(last.data)
                size, checksum = size + len(last.data), crc32c(last.data, checksum)
                if note is not None:
                    note(last)
                if progress is not None:
                    progress(size)
            return _verified(last, size, checksum)

        with WholeFile(path, called) as file:
            summary: ExportSummary = self._link.repeat(attempt, also_data_loss=True)
            file.finish()
        return summary

    def _by_program(self, path: PathLike, format: str, component: MapName, resolution: float,
                    robots: List[str], region: _Region,
                    progress: Optional[Callable[[int], None]]) -> ExportSummary:
        if len(robots) != 1:
            raise InvalidArgument(f"'{format}' is written of one robot or of all, not of "
                                  f"{len(robots)}")
        options = ["--robot", text("a robot", robots[0])] if robots[0] else []
        said = run(self._link, "export", "--format", format, *_map_options(component, resolution),
                   *_region_options(format, region), *options, "-o", os.fspath(path))
        checksum, size = 0, 0
        with open(path, "rb") as file:
            while piece := file.read(1 << 20):
                checksum, size = crc32c(piece, checksum), size + len(piece)
        if progress is not None:
            progress(size)
        return ExportSummary(int(said.get("revision", 0)), size, checksum)

    def _export_robots(self, path: PathLike, format: str, component: MapName, resolution: float,
                       robots: List[str], region: _Region) -> ExportSummary:
        if format not in _WRITTEN_HERE:
            raise InvalidArgument(f"with several robots the format is {', '.join(_WRITTEN_HERE)}; "
                                  f"not '{format}'")
        box, sphere, shape = region
        with WholeFile(path) as file:
            for _ in range(5):  # The map may move between two robots.
                pieces = [(revision, points) for robot in robots for revision, _, points
                          in self.query_region(box, sphere, robot, component, resolution,
                                               shape=shape)]
                revisions = {revision for revision, _ in pieces}
                if len(revisions) <= 1:
                    break
            else:
                raise Aborted("the map changes too fast to be read robot by robot")
            points = np.concatenate([points for _, points in pieces])
            data = pcd_bytes(points[["x", "y", "z", "intensity"]], _WRITTEN_HERE[format])
            file.write(data)
            file.finish()
        return ExportSummary(revisions.pop(), len(data), crc32c(data))


def _map_options(component: MapName, resolution: float) -> List[str]:
    """What tells the program which map, and how fine."""
    named = map_of(component)
    return ["--map", str(named.get("map", component)),
            "--resolution", repr(number("resolution", resolution, 0))]


def _region_options(format: str, region: _Region) -> List[str]:
    """What tells the program which part of the map."""
    box, sphere, shape = region
    part = pb.QueryRegionRequest()
    put_region(part, box, sphere, shape)
    if format in ("geojson", "kml") and any(one is not None for one in region):
        raise InvalidArgument(f"'{format}' has whole ways: leave the part of the map out")
    if shape is not None:
        raise InvalidArgument(f"'{format}' is written of a box or a sphere, not of a shape")
    if box is not None:
        ends = [part.box.min, part.box.max]
        return ["--box=" + ",".join(repr(c) for end in ends for c in (end.x, end.y, end.z))]
    if sphere is not None:
        at = part.sphere.center
        return ["--sphere=" + ",".join(map(repr, (at.x, at.y, at.z, part.sphere.radius_m)))]
    return []


def _private(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)


def _check_backup(state: BackupState, folder: Path) -> None:
    """What comes is as long as was announced, and the disk has room for the rest of it."""
    if state.bytes > state.total_bytes:
        raise OutOfRange(f"more came than the {state.total_bytes} bytes that the server announced: "
                         "it is not sound")
    free = shutil.disk_usage(folder).free
    if state.total_bytes - state.bytes > free:
        raise ResourceExhausted(f"the backup has {state.total_bytes} bytes, of which the disk of "
                                f"{folder} has room for {state.bytes + free}")


def _extension(path: PathLike) -> str:
    """In small letters; empty where there is none, or has no letter: the end of a date, for one."""
    end = Path(path).suffix.lower()
    return end if any(map(str.isalpha, end)) else ""


def _check_name(path: PathLike, ends: Sequence[str]) -> None:
    """An extension tells what is in a file, so it must be true."""
    end = _extension(path)
    if end and end not in ends:
        other = f"; {end} files are of {_OTHER_WAYS[end]}" if end in _OTHER_WAYS else ""
        raise InvalidArgument(f"{os.fspath(path)} would not hold what {end} files do: give it a "
                              f"name in {' or '.join(ends)}, or with no extension{other}")


def _format_of(path: PathLike, format: Optional[str]) -> str:
    """The one given, or that of the file's name; `InvalidArgument` where they do not agree."""
    if format is None:
        end = _extension(path)
        format = next((name for name, ends in _ENDS.items() if end in ends), None)
    if format is None:
        other = f"{end} files are of {_OTHER_WAYS[end]}; " if end in _OTHER_WAYS else ""
        raise InvalidArgument(f"the name {os.fspath(path)} does not tell the format: {other}give "
                              f"`format`, which is {', '.join(_ENDS)}")
    if format not in tuple(_ENDS):  # May not be hashable.
        raise wrong("format", ", ".join(_ENDS), format)
    _check_name(path, _ENDS[format])
    return format


def _verified(last: Any, size: int, checksum: int) -> ExportSummary:
    if last is None or not last.last:
        raise DataLoss("the file ended early; run it again")
    if (size, checksum) != (last.size, last.crc32c):
        raise DataLoss(f"the file was damaged on its way: {size} bytes with checksum "
                       f"{checksum:08x} arrived, {last.size} with {last.crc32c:08x} were sent")
    return ExportSummary(int(last.revision), size, checksum)
