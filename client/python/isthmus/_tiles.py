"""The part of Client that reads the merged map tile by tile, and watches it change."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Tuple

import grpc
import numpy as np

from isthmus import cloud, convert
from isthmus._arguments import request, wrong
from isthmus._regions import MapName, map_of
from isthmus.errors import NotFound, Unavailable, from_rpc
from isthmus.link import Link
from isthmus._basics import Box
from isthmus.v1 import map_service_pb2 as pb
from isthmus.v1.records import Match, RobotPlace, SubmapPlace

TILE_POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"),
                       ("robot", "<u4"), ("label", "<u4"), ("last_seen", "<u4")])


class TileId(NamedTuple):
    """A square of a component's map, `tile_m * 2 ** level` wide, unbounded in height."""

    component: int
    level: int
    x: int
    y: int


@dataclass(frozen=True)
class TileInfo:
    """A tile without its points. Tiles of one version hold the same points."""

    id: TileId
    version: int
    revision: int  # The first one with this version since the server started.
    points: int  # Above level 0 the most that it may have.
    bounds: Optional[Box]  # The box around the points.


@dataclass(frozen=True)
class Tile:
    """A tile's points, exactly as the map has them; None where they are those at hand."""

    revision: int
    info: TileInfo
    robots: Tuple[str, ...]  # The field `robot` of the points indexes them.
    points: Optional[cloud.Records] = field(compare=False)


@dataclass
class MapStep:
    """A map, and what is new in it since the step before."""

    revision: int = 0
    run: int = 0  # Revisions of another run say nothing of what has changed.
    restart: bool = False  # Forget all earlier steps: this one holds everything.
    tiles: List[TileInfo] = field(default_factory=list)
    removed_tiles: List[TileId] = field(default_factory=list)
    submaps: List[SubmapPlace] = field(default_factory=list)
    matches: List[Match] = field(default_factory=list)
    removed_matches: List[Tuple[str, str]] = field(default_factory=list)
    robots: Optional[List[RobotPlace]] = None  # None where nothing is told of them.


class Tiles:
    """Part of Client."""

    _link: Link

    def list_tiles(self, component: MapName = 0, level: int = 0) -> List[TileInfo]:
        """The tiles of a map at a level of detail, in order of x, then y."""
        asked = request(pb.ListTilesRequest, level=level, **map_of(component))
        parts = self._link.collect(self._link.maps.ListTiles, asked)
        return [_info(tile) for part in parts for tile in part.tiles]

    def get_tile(self, tile: TileId, have_version: int = 0) -> Tile:
        """The points of a tile as the map is now; without them where it is of `have_version`."""
        if not isinstance(tile, TileId):
            raise wrong("tile", "an isthmus.TileId", tile)
        asked = request(pb.GetTileRequest, id=request(pb.TileId, **tile._asdict()),
                        have_version=have_version, form=pb.GetTileRequest.CLOUD)
        parts = self._link.collect(self._link.maps.GetTile, asked)
        head = parts[0]
        points: Optional[cloud.Records] = None
        if not head.not_modified:
            points = np.concatenate([np.zeros(0, TILE_POINT)] + [
                cloud.from_message(part.cloud) for part in parts if part.cloud.data])
        return Tile(head.revision, _info(head.info), tuple(head.robots), points)

    def watch_map(self, level: int = 0, since: Optional[MapStep] = None) -> Iterator[MapStep]:
        """The map as it changes: at once what is new since the step `since` (None: all there is),
        then each change of the map and of where robots are, twice a second at most. While the
        caller is busy changes add up to one step. Goes on over a connection that was lost, until it
        is closed or the server does not answer any more (`Unavailable`)."""
        if since is not None and not isinstance(since, MapStep):
            raise wrong("since", "an isthmus.MapStep that came before, or None", since)
        asked = request(pb.WatchMapRequest, level=level)
        if since is not None:
            asked.from_revision, asked.run = since.revision, since.run
        backoff = self._link.backoff()
        while True:
            call = self._link.once(lambda: self._link.maps.WatchMap(asked))
            try:
                step = MapStep()
                for part in call:
                    backoff.reset()
                    _add(part, step)
                    if part.more:
                        continue
                    asked.from_revision, asked.run = step.revision, step.run
                    yield step
                    step = MapStep()
                continue
            except grpc.RpcError as lost:
                error = from_rpc(lost)
            finally:
                call.cancel()
            if not isinstance(error, Unavailable):
                raise error
            delay = backoff.next()
            if delay is None or self._link.closed.wait(delay):
                raise self._link.explain(error)

    def mirror_map(self, level: int = 0) -> Iterator[Dict[TileId, Tile]]:
        """All tiles of the map, kept up to date: the same dictionary again whenever it is exactly
        the server's map of a revision that brought something new. Asks for what changed alone."""
        held: Dict[TileId, Tile] = {}
        told: Dict[TileId, int] = {}
        for step in self.watch_map(level):
            if step.restart:
                told.clear()
            for gone in step.removed_tiles:
                told.pop(gone, None)
            told.update((tile.id, tile.version) for tile in step.tiles)
            for gone in held.keys() - told.keys():
                del held[gone]
            exact = True
            for tile, version in told.items():
                if tile in held and held[tile].info.version == version:
                    continue
                try:
                    held[tile] = self.get_tile(tile)
                except NotFound:  # Gone by now; another step tells of it.
                    exact = False
                    continue
                exact = exact and held[tile].info.version == version
            if exact and (step.restart or step.tiles or step.removed_tiles):
                yield held


def _id(message: Any) -> TileId:
    return TileId(message.component, message.level, message.x, message.y)


def _info(message: Any) -> TileInfo:
    bounds = convert.record(Box, message.bounds) if message.HasField("bounds") else None
    return TileInfo(_id(message.id), message.version, message.revision, message.points, bounds)


def _add(part: Any, step: MapStep) -> None:
    """What a response tells, to the step that it is a part of."""
    step.revision, step.run = part.revision, part.run
    step.restart = step.restart or part.restart
    step.tiles.extend(_info(tile) for tile in part.tiles)
    step.removed_tiles.extend(_id(tile) for tile in part.removed_tiles)
    step.submaps.extend(convert.record(SubmapPlace, place) for place in part.submaps)
    step.matches.extend(convert.record(Match, match) for match in part.matches)
    step.removed_matches.extend((pair.session_a, pair.session_b) for pair in part.removed_matches)
    if part.has_robots:
        step.robots = (step.robots or []) + [convert.record(RobotPlace, place)
                                             for place in part.robots]
