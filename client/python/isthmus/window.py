"""The scans that a robot has to keep, and to send again after a lost link. Private."""
from __future__ import annotations

from collections import deque
from typing import Deque, Optional

from isthmus.v1 import session_service_pb2 as pb


class ScanWindow:
    """Scans by ascending sequence, kept until they are durable at the server: one that was
    acknowledged but is not durable yet is lost if the server dies.

    At most `window`, 1 at least, are without acknowledgement. Of those that are acknowledged the oldest are
    given up when they exceed `keep_bytes`. Not thread safe.
    """

    def __init__(self, last_sequence: int, window: int, keep_bytes: int) -> None:
        self._window, self._keep_bytes = window, keep_bytes
        self._scans: Deque[pb.ScanMessage] = deque()
        self._acked_bytes = 0
        self.next = self._to_send = last_sequence + 1
        self.acked = self.at_server = last_sequence  # All up to here are.
        self.lost = 0

    @property
    def full(self) -> bool:
        """No further scan may be added."""
        return self.next - 1 - self.acked >= self._window

    @property
    def settled(self) -> bool:
        """The server has acknowledged all of them, and has not lost any of them since."""
        return self.acked + 1 == self.next and self.at_server >= self.acked

    @property
    def sent(self) -> int:
        """The highest sequence that was sent since the last rewind."""
        return self._to_send - 1

    def add(self, scan: pb.ScanMessage) -> None:
        """Takes a scan as number `next`."""
        scan.sequence = self.next
        self._scans.append(scan)
        self.next += 1

    def take(self) -> Optional[pb.ScanMessage]:
        """The next scan to put on the wire; None when all were sent.

        In place of one that is not kept any more comes an empty one, which the server rejects: its
        number is used up, and those behind it can follow.
        """
        if self._to_send >= self.next:
            return None
        first = self.next - len(self._scans)
        sequence = self._to_send
        self._to_send += 1
        if sequence >= first:
            return self._scans[sequence - first]
        self.lost += 1
        return pb.ScanMessage(sequence=sequence)

    def acknowledge(self, sequence: int) -> Optional[pb.ScanMessage]:
        """The scan, if this is the first acknowledgement of it."""
        self.at_server = max(self.at_server, sequence)
        if sequence != self.acked + 1 or sequence >= self._to_send:
            return None
        self.acked = sequence
        scan = self._scans[sequence - (self.next - len(self._scans))]
        self._acked_bytes += len(scan.cloud.data)
        while self._acked_bytes > self._keep_bytes:
            self._drop_first()
        return scan

    def durable(self, sequence: int) -> None:
        """All up to `sequence` survive a crash of the server."""
        while self._scans and self._scans[0].sequence <= min(sequence, self.acked):
            self._drop_first()

    def renumber(self, last_sequence: int) -> None:
        """Nothing was sent so far, and the server has scans up to `last_sequence` already."""
        self.acked = self.at_server = last_sequence
        self.next = last_sequence + 1
        self._to_send = self.next
        scans, self._scans = self._scans, deque()
        for scan in scans:
            self.add(scan)

    def rewind(self, last_sequence: int) -> None:
        """A new link, to a server that has scans up to `last_sequence`: what it lacks is sent
        again, and what it has not acknowledged."""
        self.at_server = last_sequence
        self._to_send = min(last_sequence, self.acked) + 1

    def _drop_first(self) -> None:
        self._acked_bytes -= len(self._scans.popleft().cloud.data)
