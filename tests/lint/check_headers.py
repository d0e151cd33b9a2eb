#!/usr/bin/env python3
"""Holds every header to a first line that says what the thing is: a noun phrase, in a comment.

Usage: check_headers.py ROOT
Prints one line per violation and exits 1 if there is any.
"""
import pathlib
import re
import sys

ROOTS = ("core", "floam", "storage", "server", "client", "bench", "tests")
FORBIDDEN = pathlib.PurePosixPath("tests/lint/forbidden")  # Headers that this check must find.
COMMENT = re.compile(r"^// \S")
# Clauses and directions instead of a noun: "What a map is made of", "From matches to placements".
NO_NOUN = re.compile(r"^// (What|Where|Whether|Of|How|Whose|That|When|If|Which|From|Between)\b")


def problem_of(line):
    """What is wrong with a header's first line; None if nothing is."""
    if not COMMENT.match(line):
        return "the first line must be a comment that says what this is"
    found = NO_NOUN.match(line)
    if found:
        return f'the first line must say what this is, in a noun phrase; it opens with "{found.group(1)}"'
    return None


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    headers = [f.relative_to(root) for top in ROOTS for f in sorted((root / top).rglob("*.h"))]
    headers = [f for f in headers if FORBIDDEN not in f.parents]
    problems = []
    for header in headers:
        lines = (root / header).read_text(encoding="utf-8").splitlines()
        problem = problem_of(lines[0] if lines else "")
        if problem:
            problems.append(f"{header.as_posix()}:1: {problem}")
    print("\n".join(problems) if problems else f"{len(headers)} headers say what they are")
    sys.exit(1 if problems or not headers else 0)


if __name__ == "__main__":
    main()
