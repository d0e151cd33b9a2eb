"""The part of Client that tells a robot where it is in the map that others made."""
from __future__ import annotations

import queue
from types import TracebackType
from typing import Any, Iterator, Optional, Tuple, Type, Union

from isthmus import convert
from isthmus.cloud import Points, to_message
from isthmus.errors import Unavailable
from isthmus.link import Link
from isthmus.pose import Pose
from isthmus.push import Scans, each_scan
from isthmus.quantized import check_resolution
from isthmus.times import Moment, to_ns
from isthmus.v1 import localisation_service_pb2 as pb
from isthmus.v1.records import LocalisedScan, Odometry


class Localisation:
    """A robot that asks where it is. Nothing of it is kept, and the map does not grow.

    Not thread safe; a context manager that closes it. When the link is lost it is opened again,
    with back-off, and the robot is looked for anew.
    """

    def __init__(self, link: Link, begin: pb.LocaliseBegin, resolution: float) -> None:
        self._link = link
        self._begin = begin
        self._resolution = resolution
        self._sequence = 0
        self._requests: Optional["queue.SimpleQueue[Optional[pb.LocaliseRequest]]"] = None
        self._call: Any = None

    def locate(self, stamp_ns: Moment, points: Points) -> LocalisedScan:
        """Sends a scan and waits for what is known of its place; `stamp_ns` is the END of it.

        A scan that the server cannot use is no error, see `LocalisedScan.rejected`.
        `InvalidArgument` for points that are none and an unknown sensor, `NotFound` for an unknown
        robot to take the map of, `FailedPrecondition` while there is no map.
        """
        self._sequence += 1
        asked = pb.LocaliseRequest()
        asked.scan.sequence = self._sequence
        asked.scan.end_stamp_ns = to_ns(stamp_ns, "stamp_ns")
        asked.scan.cloud.CopyFrom(to_message(points, self._resolution))
        response = self._link.repeat(lambda: self._ask(asked))
        return convert.record(LocalisedScan, response)

    def close(self) -> None:
        """Ends the stream; `locate` opens another one."""
        if self._requests is not None:
            self._requests.put(None)
            self._call.cancel()
        self._requests = self._call = None

    def __enter__(self) -> Localisation:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def _ask(self, asked: pb.LocaliseRequest) -> Any:
        first = self._requests is None
        if first:
            self._requests = queue.SimpleQueue()
            self._call = self._link.localisation.Localise(iter(self._requests.get, None))
            asked = pb.LocaliseRequest(begin=self._begin, scan=asked.scan)
        assert self._requests is not None
        self._requests.put(asked)
        try:
            response = next(self._call, None)
        except BaseException:
            self.close()
            raise
        if response is None:
            self.close()
            raise Unavailable("the stream of places was cut off")
        return response


class Localising:
    """Part of Client."""

    _link: Link

    def open_localisation(self, sensor: str, T_base_sensor: Optional[Pose] = None,
                          odometry: Union[Odometry, str, None] = None, in_map_of: str = "", *,
                          robot: str = "", resolution: float = 0.002) -> Localisation:
        """For a robot that only wants to know where it is. `robot`: its name, by which those who
        look on see it; with a token for one robot it is known. `in_map_of`: a robot whose map it
        is looked for in; otherwise the largest. What the server says of that comes with the first
        scan. For the others see `create_session` and `open_stream`.
        """
        begin = convert.message(pb.LocaliseBegin, robot=robot, sensor=sensor, in_map_of=in_map_of,
                                odometry=odometry, T_base_sensor=T_base_sensor)
        return Localisation(self._link, begin, check_resolution(resolution))

    def localise(self, scans: Scans, sensor: str, **options: Any
                 ) -> Iterator[Tuple[int, LocalisedScan]]:
        """The stamps of a drive's scans and what is known of their places, one by one; see
        `open_localisation` for the options."""
        with self.open_localisation(sensor, **options) as localisation:
            for stamp_ns, points in each_scan(scans):
                yield stamp_ns, localisation.locate(stamp_ns, points)
