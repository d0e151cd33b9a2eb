"""Files that are there whole or not at all. Private to the package."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Union


def replace_file(path: Union[str, "os.PathLike[str]"], data: bytes) -> None:
    """Writes PATH.part and renames it."""
    target = Path(path)
    part = target.with_name(target.name + ".part")
    try:
        part.write_bytes(data)
        os.replace(part, target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
