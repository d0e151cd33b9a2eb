"""Words of the API that have a fixed set of values; docs/concepts.md says what each means.

A value that this version does not know is read as UNSPECIFIED.
"""
from __future__ import annotations

import enum
from typing import Optional


class _Word(enum.IntEnum):
    """Its number is that of the API."""

    @classmethod
    def _missing_(cls, value: object) -> Optional[_Word]:
        return cls(0) if isinstance(value, int) and value != 0 else None

    def __str__(self) -> str:
        return self.name


class Tracking(_Word):
    """How far the pose of a scan can be trusted."""

    UNSPECIFIED = 0
    OK = 1
    DEGENERATE = 2  # The scan does not observe some directions.
    LOST = 3  # It could not be matched: the pose is a prediction only.


class Odometry(_Word):
    """How a robot's motion is estimated."""

    UNSPECIFIED = 0  # The server's own choice.
    CONTINUOUS = 1  # The best.
    FLOAM = 2  # The paper's two stages.
    ALOAM = 3  # To compare with.


class WhenBehind(_Word):
    """What happens to a session's scans that come faster than the server deals with them."""

    UNSPECIFIED = 0  # As WAIT.
    WAIT = 1  # The robot is slowed down; every scan is used.
    KEEP_NEWEST = 2  # The oldest that waits is skipped.


class Role(_Word):
    """What a token is for."""

    UNSPECIFIED = 0
    ROBOT = 1  # Feeds the sessions of its own robots, and is localised.
    READER = 2  # Reads the map.
    OPERATOR = 3  # Reads it, and changes it by hand.
    ADMIN = 4  # Everything; makes tokens and backups.


class EventKind(_Word):
    """What happened; docs/concepts.md says what each means."""

    UNSPECIFIED = 0
    SERVER_STARTED = 1
    SERVER_STOPPED = 2
    SESSION_OPENED = 3
    SESSION_FINISHED = 4
    SESSION_DELETED = 5
    SESSION_EXPIRED = 6
    SEGMENT_BEGUN = 7
    ROBOT_LOST = 8
    ROBOT_FOUND = 9
    MATCH_ACCEPTED = 10
    MATCH_LOST = 11
    LOOP_CLOSED = 12
    MATCH_DECIDED = 13
    LOOP_DECIDED = 14
    REVISION_UNDONE = 15
    ANCHOR_SET = 16
    ANCHOR_REMOVED = 17
    DATUM_SET = 18
    TOKEN_CREATED = 19
    TOKEN_REVOKED = 20
    BACKUP_MADE = 21
    STORAGE_FAILED = 22
    STORAGE_WORKS = 23
    CERTIFICATE_EXPIRES = 24
    EVENTS_LOST = 25
    LOCALISING_BEGUN = 26
    LOCALISING_ENDED = 27


class SessionState(_Word):
    """Whether a session takes more."""

    UNSPECIFIED = 0
    ACTIVE = 1
    FINISHED = 2


class Outcome(_Word):
    """What became of a scan."""

    UNSPECIFIED = 0
    PROCESSED = 1
    DUPLICATE = 2  # The server had it already.
    REJECTED = 3
    SKIPPED = 4  # Newer ones came while it waited, see `WhenBehind`.


class LocalisationState(_Word):
    """What is known of a robot's place in the map."""

    UNSPECIFIED = 0
    SEARCHING = 1  # Not known where.
    AMBIGUOUS = 2  # Several places look alike: not known which.
    LOCATED = 3
    UNCERTAIN = 4  # Where odometry led from where it was known.


class MatchState(_Word):
    """What was found out about a pair of sessions."""

    UNSPECIFIED = 0
    ACCEPTED = 1  # Verified; may carry the map.
    REJECTED = 2  # A hypothesis was found and contradicted.
    AMBIGUOUS = 3  # Several explain the maps about equally well.
    NOT_YET = 4  # Too little evidence; tried again as the maps grow.


class Reason(_Word):
    """What decided on a match."""

    UNSPECIFIED = 0
    OK = 1
    BY_HAND = 2
    FREE_SPACE = 3
    POSSIBLE_TWIN = 4
    AMBIGUOUS = 5
    CYCLE = 6
    LOW_OVERLAP = 7
    TOO_SMALL = 8
    FEW_COMPARISONS = 9
    DEGENERATE = 10
    STRAINED = 11
    NOT_CONVERGED = 12
    NO_CANDIDATE = 13
    NO_POSES = 14
    UNVERIFIED = 15
    GROUP = 16
    LOOSE = 17


class GuessSource(_Word):
    """Whose guess a transform was, before it was refined and checked."""

    UNSPECIFIED = 0
    ODOMETRY = 1
    PLACES = 2
    BIRDS_EYE = 3
    PAPER = 4
    BY_HAND = 5
    STRUCTURE = 6


class Decision(_Word):
    """A person's word on a match."""

    UNSPECIFIED = 0
    ACCEPT = 1  # The transform computed last holds from now on.
    REJECT = 2  # The pair is not joined, whatever is computed.
    SET = 3  # The transform given with it holds.
    WITHDRAW = 4  # The computed match counts again.
