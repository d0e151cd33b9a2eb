"""Files that are there whole or not at all. Private to the package."""
from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path
from types import TracebackType
from typing import IO, Iterator, Optional, Type, Union

from isthmus.errors import Error, InvalidArgument, ResourceExhausted

PathLike = Union[str, "os.PathLike[str]"]


class _CannotWrite(InvalidArgument, OSError):
    """No file can be written there."""

    __str__ = BaseException.__str__  # Our sentence, not the system's.


class _DiskFull(ResourceExhausted, OSError):
    """No room for the file."""

    __str__ = BaseException.__str__


@contextlib.contextmanager
def naming(path: PathLike) -> Iterator[None]:
    """Errors of the disk within become errors of ours, which are `OSError`s still, and name `path`,
    as the caller gave it, whatever file it was."""
    try:
        yield
    except OSError as error:
        if isinstance(error, Error):  # `Unavailable`, for one.
            raise
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        why = error.strerror or str(error)
        told = (_DiskFull if is_full else _CannotWrite)(f"cannot write {os.fspath(path)}: {why}")
        told.errno, told.strerror, told.filename = error.errno, why, os.fspath(path)
        raise told from None


class WholeFile:
    """PATH.part, which becomes PATH by `finish`, and is gone where that was not reached. Errors of
    the disk are of `called`, as of `naming`. A context manager."""

    def __init__(self, path: PathLike, called: Optional[PathLike] = None) -> None:
        self._path, self._called = Path(path), path if called is None else called
        if not self._path.name:
            raise InvalidArgument(f"path is the name of a file, not {os.fspath(path)!r}")
        self._part = self._path.with_name(self._path.name + ".part")
        self._file: Optional[IO[bytes]] = None

    def begin(self) -> None:
        """Opens it, empty, also where it was begun before."""
        with naming(self._called):
            if self._path.is_dir():
                raise IsADirectoryError(errno.EISDIR, "it is a folder; give the name of a file")
            if not self._path.parent.is_dir():
                raise FileNotFoundError(errno.ENOENT, "there is no such folder; make it first")
            self._close()
            self._file = open(self._part, "wb")  # pylint: disable=consider-using-with

    def write(self, data: bytes) -> None:
        """Adds to it."""
        assert self._file is not None
        with naming(self._called):
            self._file.write(data)

    def finish(self) -> None:
        """Has it on the disk, under its name."""
        assert self._file is not None
        with naming(self._called):
            self._file.flush()
            os.fsync(self._file.fileno())
            self._close()
            os.replace(self._part, self._path)

    def __enter__(self) -> WholeFile:
        self.begin()
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        with contextlib.suppress(OSError):  # Closing writes what is left, which may fail.
            self._close()
        if kind is not None:
            self._part.unlink(missing_ok=True)

    def _close(self) -> None:
        if self._file is not None:
            file, self._file = self._file, None
            file.close()


def replace_file(path: PathLike, data: bytes) -> None:
    """Writes PATH.part and renames it."""
    with WholeFile(path) as file:
        file.write(data)
        file.finish()
