"""Requests for parts of the merged map. Private to the package."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Optional, Sequence, Tuple, Union

from isthmus import convert
from isthmus.errors import InvalidArgument
from isthmus.pose import Pose
from isthmus.v1 import map_service_pb2 as pb, types_pb2

MapName = Union[int, str]  # A number, or a session in the map.
Heights = Tuple[Optional[float], Optional[float]]


@dataclass(frozen=True)
class OrientedBox:
    """A box that stands askew: the pose of its middle in the map, and its whole edges in metres."""

    T_map_box: Pose
    size: Sequence[float]


@dataclass(frozen=True)
class Polygon:
    """An upright prism over corners (x, y), which are joined in order; heights are the map's."""

    corners: Sequence[Sequence[float]]
    heights: Heights = (None, None)  # None: open.


@dataclass(frozen=True)
class Corridor:
    """What lies along a path of (x, y, z), `width` wide in all; heights are relative to it."""

    path: Sequence[Sequence[float]]
    width: float
    heights: Heights = (None, None)


def map_of(component: MapName) -> Dict[str, Any]:
    """The fields of a request that name a map."""
    return {"map": component} if isinstance(component, str) else {"component": component}


def region_request(box: Optional[Sequence[Sequence[float]]],
                   sphere: Optional[Tuple[Sequence[float], float]], shape: Any,
                   **others: Any) -> pb.QueryRegionRequest:
    """`others` are further fields of the request. One part of the map at most can be named."""
    request = pb.QueryRegionRequest(**others)
    if sum(part is not None for part in (box, sphere, shape)) > 1:
        raise InvalidArgument("give a box, a sphere or a shape, not several")
    if box is not None:
        low, high = box
        request.box.CopyFrom(types_pb2.Box(min=convert.vector_to(low),
                                           max=convert.vector_to(high)))
    if sphere is not None:
        request.sphere.CopyFrom(types_pb2.Sphere(center=convert.vector_to(sphere[0]),
                                                 radius_m=float(sphere[1])))
    if isinstance(shape, OrientedBox):
        request.oriented_box.CopyFrom(pb.OrientedBox(t_map_box=convert.pose_to(shape.T_map_box),
                                                     size=convert.vector_to(shape.size)))
    elif isinstance(shape, Polygon):
        request.polygon.CopyFrom(pb.Polygon(
            corners=[pb.Polygon.Corner(x=float(x), y=float(y)) for x, y in shape.corners],
            heights=_band(shape.heights)))
    elif isinstance(shape, Corridor):
        request.corridor.CopyFrom(pb.Corridor(
            path=[convert.vector_to(point) for point in shape.path], width_m=float(shape.width),
            heights=_band(shape.heights)))
    elif shape is not None:
        raise InvalidArgument("a shape is an OrientedBox, a Polygon or a Corridor, not "
                              f"{type(shape).__name__}")
    return request


def _band(heights: Heights) -> pb.HeightBand:
    low, high = heights
    return pb.HeightBand(min_m=low, max_m=high)
