"""Requests for parts of the merged map. Private to the package."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Optional, Sequence, Tuple, Union

from isthmus import convert
from isthmus._arguments import number, numbers, wrong
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
    if isinstance(component, str):
        return {"map": component}
    if not hasattr(component, "__index__") or not 0 <= component < 1 << 32:
        raise wrong("component", "a session in the map, or the number of the map from 0", component)
    return {"component": component}


def put_region(request: Any, box: Optional[Sequence[Sequence[float]]],
               sphere: Optional[Tuple[Sequence[float], float]], shape: Any) -> None:
    """Puts one part of the map at most into a request that has fields for them."""
    if sum(part is not None for part in (box, sphere, shape)) > 1:
        raise InvalidArgument("give a box, a sphere or a shape, not several")
    if box is not None:
        request.box.CopyFrom(_box(box))
    if sphere is not None:
        request.sphere.CopyFrom(_sphere(sphere))
    if isinstance(shape, OrientedBox):
        request.oriented_box.CopyFrom(pb.OrientedBox(
            t_map_box=convert.pose_to("T_map_box", shape.T_map_box),
            size=convert.vector_to("size", shape.size)))
    elif isinstance(shape, Polygon):
        corners = numbers("corners", shape.corners, (-1, 2), "a list of (x, y)")
        request.polygon.CopyFrom(pb.Polygon(corners=[pb.Polygon.Corner(x=x, y=y)
                                                     for x, y in corners.tolist()],
                                            heights=_band(shape.heights)))
    elif isinstance(shape, Corridor):
        path = numbers("path", shape.path, (-1, 3), "a list of (x, y, z)")
        request.corridor.CopyFrom(pb.Corridor(path=[convert.vector_to("path", at) for at in path],
                                              width_m=number("width", shape.width),
                                              heights=_band(shape.heights)))
    elif shape is not None:
        raise wrong("shape", "an OrientedBox, a Polygon or a Corridor", shape)


def _box(box: Any) -> types_pb2.Box:
    low, high = numbers("box", box, (2, 3), "two corners, ((x, y, z), (x, y, z))")
    return types_pb2.Box(min=convert.vector_to("box", low), max=convert.vector_to("box", high))


def _sphere(sphere: Any) -> types_pb2.Sphere:
    try:
        center, radius = sphere
    except (TypeError, ValueError):
        raise wrong("sphere", "its middle and radius, ((x, y, z), radius)", sphere) from None
    return types_pb2.Sphere(center=convert.vector_to("the middle of a sphere", center),
                            radius_m=number("the radius of a sphere", radius))


def _band(heights: Heights) -> pb.HeightBand:
    try:
        low, high = heights
        return pb.HeightBand(min_m=low, max_m=high)
    except (TypeError, ValueError):
        raise wrong("heights", "the lowest and the highest, None where open", heights) from None
