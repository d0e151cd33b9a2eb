"""The part of Client that reads the map: what is in it, where it lies, how it changes."""
from __future__ import annotations

import time
from typing import Iterable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from isthmus import cloud, convert
from isthmus._arguments import listed, number, request, whole
from isthmus._regions import Corridor, MapName, OrientedBox, Polygon, map_of, put_region
from isthmus.errors import (DeadlineExceeded, FailedPrecondition, InvalidArgument, NotFound,
                            OutOfRange)
from isthmus.link import Link
from isthmus.records import Trajectory
from isthmus.pose import Array, Pose, matrices
from isthmus.times import Moment, to_ns
from isthmus.v1 import (admin_service_pb2, map_service_pb2 as pb, session_service_pb2,
                        types_pb2)
from isthmus.v1.records import MapInfo, RevisionDiff, ServerStatus, Submap

_FRAMES = {"map": pb.MAP, "odom": pb.ODOM}
MAP_POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"),
                      ("robot", "<u4"), ("label", "<u4")])
# Classes of points, by number.
LABELS = ("unknown", "ground", "ceiling", "wall", "pole", "vegetation", "vehicle", "object",
          "structure", "mover")
_ATTRIBUTES = (pb.QueryRegionRequest.INTENSITY, pb.QueryRegionRequest.ROBOT,
               pb.QueryRegionRequest.LABEL)
_ASK_EVERY_S = 0.2


def _class_of(name: str) -> int:
    if name in LABELS:
        return LABELS.index(name)
    raise InvalidArgument(f"no class of points is called {name!r}; choose of {', '.join(LABELS)}")


