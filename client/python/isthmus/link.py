"""The connection to a server: channel, repetition, errors. Private to the package."""
from __future__ import annotations

import random
import re
import ssl
import threading
import time
from typing import Any, Callable, Iterator, List, Optional

import grpc

from isthmus._arguments import number, text, whole
from isthmus.errors import (Aborted, DataLoss, Error, InvalidArgument, ResourceExhausted,
                            Unavailable, Unimplemented, asked_to_wait, from_rpc)
from isthmus.v1 import (access_service_pb2, access_service_pb2_grpc, admin_service_pb2_grpc,
                        edit_service_pb2_grpc, event_service_pb2_grpc,
                        localisation_service_pb2_grpc, map_service_pb2_grpc,
                        session_service_pb2_grpc)
from isthmus.ways import Ways, split_addresses

_CHANNEL = (
    ("grpc.max_send_message_length", -1),  # The server's own limit decides, and says so.
    ("grpc.use_local_subchannel_pool", 1),  # Another client's failures are not waited for.
    # A radio link that is dead is noticed within the sum of these; the server permits it.
    ("grpc.keepalive_time_ms", 5_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.http2.max_pings_without_data", 0),
    # A server that comes back is found soon; the least is what one attempt may take, too.
    ("grpc.initial_reconnect_backoff_ms", 200),
    ("grpc.min_reconnect_backoff_ms", 5_000),
    ("grpc.max_reconnect_backoff_ms", 1_000),
    # Before it connects again gRPC looks the address up again, by default not for half a minute.
    ("grpc.dns_min_time_between_resolutions_ms", 200),
)


class Backoff:
    """Waits between attempts: 0.2 s, doubled up to 5 s, shortened by up to 30 % at random, so that
    robots which lost the same server do not all come back in the same instant."""

    def __init__(self, keep_trying_s: float, ways: int = 1) -> None:
        """`ways`: so many are tried one after the other before it waits."""
        self._keep_trying_s = keep_trying_s
        self._ways = ways
        self._random = random.Random()
        self.reset()

    def reset(self) -> None:
        """After a success: the next failure is the first again."""
        self._failures = 0
        self._began: Optional[float] = None

    def next(self, asked_s: Optional[float] = None) -> Optional[float]:
        """Seconds to wait after a failed attempt; None when it was tried for long enough. A server
        that is full asks for `asked_s`; what comes on top spreads those who come again."""
        now = time.monotonic()
        self._began = now if self._began is None else self._began
        left = self._began + self._keep_trying_s - now
        if left <= 0:
            return None
        self._failures += 1
        if self._failures % self._ways != 0:
            return min(asked_s or 0.0, left)
        rounds = min(self._failures // self._ways - 1, 10)
        delay = min(5.0, 0.2 * 2.0 ** rounds) * (1 - 0.3 * self._random.random())
        return min((asked_s or 0.0) + delay, left)


def check_address(address: str) -> None:
    """`InvalidArgument` where it is neither "host:port", with a port from 1 to 65535, nor a path."""
    if address.startswith(("unix:", "unix-abstract:")):
        return
    host, colon, port = address.rpartition(":")
    if colon and host and port.isascii() and port.isdigit() and 1 <= int(port) <= 65535:
        return
    raise InvalidArgument(f'"{address}" is no address of a server: write HOST:PORT, with a port '
                          "from 1 to 65535, as in localhost:50051")


class _Carrying(grpc.UnaryUnaryClientInterceptor,  # type: ignore[misc]
                grpc.UnaryStreamClientInterceptor,  # type: ignore[misc]
                grpc.StreamUnaryClientInterceptor,  # type: ignore[misc]
                grpc.StreamStreamClientInterceptor):  # type: ignore[misc]
    """Adds to every call what all of them carry."""

    def __init__(self, metadata: list[tuple[str, str]]) -> None:
        self._metadata = metadata

    def _carry(self, go_on: Callable[..., Any], details: Any, request: Any) -> Any:
        metadata = list(details.metadata or []) + self._metadata
        return go_on(_Details(details, metadata), request)

    intercept_unary_unary = intercept_unary_stream = _carry
    intercept_stream_unary = intercept_stream_stream = _carry


class _Details(grpc.ClientCallDetails):  # type: ignore[misc]
    def __init__(self, given: Any, metadata: list[tuple[str, str]]) -> None:
        self.method = given.method
        self.timeout = given.timeout
        self.metadata = metadata
        self.credentials = given.credentials
        self.wait_for_ready = given.wait_for_ready
        self.compression = given.compression


def _contents(path: Optional[str]) -> Optional[bytes]:
    if path is None:
        return None
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise InvalidArgument(f"cannot read {path}: {error.strerror}") from None


def _check_authority(path: str) -> None:
    """The file has a certificate: gRPC would only log that it has none, again and again."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    try:
        context.load_verify_locations(cafile=path)
        count = context.cert_store_stats()["x509"]
    except ssl.SSLError:
        count = 0
    if count == 0:
        raise InvalidArgument(f"{path}, given as tls_ca, holds no certificate in PEM format: give "
                              "the ca.pem that `isthmus certs init` made, or \"system\"")


def _check_pair(certificate: str, key: str) -> None:
    """The files are a certificate and its key."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.set_ciphers("DEFAULT:@SECLEVEL=0")  # The two ends agree on how strong a key must be.
    try:
        context.load_cert_chain(certificate, key, password="")
    except (ssl.SSLError, ValueError):
        raise InvalidArgument(f"tls_cert ({certificate}) and tls_key ({key}) are not a certificate "
                              "and its key without a passphrase, in PEM format") from None


def _checked_token(value: Optional[str]) -> Optional[str]:
    """Without the space around it, such as the end of the line that it was read from.
    `InvalidArgument`, which does not show it, for what no header holds: gRPC would log it."""
    value = text("token", value).strip() if value else None
    if value and not (value.isascii() and value.isprintable()):
        raise InvalidArgument("the token has a character that is not allowed: a line break, "
                              "or not ASCII")
    return value or None


def _checked_site(value: Optional[str]) -> Optional[str]:
    if value and not re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9_.-]{0,63}", text("site", value)):
        raise InvalidArgument("that cannot name a site: give up to 64 of [A-Za-z0-9_.-], "
                              "no dot in front")
    return value or None


def advice_on_unreachable(address: str, tls_ca: Optional[str], said: str) -> str:
    """What to look at, from what gRPC says of the last attempt."""
    said = said.lower()
    is_cut = "socket closed" in said or "reset by peer" in said
    if tls_ca is None:
        if is_cut:
            return ("it closed the connection: does it speak TLS? Then give the CA's certificate "
                    "(tls_ca). Or does something on the way to it cut the link?")
        return f"is it running? Start it with `isthmus-server --data DIR --listen {address}`"
    if "wrong version number" in said:
        return "it speaks plain text: leave tls_ca out, or have it serve with TLS"
    if "certificate verify failed" in said:
        return (f"its certificate has expired, or was not signed by {tls_ca}: `isthmus certs show` "
                "says until when one is valid")
    if "is not in peer certificate" in said or "hostname verification" in said:
        return "its certificate is for other hosts: use one of those names, or sign another"
    if is_cut:
        return ("it closed the connection: does it require a client certificate (tls_cert, "
                "tls_key), and trust its signer?")
    return "is it running, with TLS, and does tls_ca hold the signer of its certificate?"


def open_channel(address: str, tls_ca: Optional[str], tls_cert: Optional[str],
                 tls_key: Optional[str], token: Optional[str],
                 site: Optional[str]) -> grpc.Channel:
    """Plain text without `tls_ca`, which is a file, or "system" for what this machine trusts."""
    if tls_ca is None:
        channel = grpc.insecure_channel(address, options=_CHANNEL)
    else:
        ca = None if tls_ca == "system" else _contents(tls_ca)
        key, certificate = _contents(tls_key), _contents(tls_cert)
        if tls_ca != "system":
            _check_authority(tls_ca)
        if tls_cert is not None and tls_key is not None:
            _check_pair(tls_cert, tls_key)
        credentials = grpc.ssl_channel_credentials(ca, key, certificate)
        channel = grpc.secure_channel(address, credentials, options=_CHANNEL)
    metadata = []
    if token:
        metadata.append(("authorization", f"Bearer {token}"))
    if site:
        metadata.append(("isthmus-site", site))
    return grpc.intercept_channel(channel, _Carrying(metadata)) if metadata else channel


class Link:
    """Thread safe."""

    def __init__(self, address: str, keep_trying_s: float, call_timeout_s: float,
                 transfer_timeout_s: float, tls_ca: Optional[str] = None,
                 tls_cert: Optional[str] = None, tls_key: Optional[str] = None,
                 token: Optional[str] = None, site: Optional[str] = None,
                 max_answer_bytes: int = 64 << 20, max_file_bytes: int = 16 << 30) -> None:
        token, site = _checked_token(token), _checked_site(site)
        if (tls_cert is None) != (tls_key is None):
            raise InvalidArgument("tls_cert and tls_key go together: give both")
        addresses = split_addresses(text("address", address))
        for one in addresses:
            check_address(one)
        self.address = address
        self.tls_ca = tls_ca
        # These have `isthmus` reach the same server.
        said = {"SERVER": address, "TLS_CA": tls_ca, "TLS_CERT": tls_cert, "TLS_KEY": tls_key,
                "TOKEN": token, "SITE": site}
        self.environment = {f"ISTHMUS_{name}": value for name, value in said.items() if value}
        self.max_answer_bytes = whole("max_answer_bytes", max_answer_bytes)
        self.max_file_bytes = whole("max_file_bytes", max_file_bytes)
        self.ways = len(addresses)
        self.keep_trying_s = number("timeout", keep_trying_s, 0)
        self.call_timeout_s = number("call_timeout", call_timeout_s, 0)
        self.transfer_timeout_s = number("transfer_timeout", transfer_timeout_s, 0)
        self.closed = threading.Event()
        if self.ways == 1:
            self._channel = open_channel(address, tls_ca, tls_cert, tls_key, token, site)
        else:
            self._channel = Ways(addresses, lambda one: open_channel(one, tls_ca, tls_cert, tls_key,
                                                                     token, site))
        self.sessions = session_service_pb2_grpc.SessionServiceStub(self._channel)
        self.maps = map_service_pb2_grpc.MapServiceStub(self._channel)
        self.edits = edit_service_pb2_grpc.EditServiceStub(self._channel)
        self.admin = admin_service_pb2_grpc.AdminServiceStub(self._channel)
        self.access = access_service_pb2_grpc.AccessServiceStub(self._channel)
        self.events = event_service_pb2_grpc.EventServiceStub(self._channel)
        self.localisation = localisation_service_pb2_grpc.LocalisationServiceStub(self._channel)

    def close(self) -> None:
        """Ends what is under way."""
        self.closed.set()
        self._channel.close()

    def backoff(self, keep_trying_s: Optional[float] = None) -> Backoff:
        """Of attempts by this link; for as long as it keeps trying, unless told otherwise."""
        return Backoff(self.keep_trying_s if keep_trying_s is None else keep_trying_s, self.ways)

    def once(self, attempt: Callable[[], Any]) -> Any:
        """One attempt, with errors of ours."""
        try:
            return attempt()
        except grpc.RpcError as error:
            raise from_rpc(error) from None
        except ValueError as error:  # gRPC raises it for a channel that was closed.
            if not self.closed.is_set():
                raise
            raise Unavailable(f"the client was closed ({error})") from None

    def repeat(self, attempt: Callable[[], Any], also_data_loss: bool = False) -> Any:
        """For what may be sent twice: again while the server does not answer, or is full and says
        when to come again."""
        backoff = self.backoff()
        while True:
            try:
                return self.once(attempt)
            except Error as error:
                asked_s = asked_to_wait(error)
                again = isinstance(error, Unavailable) or asked_s is not None
                if not again and not (isinstance(error, DataLoss) and also_data_loss):
                    raise
                delay = backoff.next(asked_s)
                if delay is None or self.closed.wait(delay):
                    raise self.explain(error) from None

    def careful(self, attempt: Callable[[], Any]) -> Any:
        """For what must not be sent twice: waits for a sign of life, then sends it once."""
        self.probe()
        try:
            return self.once(attempt)
        except Unavailable as error:
            raise self.explain(error) from None

    def probe(self) -> None:
        """Asks the server for a sign of life."""
        request = access_service_pb2.GetOwnTokenRequest()
        try:
            self.repeat(lambda: self.access.GetOwnToken(request, timeout=self.call_timeout_s))
        except Unimplemented:
            pass  # An older server's Unimplemented is a sign of life, too.

    def call(self, method: Callable[..., Any], request: Any, long: bool = False) -> Any:
        """A question with one answer; `long` for what takes the server its time."""
        timeout = self.transfer_timeout_s if long else self.call_timeout_s
        return self.repeat(lambda: method(request, timeout=timeout))

    def call_once(self, method: Callable[..., Any], request: Any, long: bool = False) -> Any:
        """Likewise for what must not be sent twice."""
        timeout = self.transfer_timeout_s if long else self.call_timeout_s
        return self.careful(lambda: method(request, timeout=timeout))

    def collect(self, method: Callable[..., Any], request: Any) -> Any:
        """All responses of a list, from the beginning with each attempt."""
        def attempt() -> List[Any]:
            parts, size = [], 0
            call = method(request, timeout=self.transfer_timeout_s)
            try:
                for part in call:
                    size += part.ByteSize()
                    check_size(size, self.max_answer_bytes)
                    parts.append(part)
            finally:
                call.cancel()
            return parts

        return self.repeat(attempt)

    def stream(self, method: Callable[..., Any], request: Any) -> Iterator[Any]:
        """Responses one by one; not tried again after the first, and ended when not read on."""
        backoff = self.backoff()
        while True:
            started = False
            call = method(request, timeout=self.transfer_timeout_s)
            try:
                for response in call:
                    started = True
                    yield response
                return
            except grpc.RpcError as lost:
                error = from_rpc(lost)
            finally:
                call.cancel()
            asked_s = asked_to_wait(error)
            if not isinstance(error, Unavailable) and asked_s is None:
                raise error
            if started:
                raise not_again(error)
            delay = backoff.next(asked_s)
            if delay is None or self.closed.wait(delay):
                raise self.explain(error)

    def explain(self, error: Error) -> Error:
        """Adds to `Unavailable` where the server was sought and what to do, if none answered."""
        if (not isinstance(error, Unavailable) or error.retry_after_s is not None
                or error.message.startswith("cannot reach")):
            return error
        if self.ways > 1:
            return Unavailable(f"cannot reach isthmus-server at {self.address}: no server there "
                               "has the map: is one running, and does it reach its database? "
                               f"({error.message})")
        advice = advice_on_unreachable(self.address, self.tls_ca, error.message)
        return Unavailable(f"cannot reach isthmus-server at {self.address}: {advice} "
                           f"({error.message})")


def check_size(size: int, most: int) -> None:
    """`ResourceExhausted` where an answer is larger than the client takes."""
    if size > most:
        raise ResourceExhausted(
            f"the answer has more than the {most} bytes that this client takes: ask for less at a "
            "time, such as one component, one robot or a box, or raise its bound (connect); if so "
            "much cannot be, this is no sound server")


def not_again(error: Error) -> Error:
    """Of a transfer that cannot be taken up in the middle."""
    if not isinstance(error, Unavailable):
        return error
    return Aborted(f"the link was lost half way: {error.message}")
