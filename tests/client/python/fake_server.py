"""A server of the API that does what a test tells it, for what a real one does only by accident."""
from __future__ import annotations

import threading
from concurrent import futures
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional

import grpc

from isthmus.v1 import (localisation_service_pb2, localisation_service_pb2_grpc, map_service_pb2,
                        map_service_pb2_grpc, session_service_pb2 as pb, session_service_pb2_grpc)


class FakeServer(session_service_pb2_grpc.SessionServiceServicer,
                 map_service_pb2_grpc.MapServiceServicer,
                 localisation_service_pb2_grpc.LocalisationServiceServicer):
    """One session, "alice-1". Scans are acknowledged once `open_gate` was called."""

    def __init__(self) -> None:
        self.received: List[int] = []  # Sequences, of all streams.
        self.streams = 0
        self.last_sequence = 0
        self.durable_sequence = 0
        self.created_ns = 1
        self.answers: Dict[str, Iterable[Any]] = {}  # Streamed responses, by the call.
        # Called with each scan, before it is acknowledged.
        self.on_scan: Optional[Callable[[pb.ScanMessage, Any], None]] = None
        self.finished = 0  # Calls of FinishSession that succeeded.
        self.finish_errors: List[grpc.StatusCode] = []
        self.refusals: List[int] = []  # Calls refused so: after how many milliseconds to come again.
        self._gate = threading.Event()
        self._changed = threading.Condition()
        self._server = grpc.server(futures.ThreadPoolExecutor(8),
                                   options=[("grpc.max_receive_message_length", 1 << 20)])
        session_service_pb2_grpc.add_SessionServiceServicer_to_server(self, self._server)
        map_service_pb2_grpc.add_MapServiceServicer_to_server(self, self._server)
        localisation_service_pb2_grpc.add_LocalisationServiceServicer_to_server(self, self._server)
        self.address = f"127.0.0.1:{self._server.add_insecure_port('127.0.0.1:0')}"
        self._server.start()

    def __enter__(self) -> FakeServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.open_gate()
        self._server.stop(None).wait()

    def open_gate(self) -> None:
        self._gate.set()

    def await_received(self, count: int, timeout_s: float = 20) -> bool:
        with self._changed:
            return self._changed.wait_for(lambda: len(self.received) >= count, timeout_s)

    def _session(self) -> pb.Session:
        return pb.Session(id="alice-1", robot="alice", state=pb.Session.ACTIVE,
                          created_ns=self.created_ns, last_sequence=self.last_sequence,
                          durable_sequence=self.durable_sequence)

    def _refuse(self, context: Any) -> None:
        if not self.refusals:
            return
        context.set_trailing_metadata((("retry-after-ms", str(self.refusals.pop(0))),))
        context.abort(grpc.StatusCode.RESOURCE_EXHAUSTED, "as many calls as there may be")

    # The API.

    def GetMapInfo(self, request: Any, context: Any) -> Any:
        return map_service_pb2.MapInfo()

    def CreateSession(self, request: Any, context: Any) -> Any:
        self._refuse(context)
        return self._session()

    def GetSession(self, request: Any, context: Any) -> Any:
        return self._session()

    def FinishSession(self, request: Any, context: Any) -> Any:
        if self.finish_errors:
            context.abort(self.finish_errors.pop(0), "not now")
        self.finished += 1
        session = self._session()
        session.state = pb.Session.FINISHED
        return session

    def StreamScans(self, requests: Iterator[pb.StreamScansRequest], context: Any) -> Any:
        self.streams += 1
        self._refuse(context)
        for request in requests:
            if not request.HasField("scan"):
                continue
            scan = request.scan
            with self._changed:
                self.received.append(scan.sequence)
                self._changed.notify_all()
            self._gate.wait()
            if self.on_scan is not None:
                self.on_scan(scan, context)
            outcome = pb.StreamScansResponse.PROCESSED
            if scan.sequence <= self.last_sequence:
                outcome = pb.StreamScansResponse.DUPLICATE
            elif scan.cloud.width == 0:
                outcome = pb.StreamScansResponse.REJECTED
            self.last_sequence = max(self.last_sequence, scan.sequence)
            yield pb.StreamScansResponse(sequence=scan.sequence, outcome=outcome,
                                         durable_sequence=self.durable_sequence)

    def ExportMap(self, request: Any, context: Any) -> Any:
        self._refuse(context)
        yield from self.answers["ExportMap"]

    def ListLoops(self, request: Any, context: Any) -> Any:
        self._refuse(context)
        yield from self.answers["ListLoops"]

    def GetMatchGraph(self, request: Any, context: Any) -> Any:
        yield from self.answers["GetMatchGraph"]

    def Localise(self, requests: Any, context: Any) -> Any:
        self._refuse(context)
        for request in requests:
            yield localisation_service_pb2.LocaliseResponse(sequence=request.scan.sequence)