class Reading:
    """Part of Client."""

    _link: Link

    def get_status(self) -> ServerStatus:
        """How the server is getting on: process, queues, how far scans have come, disk.

        `Unimplemented` where the server is older than this.
        """
        return convert.record(ServerStatus,
                              self._link.call(self._link.admin.GetStatus,
                                              admin_service_pb2.GetStatusRequest()))

    def get_map_info(self) -> MapInfo:
        """Revision, components, and whether the server is still at work."""
        return convert.record(MapInfo,
                              self._link.call(self._link.maps.GetMapInfo, pb.GetMapInfoRequest()))

    def status(self) -> MapInfo:
        """Short for `get_map_info`."""
        return self.get_map_info()

    def wait(self, until: str = "settled", timeout_s: float = 300.0) -> MapInfo:
        """Until the server has nothing left to do ("settled"), or all robots, two at least, are in
        one component ("merged").

        `DeadlineExceeded` after `timeout_s`; `FailedPrecondition` when they are not merged and,
        as no session is open any more, will not be.
        """
        if until not in ("settled", "merged"):
            raise InvalidArgument(f"wait until 'settled' or 'merged', not {until!r}")
        deadline = time.monotonic() + number("timeout_s", timeout_s)
        while True:
            info = self.get_map_info()
            merged = len(info.robots) >= 2 and any(
                len(component.robots) == len(info.robots) for component in info.components)
            if info.settled and (until == "settled" or merged):
                return info
            if info.settled and not self._takes_more():
                raise FailedPrecondition("not merged, and no session is open any more: graph() "
                                         "shows the reasons of the matches")
            if time.monotonic() >= deadline:
                raise DeadlineExceeded(f"not {until} after {timeout_s:g} s")
            self._link.closed.wait(_ASK_EVERY_S)

    def list_submaps(self, robot: str = "") -> List[Submap]:
        """The submaps of one robot or of all; indices have gaps where submaps were retired."""
        asked = request(pb.ListSubmapsRequest, robot=robot)
        parts = self._link.collect(self._link.maps.ListSubmaps, asked)
        return [convert.record(Submap, submap) for part in parts for submap in part.submaps]

    def get_trajectory(self, robot: str, frame: str = "map", segment: int = 0,
                       poses_of: str = "sensor") -> Trajectory:
        """Where the robot's sensor was, scan by scan, in its newest session, or in the one whose id
        is given instead of a robot's name.

        `frame` "map": corrected, T_map_sensor; "odom": T_odom_sensor. `segment` 0: in "odom" the
        last; in "map" all that are placed in one component, the lowest that has any.
        `poses_of` "base": those of the robot itself, T_map_base or T_odom_base, by the session's
        T_base_sensor. `FailedPrecondition` while the robot is not placed in the map, or where the
        session does not say how the sensor is mounted.
        """
        if poses_of not in ("sensor", "base"):
            raise InvalidArgument(f"poses are of the 'sensor' or of the 'base', not {poses_of!r}")
        if frame not in tuple(_FRAMES):  # May not be hashable.
            raise InvalidArgument(f"the frame is 'map' or 'odom', not {frame!r}")
        asked = request(pb.GetTrajectoryRequest, robot=robot, frame=_FRAMES[frame],
                        segment=segment)
        parts = self._link.collect(self._link.maps.GetTrajectory, asked)
        poses = [stamped for part in parts for stamped in part.poses]
        segments = [part.segment for part in parts for _ in part.poses]
        rows = np.array([_row(stamped.pose) for stamped in poses]).reshape(-1, 7)
        T_frame_posed = matrices(rows)
        if poses_of == "base":
            T_frame_posed = T_frame_posed @ self._T_sensor_base(parts[-1].session).matrix()
        return Trajectory(
            session=parts[-1].session, revision=parts[-1].revision, component=parts[-1].component,
            stamps_ns=np.array([stamped.stamp_ns for stamped in poses], dtype=np.int64),
            poses=T_frame_posed, segments=np.array(segments, dtype=np.uint32),
            segments_left_out=tuple(parts[-1].segments_left_out))

    def trajectory(self, robot_or_session: str, frame: str = "map",
                   poses_of: str = "sensor") -> Tuple[NDArray[np.int64], Array]:
        """Stamps (N,) in nanoseconds and poses (N, 4, 4) of a robot, as of `get_trajectory`.

        Also of a session or one of its segments ("alice-1", "alice-1.2").
        """
        try:
            found = self.get_trajectory(robot_or_session, frame, poses_of=poses_of)
        except NotFound:
            found = self._session_trajectory(robot_or_session, frame, poses_of)
        return found.stamps_ns, found.poses

    def get_transform(self, a: str, b: str) -> Tuple[int, Pose]:
        """The revision, and T_a_b: robot b's odom frame to robot a's, at their newest submaps.

        `FailedPrecondition`, saying what is missing, while nothing connects the two.
        """
        asked = request(pb.GetTransformRequest, robot_a=a, robot_b=b)
        response = self._link.call(self._link.maps.GetTransform, asked)
        return int(response.revision), convert.pose_from(response.t_a_b)

    def transform(self, a: str, b: str) -> Pose:
        """T_a_b alone; see `get_transform`."""
        return self.get_transform(a, b)[1]

    def query_region(self, box: Optional[Sequence[Sequence[float]]] = None,
                     sphere: Optional[Tuple[Sequence[float], float]] = None, robot: str = "",
                     component: MapName = 0, resolution: float = 0.0, *,
                     shape: Union[OrientedBox, Polygon, Corridor, None] = None,
                     max_points: int = 0, sessions: Union[str, Iterable[str]] = (),
                     seen_from_ns: Moment = 0, seen_to_ns: Moment = 0,
                     classes: Union[str, Iterable[str]] = ()
                     ) -> Iterator[Tuple[int, Tuple[str, ...], cloud.Records]]:
        """As `query`, in pieces: the revision, the robots' names that the field `robot` indexes,
        and points, whose field `label` indexes `LABELS`. At least one piece, also where there are no points. Not tried again after the
        first."""
        asked = request(pb.QueryRegionRequest, **map_of(component), robot=robot,
                        resolution_m=resolution, max_points=max_points,
                        sessions=listed("sessions", sessions),
                        seen_from_ns=to_ns(seen_from_ns, "seen_from_ns"),
                        seen_to_ns=to_ns(seen_to_ns, "seen_to_ns"), attributes=_ATTRIBUTES,
                        classes=[_class_of(name) for name in listed("classes", classes)])
        put_region(asked, box, sphere, shape)
        robots: Tuple[str, ...] = ()
        for part in self._link.stream(self._link.maps.QueryRegion, asked):
            robots = tuple(part.robots) or robots
            has_points = len(part.cloud.data) > 0
            yield (int(part.revision), robots,
                   cloud.from_message(part.cloud) if has_points else np.zeros(0, MAP_POINT))

    def query(self, box: Optional[Sequence[Sequence[float]]] = None,
              sphere: Optional[Tuple[Sequence[float], float]] = None, robot: str = "",
              component: MapName = 0, resolution: float = 0.0, *,
              shape: Union[OrientedBox, Polygon, Corridor, None] = None, max_points: int = 0,
              sessions: Union[str, Iterable[str]] = (), seen_from_ns: Moment = 0,
              seen_to_ns: Moment = 0, classes: Union[str, Iterable[str]] = ()) -> cloud.Records:
        """Points of the merged map: a structured array (N,) with x, y, z (metres, map frame),
        intensity, `robot`, the name of the robot that saw it, and `label`, its class, one of
        `LABELS`.

        `box`: two corners (min, max); `sphere`: (center, radius); `shape`: an `OrientedBox`,
        `Polygon` or `Corridor`; without any of them everything. `robot` "": of all robots.
        `component`: which map, by the id of any session in it, which goes on naming it, or by its
        number, 0 the largest now.
        `resolution`: one point per voxel of so many metres; 0: as composed. `max_points`: at most
        so many, with the finest resolution that allows for it. `sessions`: what these saw last.
        `seen_from_ns`, `seen_to_ns`: what was seen last then, 0: at any time. `classes`: points of
        these, without: of any. `Unavailable` while the map is composed after a start of the server.
        """
        pieces: List[cloud.Records] = []
        robots: Tuple[str, ...] = ()
        for _, robots, points in self.query_region(
                box, sphere, robot, component, resolution, shape=shape, max_points=max_points,
                sessions=sessions, seen_from_ns=seen_from_ns, seen_to_ns=seen_to_ns,
                classes=classes):
            pieces.append(points)
        points = np.concatenate(pieces)
        width = max([1, *map(len, robots)])
        out = np.zeros(len(points), dtype=[*MAP_POINT.descr[:4], ("robot", f"<U{width}"),
                                            ("label", f"<U{max(map(len, LABELS))}")])
        for name in ("x", "y", "z", "intensity"):
            out[name] = points[name]
        if robots and len(points):
            out["robot"] = np.array(robots)[points["robot"]]
        out["label"] = np.array(LABELS)[points["label"]]
        return out

    def diff_revisions(self, from_revision: int, to_revision: int = 0) -> RevisionDiff:
        """How the map changed from one revision to another, 0 being the latest.

        `OutOfRange` when `from_revision` is older than what the server keeps.
        """
        asked = request(pb.DiffRevisionsRequest, from_revision=from_revision,
                        to_revision=to_revision)
        parts = self._link.collect(self._link.maps.DiffRevisions, asked)
        merged = pb.DiffRevisionsResponse()
        for part in parts:
            merged.MergeFrom(part)
        return convert.record(RevisionDiff, merged)

    def watch(self, since: Optional[int] = None,
              every_s: float = 1.0) -> Iterator[RevisionDiff]:
        """Changes of the map as they happen, until the client is closed or the caller stops.

        Of submaps alone: this asks for the revision every `every_s` seconds, and for what moved
        where that has grown; `watch_map` is told of tiles and robots too, at once. `since` is the
        revision that the caller knows (0: none); None: the one at the first question. What is
        older than the server keeps is told from the beginning (`from_revision` 0).
        """
        number("every_s", every_s, 0)
        known = self.get_map_info().revision if since is None else whole("since", since)
        while not self._link.closed.is_set():
            revision = self.get_map_info().revision
            if revision < known:
                known = 0  # Another map, or an older backup of it.
            if revision > known:
                try:
                    diff = self.diff_revisions(known)
                except OutOfRange:
                    diff = self.diff_revisions(0)
                known = diff.to_revision
                yield diff
            self._link.closed.wait(every_s)

    def _takes_more(self) -> bool:
        """Whether any session is open."""
        asked = session_service_pb2.ListSessionsRequest()
        return any(session.state == session_service_pb2.Session.ACTIVE
                   for part in self._link.collect(self._link.sessions.ListSessions, asked)
                   for session in part.sessions)

    def _T_sensor_base(self, session: str) -> Pose:
        asked = request(session_service_pb2.GetSessionRequest, session=session)
        known = self._link.call(self._link.sessions.GetSession, asked)
        T_base_sensor = convert.pose_from(known.t_base_sensor)
        # An identity stands for what nobody told, too.
        if np.allclose(T_base_sensor.matrix(), np.eye(4), rtol=0, atol=1e-9):
            raise FailedPrecondition(
                f"session {session} does not say where its sensor is on the robot: create it with "
                "T_base_sensor; where the sensor is at the base itself, poses of the 'sensor' are "
                "the same")
        return T_base_sensor.inverse()

    def _session_trajectory(self, name: str, frame: str, poses_of: str) -> Trajectory:
        asked = request(session_service_pb2.GetSessionRequest, session=name)
        session = self._link.call(self._link.sessions.GetSession, asked)
        segment = session.segment if session.first_segment else 0
        return self.get_trajectory(session.first_segment or name, frame, segment, poses_of)


def _row(pose: types_pb2.Pose) -> Tuple[float, ...]:
    t, q = pose.translation, pose.rotation
    return (t.x, t.y, t.z, q.x, q.y, q.z, q.w)
