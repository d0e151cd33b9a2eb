"""The part of Client that reads and decides how the map hangs together."""
from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple, Union

from isthmus import convert
from isthmus._arguments import numbers, request, word, wrong
from isthmus.records import MatchGraph
from isthmus.link import Link
from isthmus.pose import Pose
from isthmus.v1 import edit_service_pb2 as edits, map_service_pb2 as pb
from isthmus.v1.records import Anchor, Anchored, Datum, Decision, Loop, Match, Revision


class Graph:
    """Part of Client."""

    _link: Link

    def get_match_graph(self, include_edges: bool = False) -> MatchGraph:
        """Every match, accepted or not, with its reasons, and where each session lies; with the
        submaps that carry each match if `include_edges`."""
        asked = request(pb.GetMatchGraphRequest, include_edges=include_edges)
        whole = pb.GetMatchGraphResponse()
        for part in self._link.collect(self._link.maps.GetMatchGraph, asked):
            if part.more_edges and whole.matches:
                whole.matches[-1].edges.extend(part.more_edges)
            part.ClearField("more_edges")
            whole.MergeFrom(part)
        return convert.record(MatchGraph, whole)

    def graph(self, include_edges: bool = False) -> MatchGraph:
        """Short for `get_match_graph`."""
        return self.get_match_graph(include_edges)

    def decide_match(self, a: str, b: str, decision: Union[Decision, str],
                     T_a_b: Optional[Pose] = None, note: str = "", *,
                     sessions: bool = False) -> Tuple[int, Match]:
        """A person's word on a pair: "accept", "reject", "set" (with `T_a_b`) or "withdraw".

        `a` and `b` are robots, of which the newest sessions are meant, or with `sessions` sessions.
        `T_a_b` takes b's odom frame to a's. Holds whatever the server computes. Returns the
        revision of the map placed anew, and the match as it counts now.
        """
        pair = {"session_a": a, "session_b": b} if sessions else {"robot_a": a, "robot_b": b}
        asked = request(edits.DecideMatchRequest, note=note, **pair,
                        decision=word("decision", Decision, decision),
                        t_a_b=None if T_a_b is None else convert.pose_to("T_a_b", T_a_b))
        response = self._link.call(self._link.edits.DecideMatch, asked, long=True)
        return int(response.revision), convert.record(Match, response.match)

    def list_loops(self, robot: str = "", include_edges: bool = False) -> List[Loop]:
        """Places that one robot, or any, came back to."""
        asked = request(pb.ListLoopsRequest, robot=robot, include_edges=include_edges)
        loops: List[Any] = []
        for part in self._link.collect(self._link.maps.ListLoops, asked):
            if part.more_edges and loops:
                loops[-1].edges.extend(part.more_edges)
            loops.extend(part.loops)
        return [convert.record(Loop, loop) for loop in loops]

    def decide_loop(self, loop: int, rejected: bool = True, note: str = "") -> Tuple[int, Loop]:
        """Rejects a loop closure, or lets it count again. Returns the revision after that, and the
        loop closure without its edges. `NotFound` if there is none."""
        kind = edits.DecideLoopRequest
        asked = request(kind, id=loop, decision=kind.REJECT if rejected else kind.RESTORE,
                        note=note)
        response = self._link.call(self._link.edits.DecideLoop, asked, long=True)
        return int(response.revision), convert.record(Loop, response.loop)

    def set_anchor(self, target: Union[str, Tuple[str, int]], position: Sequence[float],
                   yaw: float = 0.0, sigma_xy: float = 0.0, sigma_z: float = 0.0,
                   sigma_deg: float = 0.0, note: str = "") -> Anchored:
        """`put_anchor` with a position in metres and a yaw in radians."""
        x, y, z = numbers("position", position, (3,), "three numbers, (x, y, z)").tolist()
        return self.put_anchor(target, Pose.from_xyz_rpy(x, y, z, yaw=yaw), sigma_xy, sigma_z,
                               sigma_deg, note)

    def put_anchor(self, target: Union[str, Tuple[str, int]], T_map_submap: Pose,
                   sigma_xy: float = 0.0, sigma_z: float = 0.0, sigma_deg: float = 0.0,
                   note: str = "") -> Anchored:
        """Says where a submap lies, in the frame of the site, in place of what was said before.

        `target`: a submap (session, index) or "session/index", or a robot, of whose newest session
        the newest submap is meant (not repeated then once it was sent). Standard deviations in
        metres and degrees; 0: that part is not known. `FailedPrecondition` for a robot without
        submaps.
        """
        anchor = request(pb.Anchor, t_map_submap=convert.pose_to("T_map_submap", T_map_submap),
                         sigma_xy_m=sigma_xy, sigma_z_m=sigma_z, sigma_deg=sigma_deg, note=note)
        if isinstance(target, str) and "/" not in target:
            asked = request(edits.PutAnchorRequest, anchor=anchor, robot=target)
            response = self._link.call_once(self._link.edits.PutAnchor, asked, long=True)
        else:
            anchor.session, anchor.index = _submap(target)
            asked = edits.PutAnchorRequest(anchor=anchor)
            response = self._link.call(self._link.edits.PutAnchor, asked, long=True)
        return convert.record(Anchored, response)

    def remove_anchor(self, submap: Union[str, Tuple[str, int]]) -> int:
        """Returns the revision after that. `NotFound` if the submap has none. Not repeated once it
        was sent."""
        session, index = _submap(submap)
        asked = edits.DeleteAnchorRequest(session=session, index=index)
        return int(self._link.call_once(self._link.edits.DeleteAnchor, asked, long=True).revision)

    def set_datum(self, datum: Optional[Datum]) -> None:
        """Where on the Earth the frame of the anchors lies (`MapInfo.datum` says it); None: it is
        not known any more."""
        if datum is not None and not isinstance(datum, Datum):
            raise wrong("datum", "an isthmus.Datum or None", datum)
        asked = edits.SetDatumRequest(datum=None if datum is None else request(
            pb.Datum, latitude_deg=datum.latitude_deg, longitude_deg=datum.longitude_deg,
            altitude_m=datum.altitude_m, heading_deg=datum.heading_deg))
        self._link.call(self._link.edits.SetDatum, asked, long=True)

    def list_anchors(self) -> List[Anchor]:
        """In order of submap."""
        parts = self._link.collect(self._link.maps.ListAnchors, pb.ListAnchorsRequest())
        return [convert.record(Anchor, anchor) for part in parts for anchor in part.anchors]

    def list_revisions(self, limit: int = 0) -> List[Revision]:
        """What changed the map, the newest first; at most `limit`, 100 if that is 0."""
        asked = request(pb.ListRevisionsRequest, limit=limit)
        parts = self._link.collect(self._link.maps.ListRevisions, asked)
        return [convert.record(Revision, item) for part in parts for item in part.revisions]

    def revisions(self, limit: int = 0) -> List[Revision]:
        """Short for `list_revisions`."""
        return self.list_revisions(limit)

    def undo_revision(self, revision: int, note: str = "") -> int:
        """Rejects the accepted matches and loop closures that a revision came of; returns the
        revision after that. `FailedPrecondition` when there are none. Not repeated once it was
        sent."""
        asked = request(edits.UndoRevisionRequest, revision=revision, note=note)
        return int(self._link.call_once(self._link.edits.UndoRevision, asked, long=True).revision)


def _submap(target: Union[str, Tuple[str, int]]) -> Tuple[str, int]:
    try:
        parts: Any = target.rsplit("/", 1) if isinstance(target, str) else target
        session, index = parts
        found = request(pb.Anchor, session=session).session, int(index)
    except (TypeError, ValueError):
        found = "", 0
    if not found[0] or not 0 <= found[1] < 1 << 32:
        raise wrong("a submap", "(session, index) or 'alice-1/7'", target)
    return found
