#!/usr/bin/env python3
"""Holds judged numbers to the limits.h of their folder, where there is one.

Usage: check_limits.py ROOT
In a folder with a limits.h, and in the folders below it, a namespace's constant number or duration
stands in a limits.h, under a comment, and its name in no other place of the top folder (floam,
server ...). What is no limit says so at the end of its line: `// Format`, of what is stored or
sent; `// Layout`, of data in memory; `// Math`.
Prints one line per violation and exits 1 if there is any.
"""
import pathlib
import re
import sys

ROOTS = ("core", "floam", "storage", "server", "client", "fleet", "lab")
NUMBER = (r"(?:std::)?(?:double|float|char|short|int|unsigned|long|size_t|ptrdiff_t|u?int\d+_t|auto)"
          r"|std::chrono::\w+|absl::Duration")
# clang-format indents nothing in a namespace, and all that is in a class or a function.
CONSTANT = re.compile(rf"^(?:inline |static )*(?:constexpr|const) (?:{NUMBER}) (k[A-Z]\w*)\s*[={{(,]")
ANYWHERE = re.compile(rf"^\s*(?:inline |static )*constexpr (?:{NUMBER}) (k[A-Z].*)")
NAME = re.compile(r"\b(k[A-Z]\w*)\s*=")
NO_LIMIT = re.compile(r"//\s*(?:Format|Layout|Math)\b")


def is_covered(root, folder):
    """Whether the folder or one above it has a limits.h."""
    inside = [folder, *folder.parents]
    return any((f / "limits.h").is_file() for f in inside[:inside.index(root)])


def is_explained(lines, number):
    """Whether a comment stands at the end of the line or above it and its like."""
    if "//" in lines[number]:
        return True
    while number > 0 and lines[number].strip() and not lines[number].startswith("//"):
        number -= 1
    return lines[number].startswith("//")


def check_top(root, top):
    """Problems of a top folder's files."""
    problems = []
    limits, others = {}, []  # Name -> place; (name, place).
    for path in sorted(f for f in (root / top).rglob("*") if f.suffix in (".h", ".cc")):
        if not is_covered(root, path.parent):
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines):
            place = f"{path.relative_to(root).as_posix()}:{number + 1}"
            found, anywhere = CONSTANT.match(line), ANYWHERE.match(line)
            if path.name == "limits.h" and found:
                name = found.group(1)
                if name in limits:
                    problems.append(f"{place}: {name} stands in {limits[name]} too")
                if not is_explained(lines, number):
                    problems.append(f"{place}: no comment says what {name} is and where it comes from")
                limits.setdefault(name, place)
            elif found and not NO_LIMIT.search(line):
                problems.append(f"{place}: {found.group(1)} belongs in a limits.h, or is "
                                "// Format, // Layout or // Math")
            if path.name != "limits.h" and anywhere:
                others += [(name, place) for name in NAME.findall(anywhere.group(1).split("//")[0])]
    return problems + [f"{place}: {name} stands in {limits[name]} too" for name, place in others if name in limits]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    problems = [problem for top in ROOTS for problem in check_top(root, top)]
    folders = sum(1 for top in ROOTS for _ in (root / top).rglob("limits.h"))
    print("\n".join(problems) if problems else f"limits stand in {folders} limits.h")
    sys.exit(1 if problems or not folders else 0)


if __name__ == "__main__":
    main()
