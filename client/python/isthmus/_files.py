"""The part of Client that fetches files: the map, its pose graph, backups."""
from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as np
from crc32c import crc32c

from isthmus import convert
from isthmus._program import run
from isthmus._regions import MapName, map_of
from isthmus.errors import (Aborted, AlreadyExists, DataLoss, InvalidArgument, OutOfRange,
                            ResourceExhausted)
from isthmus.io import write_pcd
from isthmus.link import Link, check_size
from isthmus.records import Backup, BackupContents, BackupState, ExportSummary
from isthmus.v1 import admin_service_pb2, map_service_pb2 as pb

PathLike = Union[str, "os.PathLike[str]"]
_FORMATS = {
    "pcd": pb.ExportMapRequest.PCD_BINARY_COMPRESSED,
    "pcd-compressed": pb.ExportMapRequest.PCD_BINARY_COMPRESSED,
    "pcd-binary": pb.ExportMapRequest.PCD_BINARY,
    "pcd-ascii": pb.ExportMapRequest.PCD_ASCII,
    "ply": pb.ExportMapRequest.PLY,
    "octomap": pb.ExportMapRequest.OCTOMAP_BINARY,
    "bt": pb.ExportMapRequest.OCTOMAP_BINARY,
    "ot": pb.ExportMapRequest.OCTOMAP_FULL,
}
# Formats that the program `isthmus` writes, and the ends of names that they may have.
_BY_PROGRAM = {"las": (".las",), "mcap": (".mcap",), "geojson": (".geojson", ".json"),
               "kml": (".kml",)}
# The end of a name, and the formats that it may be.
_OF_EXTENSION = {".pcd": ("pcd", "pcd-compressed", "pcd-binary", "pcd-ascii"), ".ply": ("ply",),
                 ".bt": ("bt", "octomap"), ".ot": ("ot",),
                 **{end: (name,) for name, ends in _BY_PROGRAM.items() for end in ends}}
_OTHER_WAYS = {".pgm": "export_floors", ".yaml": "export_floors", ".g2o": "export_pose_graph",
               ".png": "`isthmus picture`"}
_NOT_WRITTEN = (".laz", ".e57", ".xyz", ".csv", ".pdf", ".svg")
_WRITTEN_HERE = {"pcd": "binary", "pcd-binary": "binary", "pcd-ascii": "ascii"}


