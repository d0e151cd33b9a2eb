"""The part of Client that takes robots' data in: sessions, scans, submaps."""
from __future__ import annotations

import itertools
import uuid
from typing import Callable, Dict, List, Optional, Union

from isthmus import convert
from isthmus._arguments import number, request, whole
from isthmus._sender import finished
from isthmus.records import Ack, PushSummary, StreamStats
from isthmus.errors import InvalidArgument
from isthmus.link import Link
from isthmus.pose import Pose
from isthmus.push import Rejections, Scans, each_scan, push_drive
from isthmus.quantized import check_resolution
from isthmus.stream import ScanStream
from isthmus.v1 import edit_service_pb2, session_service_pb2 as pb
from isthmus.v1.records import Odometry, Session, SessionState, WhenBehind

KEEP_BYTES = 256 << 20


class Sessions:
    """Part of Client."""

    _link: Link

    def create_session(self, robot: str, sensor: str, T_base_sensor: Optional[Pose] = None,
                       odometry: Union[Odometry, str, None] = None,
                       when_behind: Union[WhenBehind, str] = "wait",
                       **choices: object) -> Session:
        """Opens a session. `sensor` is a name like "vlp16", "os1-64", "spinning" or "unordered";
        `odometry` "continuous", "floam", "aloam" or None for the server's own choice. `when_behind`:
        of scans that come faster than the server deals with them every one is used and the robot
        waits ("wait"), or the oldest that waits is skipped ("keep-newest"). `choices`: what else
        a CreateSessionRequest has, by the names of its fields.

        `InvalidArgument`, naming the known ones, for an unknown sensor or odometry.
        """
        choices = {"request_id": uuid.uuid4().hex, **choices}
        asked = convert.message(pb.CreateSessionRequest, robot=robot, sensor=sensor,
                                T_base_sensor=T_base_sensor, odometry=odometry,
                                when_behind=when_behind, **choices)
        return convert.record(Session, self._link.call(self._link.sessions.CreateSession, asked))

    def get_session(self, session: str) -> Session:
        """How a session stands. `NotFound` if there is none."""
        asked = request(pb.GetSessionRequest, session=session)
        return convert.record(Session, self._link.call(self._link.sessions.GetSession, asked))

    def list_sessions(self) -> List[Session]:
        """All sessions in order of creation, each followed by its later segments."""
        parts = self._link.collect(self._link.sessions.ListSessions, pb.ListSessionsRequest())
        return [convert.record(Session, session) for part in parts for session in part.sessions]

    def sessions(self) -> List[Session]:
        """Short for `list_sessions`."""
        return self.list_sessions()

    def robots(self) -> Dict[str, Session]:
        """The newest session of each robot, as the robot opened it, by the robot's name."""
        return {session.robot: session for session in self.list_sessions()
                if session.segment <= 1}

    def finish_session(self, session: str) -> Session:
        """Waits until the session's scans are processed and its last submap is durable."""
        asked = request(pb.FinishSessionRequest, session=session)
        return convert.record(
            Session, self._link.call(self._link.sessions.FinishSession, asked, long=True))

    def delete_session(self, session: str) -> None:
        """Removes a session and all that came of it from the map. Not repeated once it was sent."""
        asked = request(edit_service_pb2.DeleteSessionRequest, session=session)
        self._link.call_once(self._link.edits.DeleteSession, asked)

    def open_stream(self, session: Union[str, Session], *, resolution: float = 0.002,
                    window: int = 16, when_full: str = "wait", keep_trying_s: float = 60.0,
                    keep_bytes: int = KEEP_BYTES,
                    on_ack: Optional[Callable[[Ack], None]] = None) -> ScanStream:
        """The way for scans into a session, as they come; continues after its last scan.

        `resolution`: x, y and z are rounded to so many metres and compressed, 1e-5 to 0.1; 0 sends
        them as they are. `window`: scans under way without acknowledgement; when there are as many,
        `push` waits (`when_full="wait"`) or drops the new one (`"drop_newest"`).
        `keep_bytes`: acknowledged scans are kept in memory up to this size until they are durable,
        to be sent again should the server crash. `on_ack` is called once per scan, in order, from
        the stream's thread; it must not wait for the stream, and its exceptions end the stream.
        """
        known = session if isinstance(session, Session) else self.get_session(session)
        return ScanStream(self._link, known, resolution=resolution, window=window,
                          when_full=when_full, keep_bytes=keep_bytes, on_ack=on_ack,
                          keep_trying_s=keep_trying_s)

    def open_scan_stream(self, session: Union[str, Session], **options: object) -> ScanStream:
        """The C++ library's name of `open_stream`."""
        return self.open_stream(session, **options)  # type: ignore[arg-type]

    def push(self, robot: str, scans: Scans, sensor: str = "",
             odometry: Union[Odometry, str, None] = None, resolution: float = 0.002,
             on_ack: Optional[Callable[[Ack], None]] = None, finish: bool = True,
             keep_trying_s: float = 60.0, *, T_base_sensor: Optional[Pose] = None,
             session: Optional[str] = None, window: int = 16,
             when_behind: Union[WhenBehind, str] = "wait", **choices: object) -> PushSummary:
        """Sends a drive, as fast as the server takes it, into a new session of the robot.

        `scans`: `Scan`s or pairs (END of the scan in nanoseconds, points), in order of time; they
        are read as they are needed. When the link is lost it is opened again, and what the server
        lacks is sent again. Scans that cannot be used are rejected, one by one, and are in the
        summary with the reason. At the end the session is finished unless `finish` is False; so it
        is where `scans` yield something else than scans, which is an `InvalidArgument`.

        `session` goes on in a session of the robot, with the same drive as before: as many scans
        are skipped as the session has. See `open_stream` for `resolution`, `window` and `on_ack`,
        `create_session` for the others. Raises what ended the stream.
        """
        check_resolution(resolution)
        convert.message(pb.CreateSessionRequest, **choices)  # Also where `session` needs none.
        whole("window", window, 1), number("keep_trying_s", keep_trying_s, 0)
        drive = each_scan(scans)
        first = list(itertools.islice(drive, 1))  # A drive that is none leaves no session behind.
        known = (self.get_session(session) if session
                 else self.create_session(robot, sensor, T_base_sensor, odometry, when_behind,
                                          **choices))
        if known.robot != robot:
            raise InvalidArgument(f"session {known.id} is of robot {known.robot}, not {robot}")
        rest = itertools.islice(itertools.chain(first, drive), known.last_sequence, None)
        if known.state == SessionState.FINISHED:
            for _ in rest:
                raise finished(known)
            return PushSummary(known, StreamStats(), (), known.last_sequence)
        rejections = Rejections(on_ack)
        stream = ScanStream(self._link, known, resolution=resolution, window=window,
                            when_full="wait", keep_bytes=KEEP_BYTES, on_ack=rejections,
                            keep_trying_s=keep_trying_s, same_drive=True)
        return push_drive(stream, rest, rejections, known.last_sequence,
                          lambda: self.get_session(known.id), finish)
