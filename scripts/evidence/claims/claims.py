"""Writes docs/paper.md from page.template, or checks it against what the paper's tables alone give. See scripts/evidence/paper."""

import argparse
import re
import string
import sys

import printed
import simulated

TEMPLATE = printed.ROOT / "scripts/evidence/claims/page.template"
PAGE = printed.ROOT / "docs/paper.md"


def expected(template, known):
    """The page as a regular expression: what is known as it stands, any number for what a simulation gives."""
    parts = []
    for text, name, form, _ in string.Formatter().parse(template):
        parts.append(re.escape(text))
        if name == "table_3":
            lines = [re.escape(line) for line in printed.table_3_lines()] + [r"[A-Z]\w+, [NK%] +[-+\d. ]+"] * 4
            parts.append("\n".join(lines))
        elif name in known:
            parts.append(re.escape(format(known[name], form)))
        elif name is not None:
            # A number, or the list of points that A does not verify.
            parts.append(r"[-+]?[\d.,e-]+(?:, \d+)*")
    return "".join(parts)


def differing_line(pattern, page):
    """The first line of the page that is not as expected."""
    for number, (line, wanted) in enumerate(zip(page.splitlines(), pattern.replace("\\\n", "\n").split("\n")), 1):
        if not re.fullmatch(wanted, line):
            return f"line {number}: {line}"
    return "its length"


def check(template):
    pattern, page = expected(template, printed.values()), PAGE.read_text(encoding="utf-8")
    if not re.fullmatch(pattern, page):
        sys.exit(f"docs/paper.md is not what scripts/evidence/paper writes ({differing_line(pattern, page)}): run it again")
    print("docs/paper.md agrees with the paper's tables")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    template = TEMPLATE.read_text(encoding="utf-8")
    if options.check:
        return check(template)
    known = printed.values() | simulated.values(options.program)
    PAGE.write_text(template.format_map(known), encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