class Files:
    """Part of Client."""

    _link: Link
    query_region: Callable[..., Iterator[Any]]

    def export(self, path: PathLike, format: Optional[str] = None, *, component: MapName = 0,
               resolution: float = 0.0, robots: Union[str, Iterable[str], None] = None,
               progress: Optional[Callable[[int], None]] = None,
               dropped: bool = False) -> ExportSummary:
        """The merged map as a file.

        `format`: "pcd" (compressed), "pcd-binary", "pcd-ascii", "ply", "octomap" or "bt" (free,
        occupied, unknown), "ot" (OctoMap with log-odds); "las", "mcap", "geojson" and "kml", which
        the program `isthmus` writes as it does for docs/cli.md (`Unimplemented` where it is not in
        PATH); without it what the name of the file ends with, and "pcd" where that is none of
        these. `InvalidArgument` where the two contradict each other. `resolution`: thinning of
        clouds, 0 as composed; leaf size of OctoMaps, 0 for 0.2 m. The file is PATH.part until it is
        complete and verified, so that PATH never holds half a map. `progress` receives the bytes so
        far.

        `component`: which map, by the id of any session in it, which goes on naming it, or by its
        number, 0 the largest now. `robots`: only their points. The server has no such files: they
        are queried and written here, so only "pcd", "pcd-binary" (both uncompressed then) and
        "pcd-ascii" go; and those of the program for one robot.

        `dropped`: instead of the map what was measured but is not in it, because other looks went
        through it. Clouds only, and not with `robots`.
        """
        format = _format_of(path, format)
        if dropped and (robots is not None or format in _BY_PROGRAM):
            raise InvalidArgument("what was dropped is exported as a cloud, of all robots together")
        names = None if robots is None else convert.listed(robots)
        if format in _BY_PROGRAM:
            return self._by_program(path, format, component, resolution, names, progress)
        if names is not None:
            return self._export_robots(path, format, component, resolution, names)
        request = pb.ExportMapRequest(format=_FORMATS[format], resolution_m=resolution,
                                      dropped=dropped, **map_of(component))
        return self._to_file(self._link.maps.ExportMap, request, Path(path), progress)

    def export_to_file(self, path: PathLike, format: Optional[str] = None, **options: Any) -> ExportSummary:
        """The C++ library's name of `export`."""
        return self.export(path, format, **options)

    def export_floors(self, path: PathLike, *, component: MapName = 0, resolution: float = 0.0,
                      heights: Optional[Tuple[float, float]] = None) -> List[Path]:
        """Grid maps as Nav2's map_server reads them, a `.yaml` and a `.pgm` per floor, the lowest
        first: PATH_floor0.yaml, ...; the `.yaml` files.

        `resolution`: metres of a cell, 0 for 0.05; `heights`: one map, PATH.yaml, of what lies
        between these heights of the map. The program `isthmus` writes them, see `export`.
        """
        band = [] if heights is None else ["--height-band", *(f"{h:g}" for h in heights)]
        said = run(self._link, "export", "--format", "nav2", "--map", str(component),
                   "--resolution", f"{resolution:g}", *band, "-o", os.fspath(path))
        return [Path(one["file"]) for one in said["maps"]]

    def export_pose_graph(self, path: PathLike, component: MapName = 0) -> ExportSummary:
        """The pose graph of a map as a g2o file, likewise."""
        request = pb.ExportPoseGraphRequest(**map_of(component))
        return self._to_file(self._link.maps.ExportPoseGraph, request, Path(path), None)

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
        shutil.rmtree(part, ignore_errors=True)  # Of a program that died.
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
            file = self._to_file(self._link.admin.BackUp, admin_service_pb2.BackUpRequest(tokens=tokens),
                                 part / "isthmus.db", None, note, 1 << 63)
            if last.tokens:
                with open(part / "tokens", "wb", opener=_private) as token_file:
                    token_file.write(last.tokens)
            part.rename(target)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        return Backup(file, convert.record(BackupContents, last.contents), bool(last.tokens))

    def _to_file(self, method: Callable[..., Any], request: Any, path: Path,
                 progress: Optional[Callable[[int], None]],
                 note: Optional[Callable[[Any], None]] = None,
                 most: Optional[int] = None) -> ExportSummary:
        """Again and again until it is whole; nothing is left where it fails. `note` sees every
        response, and None where it begins anew."""
        part = path.with_name(path.name + ".part")
        most = self._link.max_file_bytes if most is None else most

        def attempt() -> ExportSummary:
            assert most is not None
            with open(part, "wb") as file:
                size, checksum, last = 0, 0, None
                if note is not None:
                    note(None)
                for last in method(request, timeout=self._link.transfer_timeout_s):
                    check_size(size + len(last.data), most)
                    file.write(last.data)
                    size, checksum = size + len(last.data), crc32c(last.data, checksum)
                    if note is not None:
                        note(last)
                    if progress is not None:
                        progress(size)
                file.flush()
                os.fsync(file.fileno())
            return _verified(last, size, checksum)

        try:
            summary: ExportSummary = self._link.repeat(attempt, also_data_loss=True)
            os.replace(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        return summary

    def _by_program(self, path: PathLike, format: str, component: MapName, resolution: float,
                    robots: Optional[List[str]],
                    progress: Optional[Callable[[int], None]]) -> ExportSummary:
        if robots is not None and len(robots) != 1:
            raise InvalidArgument(f"'{format}' is written of one robot or of all, not of "
                                  f"{len(robots)}")
        options = [] if robots is None else ["--robot", robots[0]]
        said = run(self._link, "export", "--format", format, "--map", str(component),
                   "--resolution", f"{resolution:g}", *options, "-o", os.fspath(path))
        checksum, size = 0, 0
        with open(path, "rb") as file:
            while piece := file.read(1 << 20):
                checksum, size = crc32c(piece, checksum), size + len(piece)
        if progress is not None:
            progress(size)
        return ExportSummary(int(said.get("revision", 0)), size, checksum)

    def _export_robots(self, path: PathLike, format: str, component: MapName, resolution: float,
                       robots: Iterable[str]) -> ExportSummary:
        if format not in _WRITTEN_HERE:
            raise InvalidArgument(f"with robots the format is {', '.join(_WRITTEN_HERE)}; not "
                                  f"'{format}'")
        for _ in range(5):  # The map may move between two robots.
            pieces = [(revision, points) for robot in robots for revision, _, points
                      in self.query_region(None, None, robot, component, resolution)]
            revisions = {revision for revision, _ in pieces}
            if len(revisions) <= 1:
                break
        else:
            raise Aborted("the map changes too fast to be read robot by robot")
        if not pieces:
            raise InvalidArgument("no robots are named")
        points = np.concatenate([points for _, points in pieces])
        write_pcd(path, points[["x", "y", "z", "intensity"]], encoding=_WRITTEN_HERE[format])
        data = Path(path).read_bytes()
        return ExportSummary(revisions.pop(), len(data), crc32c(data))


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


def _format_of(path: PathLike, format: Optional[str]) -> str:
    """The one given, or that of the file's name; `InvalidArgument` where they do not agree."""
    extension = Path(path).suffix.lower()
    if extension in _OTHER_WAYS:
        raise InvalidArgument(f"no {extension} is written by export: use {_OTHER_WAYS[extension]}")
    if extension in _NOT_WRITTEN:
        raise InvalidArgument(f"no {extension} is written; {', '.join(_OF_EXTENSION)} are")
    known = [*_FORMATS, *_BY_PROGRAM]
    formats = _OF_EXTENSION.get(extension, tuple(known))
    if format is None:
        return formats[0]
    if format not in known:
        raise InvalidArgument(f"no format is called '{format}': {', '.join(known)} are")
    if format not in formats:
        raise InvalidArgument(f"{os.fspath(path)} is called {extension}, and '{format}' is another "
                              "format: give it the name of what it is")
    return format


def _verified(last: Any, size: int, checksum: int) -> ExportSummary:
    if last is None or not last.last:
        raise DataLoss("the file ended early; run it again")
    if (size, checksum) != (last.size, last.crc32c):
        raise DataLoss(f"the file was damaged on its way: {size} bytes with checksum "
                       f"{checksum:08x} arrived, {last.size} with {last.crc32c:08x} were sent")
    return ExportSummary(int(last.revision), size, checksum)
