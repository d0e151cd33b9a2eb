"""How each source is compiled, for checkers that read sources one by one; import it."""
import json
import os
import pathlib
import re
import shlex

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def flags_of(command):
    """What says how a source is read; clang is given no other flag of the compiler's."""
    words, flags = iter(shlex.split(command)), []
    for word in words:
        if word in ("-isystem", "-include"):
            flags += [word, next(words)]
        elif re.match(r"-(D|I|U|std=|pthread)", word):
            flags.append(word)
    return flags


def commands(build_dir):
    """Source -> its flags; of sources that are compiled together, each by itself."""
    found = {}
    for entry in json.loads((build_dir / "compile_commands.json").read_text(encoding="utf-8")):
        path, flags = pathlib.Path(entry["file"]), flags_of(entry["command"])
        together = INCLUDE.findall(path.read_text(encoding="utf-8")) if "/Unity/" in str(path) else []
        for source in together or [path]:
            found[os.path.relpath(source, ROOT)] = flags
    return found
