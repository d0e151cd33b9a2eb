#!/usr/bin/env python3
"""Holds prose in Markdown to 100 columns, its links to files and headings that exist, and the tables of
reasons to all that a match can have.

Usage: check_docs.py ROOT [--write]
Prints one line per violation and exits 1 if there is any. Tables and code may be wider, and so may a
word that cannot be broken. --write: wraps paragraphs that are too wide instead.
"""
import pathlib
import re
import sys

COLUMNS = 100
FENCE = re.compile(r"\s*(```|~~~)")
MARKER = re.compile(r"(?:[-*+]|\d+[.)])\s+")
# A paragraph's line must not begin with such a word: it would be something else.
STRUCTURE = re.compile(r"([-*+]|\d+[.)]|#+|>|\||=+|-+)$")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def documents(root):
    for path in sorted(root.rglob("*.md")):
        top = path.relative_to(root).parts[0]
        specimen = "forbidden" in path.relative_to(root).parts
        fetched = "node_modules" in path.parts
        if not top.startswith((".", "build", "demo-out")) and not specimen and not fetched:
            yield path


def blocks(lines):
    """(first line, lines, whether it is prose) for each paragraph, list item, table or code."""
    block, start, fenced = [], 0, False
    margin = 0  # The column of the list item's text; code is indented by four more.
    for number, line in enumerate(lines):
        if FENCE.match(line) or fenced:
            if block:
                yield start, block, True
                block = []
            fenced ^= bool(FENCE.match(line))
            yield number, [line], False
            continue
        text = line.lstrip()
        indent = len(line) - len(text)
        code = indent >= margin + 4 and not block
        alone = not text or text.startswith(("|", "#", "<!--", "![")) or code
        if block and (alone or MARKER.match(text)):
            yield start, block, True
            block = []
        if text and not code:
            marker = MARKER.match(text)
            margin = indent + marker.end() if marker else margin if indent > 0 else 0
        if alone:
            yield number, [line], False if text.startswith(("|", "<!--")) or code else None
        else:
            start = start if block else number
            block.append(line)
    if block:
        yield start, block, True


def too_wide(line):
    """Wider than allowed, though there is a space where it could be broken."""
    text = line.strip()
    marker = MARKER.match(text)
    return len(line.rstrip("\n")) > COLUMNS and " " in text[marker.end() if marker else 0:]


def wrap(block):
    """The block's words in lines as full as they may be; short code spans stay whole."""
    first = block[0].rstrip("\n")
    indent = first[:len(first) - len(first.lstrip())]
    marker = MARKER.match(first.lstrip())
    lead = indent + (marker.group() if marker else "")
    text = " ".join(line.strip() for line in block)[len(lead) - len(indent):]
    text = re.sub("`[^`]*`", lambda span: span[0].replace(" ", "\0") if len(span[0]) <= 60
                  else span[0], text)
    words = []
    for word in text.split():
        if words and (STRUCTURE.match(word) or word.startswith("|")):
            words[-1] += " " + word
        else:
            words.append(word)
    lines = [lead + words[0]]
    for word in words[1:]:
        if len(lines[-1]) + 1 + len(word) > COLUMNS:
            lines.append(" " * len(lead) + word)
        else:
            lines[-1] += " " + word
    return [line.replace("\0", " ") + "\n" for line in lines]


def wrapped(lines):
    out = []
    for _, block, prose in blocks(lines):
        out += wrap(block) if prose and any(map(too_wide, block)) else block
    return out


def anchors(path):
    """What the headings of a document are linked by."""
    for _, block, _ in blocks(path.read_text(encoding="utf-8").splitlines()):
        if block[0].startswith("#"):
            title = re.sub(r"[^\w\- ]", "", block[0].lstrip("#").strip().lower())
            yield title.replace(" ", "-")


def broken(link, path):
    """Why a link leads nowhere, or None."""
    if re.match(r"[a-z]+:", link):
        return None
    name, _, anchor = link.partition("#")
    target = (path.parent / name).resolve() if name else path
    if not target.exists():
        return f"no file {name}"
    if anchor and target.suffix == ".md" and anchor not in anchors(target):
        return f"no heading #{anchor} in {target.name}"
    return None


def check(path, root):
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    where = path.relative_to(root)
    for start, block, prose in blocks(lines):
        for number, line in enumerate(block, start + 1):
            if prose is not False and too_wide(line):
                yield f"{where}:{number}: {len(line.rstrip())} columns, more than {COLUMNS}"
            code = prose is False and not line.lstrip().startswith("|")
            for link in () if code else LINK.findall(line):
                if why := broken(link, path):
                    yield f"{where}:{number}: {why}"


def missing_reasons(root):
    """Reasons of matches that a table of them leaves out."""
    source = root / "core" / "map" / "match.cc"
    if not source.is_file():
        return
    # The first of several names of one reason is the one in use.
    pairs = re.findall(r'\{MatchReason::(\w+), "(\w+)"\}', source.read_text(encoding="utf-8"))
    names = dict(reversed(pairs)).values()
    for document in ("concepts.md", "tuning.md"):
        text = (root / "docs" / document).read_text(encoding="utf-8")
        for name in sorted(names):
            if f"\n| `{name}` |" not in text:
                yield f"docs/{document}: no row for the reason {name} of core/map/match.cc"


def main():
    root = pathlib.Path(sys.argv[1])
    if "--write" in sys.argv[2:]:
        for path in documents(root):
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            if wrapped(lines) != lines:
                path.write_text("".join(wrapped(lines)), encoding="utf-8")
    problems = [problem for path in documents(root) for problem in check(path, root)]
    problems += missing_reasons(root)
    print("\n".join(problems) or "documents are in order")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
