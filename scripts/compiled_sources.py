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


def units(build_dir):
    """(sources, flags) of each translation unit; more than one where sources are compiled together."""
    found = []
    for entry in json.loads((build_dir / "compile_commands.json").read_text(encoding="utf-8")):
        path, flags = pathlib.Path(entry["file"]), flags_of(entry["command"])
        together = INCLUDE.findall(path.read_text(encoding="utf-8")) if "/Unity/" in str(path) else []
        found.append(([os.path.relpath(source, ROOT) for source in together or [path]], flags))
    return found


def commands(build_dir):
    """Source -> its flags; of sources that are compiled together, each by itself."""
    return {source: flags for sources, flags in units(build_dir) for source in sources}
