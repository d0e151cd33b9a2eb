"""The program `isthmus`, which writes the formats that only it knows. Private to the package."""
from __future__ import annotations

import json
import os
import shutil
import subprocess
from typing import Any, Dict, Type

from isthmus.errors import (DeadlineExceeded, Error, FailedPrecondition, InvalidArgument, NotFound,
                            Unavailable, Unimplemented, Unknown)
from isthmus.link import Link

# By exit code, as docs/cli.md has them.
_ERRORS: Dict[int, Type[Error]] = {2: InvalidArgument, 3: FailedPrecondition, 4: Unavailable,
                                   5: InvalidArgument, 6: NotFound}


def run(link: Link, *arguments: str) -> Any:
    """The summary that `isthmus ARGUMENTS --json` prints, asked of the server of `link`.

    Server, token and certificates go by the environment: a list of processes shows arguments. The
    program's message and the class that its exit code stands for where it fails; `Unimplemented`
    where it is not in PATH.
    """
    program = shutil.which("isthmus")
    if program is None:
        raise Unimplemented("the program `isthmus` writes this format, and it is not in PATH: "
                            "install the package isthmus, or add its folder to PATH")
    environment = {name: value for name, value in os.environ.items()
                   if not name.startswith("ISTHMUS_")}
    environment.update(link.environment)
    try:
        done = subprocess.run([program, *arguments, "--json"], env=environment, text=True,
                              stdin=subprocess.DEVNULL, capture_output=True, check=False,
                              timeout=link.transfer_timeout_s)
    except subprocess.TimeoutExpired:
        raise DeadlineExceeded(f"`isthmus {arguments[0]}` took more than "
                               f"{link.transfer_timeout_s:g} s") from None
    if done.returncode != 0:
        said = done.stderr.strip().rpartition("isthmus: ")[2]
        raise _ERRORS.get(done.returncode, Unknown)(
            said or f"`isthmus {arguments[0]}` ended with {done.returncode}")
    return json.loads(done.stdout)
