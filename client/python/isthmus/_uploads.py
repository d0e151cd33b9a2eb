"""The part of Client that sends finished submaps of a robot with a SLAM of its own."""
from __future__ import annotations

import hashlib
import itertools
import uuid
from dataclasses import dataclass
from typing import Callable, Iterable, Iterator, Optional, Sequence, Tuple, Union

from crc32c import crc32c

from isthmus import convert
from isthmus._arguments import request, wrong
from isthmus.cloud import Points, to_message
from isthmus.link import Link
from isthmus.errors import Error
from isthmus.pose import Pose
from isthmus.times import Moment, to_ns
from isthmus.v1 import session_service_pb2 as pb, types_pb2
from isthmus.v1.records import Session

_CHUNK_BYTES = 1 << 20


@dataclass(frozen=True)
class OwnSubmap:
    """A finished submap.

    `points` (see isthmus.cloud) are in the submap's frame, which lies at `T_odom_submap` in the
    robot's odom frame. `keyframes` say where the sensor stood, T_submap_sensor, each alone or with
    its stamp in nanoseconds; a field `keyframe` (unsigned) of the points says which of them saw a
    point. It is worth the trouble: free space is what tells a right merge from a wrong one.
    Without that field all points belong to the first; without keyframes the sensor is taken to
    have stood at the submap's origin.
    """

    points: Points
    T_odom_submap: Pose = Pose()
    keyframes: Sequence[Union[Pose, Tuple[Moment, Pose]]] = ()
    first_stamp_ns: Moment = 0
    last_stamp_ns: Moment = 0


class Uploads:
    """Part of Client."""

    _link: Link

    def upload_submap(self, session: str, index: int, submap: OwnSubmap,
                      resolution: float = 0.0) -> int:
        """Sends one submap, the index-th of its session (from 0, without gaps); durable on return.

        Returns how many points the server took. Sent again after a lost link, from behind what has
        arrived; also if an earlier program was cut off. The same submap twice is no error.
        `FailedPrecondition` where the session is finished or has scans, `AlreadyExists` where the
        index holds another submap.
        """
        header, data = describe(session, index, submap, resolution)
        response = self._link.repeat(lambda: self._send(header, data), also_data_loss=True)
        return int(response.point_count)

    def upload(self, robot: str, submaps: Iterable[OwnSubmap], sensor: str = "spinning",
               resolution: float = 0.0, finish: bool = True, *,
               on_submap: Optional[Callable[[int, int], None]] = None,
               session: Optional[str] = None) -> Session:
        """Sends all submaps of a robot into a new session, and finishes it if `finish`.

        `on_submap(index, points)` is called after each. `session` goes on in a session, with the
        same submaps as before: those that the server has are not stored twice.
        """
        try:
            rest = iter(submaps)
        except TypeError:
            raise wrong("submaps", "a list or an iterator of submaps", submaps) from None
        first = list(itertools.islice(rest, 1))
        for submap in first:  # A first one that is no submap leaves no session behind.
            describe("", 0, submap, resolution)
        if session is None:
            asked = request(pb.CreateSessionRequest, robot=robot, sensor=sensor,
                            request_id=uuid.uuid4().hex)
            session = self._link.call(self._link.sessions.CreateSession, asked).id
        assert session is not None
        for index, submap in enumerate(itertools.chain(first, rest)):
            points = self.upload_submap(session, index, submap, resolution)
            if on_submap is not None:
                on_submap(index, points)
        stubs = self._link.sessions
        known = (self._link.call(stubs.FinishSession, pb.FinishSessionRequest(session=session),
                                 long=True) if finish
                 else self._link.call(stubs.GetSession, pb.GetSessionRequest(session=session)))
        return convert.record(Session, known)

    def _send(self, header: pb.UploadSubmapHeader, data: bytes) -> pb.UploadSubmapResponse:
        asked = pb.GetUploadRequest(session=header.session, index=header.index, size=header.size,
                                    crc32c=header.crc32c, sha256=header.sha256)
        try:
            known = self._link.once(lambda: self._link.sessions.GetUpload(
                asked, timeout=self._link.call_timeout_s))
            arrived = min(known.persisted, len(data))
        except Error:
            arrived = 0  # The server cannot say; the upload itself tells what is wrong.
        response: pb.UploadSubmapResponse = self._link.sessions.UploadSubmap(
            _parts(header, data, arrived), timeout=self._link.transfer_timeout_s)
        return response


def describe(session: str, index: int, submap: OwnSubmap,
             resolution: float) -> Tuple[pb.UploadSubmapHeader, bytes]:
    """The header of an upload, and the bytes that follow it."""
    if not isinstance(submap, OwnSubmap):
        raise wrong("a submap", "an isthmus.OwnSubmap", submap)
    cloud = to_message(submap.points, resolution)
    data = cloud.data
    cloud.ClearField("data")
    header = request(
        pb.UploadSubmapHeader, session=session, index=index,
        first_stamp_ns=to_ns(submap.first_stamp_ns, "first_stamp_ns"),
        last_stamp_ns=to_ns(submap.last_stamp_ns, "last_stamp_ns"),
        t_odom_submap=convert.pose_to("T_odom_submap", submap.T_odom_submap),
        keyframes=[_keyframe(k, submap.last_stamp_ns) for k in submap.keyframes], cloud=cloud,
        size=len(data), crc32c=crc32c(data), sha256=hashlib.sha256(data).digest())
    return header, data


def _parts(header: pb.UploadSubmapHeader, data: bytes,
           arrived: int) -> Iterator[pb.UploadSubmapRequest]:
    yield pb.UploadSubmapRequest(header=header)
    for offset in range(arrived, len(data), _CHUNK_BYTES):
        chunk = pb.UploadSubmapChunk(offset=offset, data=data[offset:offset + _CHUNK_BYTES])
        yield pb.UploadSubmapRequest(chunk=chunk)


def _keyframe(given: Union[Pose, Tuple[Moment, Pose]], stamp_ns: Moment) -> types_pb2.StampedPose:
    try:
        stamp, pose = (stamp_ns, given) if isinstance(given, Pose) else given
    except (TypeError, ValueError):
        raise wrong("a keyframe", "an isthmus.Pose or a pair (stamp, Pose)", given) from None
    return types_pb2.StampedPose(stamp_ns=to_ns(stamp, "the stamp of a keyframe"),
                                 pose=convert.pose_to("the pose of a keyframe", pose))
