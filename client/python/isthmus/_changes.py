"""The part of Client that reads what came and went between an earlier state of the map and now."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Iterator, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from isthmus import convert
from isthmus._arguments import request
from isthmus._regions import Corridor, MapName, OrientedBox, Polygon, map_of, put_region
from isthmus.errors import InvalidArgument
from isthmus.link import Link
from isthmus.times import Moment, Utc, to_ns
from isthmus.v1 import map_service_pb2 as pb


@dataclass(frozen=True)
class ChangedVolume:
    """Something that stands there now and did not (`came`), or did and does not any more."""

    came: bool
    box: OrientedBox  # Upright, around what was seen of it.
    points: int  # Voxels of 0.1 m in which it was seen.
    probability: float
    seen_first_ns: int
    seen_last_ns: int
    # A time at which it was not there: the first after `seen_last` if it went, the last before
    # `seen_first` if it came.
    missing_ns: int
    seen_by: Tuple[str, ...]  # Robots.
    missed_by: Tuple[str, ...]
    places: NDArray[np.float32] = field(compare=False)  # (N, 3); N is 0 unless asked for.
    seen_first = Utc()
    seen_last = Utc()
    missing = Utc()


@dataclass(frozen=True)
class ChangeList:
    """What came and went, the largest first."""

    revision: int
    submaps_before: int
    submaps_after: int
    left_out: int
    volumes: Tuple[ChangedVolume, ...]

    def __iter__(self) -> Iterator[ChangedVolume]:
        return iter(self.volumes)

    def __len__(self) -> int:
        return len(self.volumes)


class Changes:
    """Part of Client."""

    _link: Link

    def find_changes(self, *, since_ns: Optional[Moment] = None, since_revision: Optional[int] = None,
                     box: Optional[Sequence[Sequence[float]]] = None,
                     sphere: Optional[Tuple[Sequence[float], float]] = None,
                     shape: Union[OrientedBox, Polygon, Corridor, None] = None,
                     component: MapName = 0, smallest_m: float = 0.3, max_volumes: int = 1000,
                     include_points: bool = False) -> ChangeList:
        """The volumes that came and went since a time, or since a revision.

        `since_ns`: what was scanned before it is compared with what was scanned since.
        `since_revision`: what was in the map at that revision with what came into it later. `box`,
        `sphere`, `shape`: as in `query`. `smallest_m`: of a volume's longest edge.
        `FailedPrecondition` when nothing lies on one of the sides.
        """
        if (since_ns is None) == (since_revision is None):
            raise InvalidArgument("give since_ns or since_revision")
        since = None if since_ns is None else to_ns(since_ns, "since_ns")
        asked = request(pb.FindChangesRequest, since_ns=since, since_revision=since_revision,
                        smallest_m=smallest_m, max_volumes=max_volumes,
                        include_points=include_points, **map_of(component))
        put_region(asked, box, sphere, shape)
        parts = self._link.collect(self._link.maps.FindChanges, asked)
        head = parts[0]
        return ChangeList(int(head.revision), int(head.submaps_before), int(head.submaps_after),
                          int(head.left_out),
                          tuple(_volume(volume) for part in parts for volume in part.volumes))


def _volume(message: Any) -> ChangedVolume:
    size = message.box.size
    box = OrientedBox(convert.pose_from(message.box.t_map_box), (size.x, size.y, size.z))
    places = np.array(message.places, dtype=np.float32).reshape(-1, 3)
    return ChangedVolume(message.kind == pb.ChangedVolume.CAME, box, message.points,
                         message.probability, message.seen_first_ns, message.seen_last_ns,
                         message.missing_ns, tuple(message.seen_by), tuple(message.missed_by),
                         places)
