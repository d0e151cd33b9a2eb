#!/usr/bin/env python3
"""Holds comments to openings that name their subject, and headers to a first line that says what
they are.

Usage: check_comments.py ROOT
Prints one line per violation and exits 1 if there is any.
"""
import pathlib
import re
import sys

ROOTS = ("api", "core", "floam", "storage", "server", "client", "fleet", "lab", "fuzz", "tests",
         "cmake")
FORBIDDEN = pathlib.PurePosixPath("tests/lint/forbidden")  # Sources that this check must find.
# Clauses that leave the reader to guess the noun: "What is not given", "Of these", "Likewise".
CLAUSE = re.compile(r"(What|Where|Who|Whom|Whose|Which|Of|Whether|Likewise|Whatever|Whoever|"
                    r"Wherever|How|That|Those)\b")
# A header is a thing: "From matches to placements" and "When a map is made" are none.
NO_THING = re.compile(r"(When|If|From|Between)\b")
# By the mark that comments begin with: a line of its own, and behind code.
BLOCK = {mark: re.compile(rf"^\s*{mark} ?(.*)") for mark in ("//", "#")}
BEHIND_CODE = {mark: re.compile(rf"""^((?:[^"]|"(?:[^"\\]|\\.)*")*?\S)\s+{mark} (.*)""")
               for mark in ("//", "#")}
MARKS = {".h": "//", ".cc": "//", ".ts": "//", ".mjs": "//", ".py": "#", ".cmake": "#"}


def openings(lines, mark):
    """Line numbers and texts of comments as they begin, a block of lines once."""
    in_block = False
    for number, line in enumerate(lines, 1):
        block = BLOCK[mark].match(line)
        if block:
            if not in_block:
                yield number, block.group(1)
        elif behind := BEHIND_CODE[mark].match(line):
            yield number, behind.group(2)
        in_block = block is not None


def problems_of(path, lines):
    if path.suffix == ".h" and not (lines and re.match(r"^// \S", lines[0])):
        yield 1, "the first line must be a comment that says what this is"
    for number, text in openings(lines, MARKS[path.suffix]):
        found = CLAUSE.match(text)
        if not found and number == 1 and path.suffix == ".h":
            found = NO_THING.match(text)
        if found:
            yield number, f'the comment opens with "{found.group(1)}"; open it with its subject'


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    sources = [f.relative_to(root) for top in ROOTS for f in sorted((root / top).rglob("*"))
               if f.suffix in MARKS]
    sources = [f for f in sources if FORBIDDEN not in f.parents and "node_modules" not in f.parts]
    problems = []
    for source in sources:
        lines = (root / source).read_text(encoding="utf-8").splitlines()
        problems += [f"{source.as_posix()}:{number}: {problem}"
                     for number, problem in problems_of(source, lines)]
    print("\n".join(problems) if problems else f"{len(sources)} sources open their comments plainly")
    sys.exit(1 if problems or not sources else 0)


if __name__ == "__main__":
    main()
