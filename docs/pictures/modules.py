"""The picture of the modules: boxes that stand on what they use, with their sub-modules, as SVG.

    modules.py PAGE PICTURE     the sub-modules are those in the page's table"""

import re
import sys

# Name, x, y, width, height, colour, what it is for.
BOXES = [
    ("apps", 10, 10, 880, 92, "#e8e8e8", "the program: its commands, the studio, helper programs"),
    ("python", 900, 10, 230, 92, "#e8e8e8", "the Python package"),
    ("report", 10, 112, 1120, 92, "#e3ecf7", "results as text, JSON, CSV and pages"),
    ("fea", 10, 214, 500, 284, "#fbe9d7", "from the CAD mesh of a link to its 6x6 compliance"),
    ("calibration", 520, 214, 610, 137, "#e4f2e1", "from measurements to the effect that a model lacks"),
    ("vjm", 520, 361, 610, 137, "#f6e3ee", "robots of links and joints: stiffness, equilibrium, stability, effects"),
    ("io", 10, 508, 1120, 60, "#f2f2e2", "files that people write, results that programs read"),
    ("spatial", 10, 578, 1120, 60, "#f2f2e2", "poses, wrenches and twists, 6x6 matrices, units"),
    ("common", 10, 648, 1120, 60, "#f2f2e2", "errors, progress, threads"),
]
NOTES = ["A module may use those that it stands on, directly or not, and no others.",
         "fea and vjm stand side by side: a 6x6 compliance with its frame is all that passes from one to the other."]


def sub_modules(page):
    result = {}
    for module, part in re.findall(r"^\| `(\w+)/(\w+)` \|", page, re.M):
        result.setdefault(module, []).append(part.replace("_", " "))
    return result


def text(x, y, size, words, weight="normal"):
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}" font-weight="{weight}">{words}</text>'


def box(name, x, y, width, height, colour, purpose, parts):
    lines = [f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" fill="{colour}" stroke="#555"/>',
             text(x + 14, y + 25, 19, name, "bold"), text(x + 14, y + 47, 15, purpose)]
    at, line = x + 14, y + 58
    for part in parts:
        length = 9.2 * len(part) + 20
        if at + length > x + width - 8:
            at, line = x + 14, line + 34
        lines += [f'<rect x="{at:g}" y="{line}" width="{length:g}" height="26" rx="4" fill="white" stroke="#999"/>',
                  text(at + 10, line + 18, 14, part)]
        at += length + 8
    return lines


def main():
    page, picture = sys.argv[1:]
    with open(page) as file:
        parts = sub_modules(file.read())
    lines = [line for given in BOXES for line in box(*given, parts.get(given[0], []))]
    lines += [text(14, 736 + 22 * n, 15, note) for n, note in enumerate(NOTES)]
    with open(picture, "w") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1140 772" font-family="sans-serif">\n'
                   '<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(lines) + "\n</svg>\n")


if __name__ == "__main__":
    main()
