"""The picture of the modules: boxes that stand on what they use, with their sub-modules, as SVG."""

import re
import sys

WIDTH, ROW, GAP, LEFT = 1120, 92, 14, 12
# From top to bottom; each: name, share of the width, what it is for.
ROWS = [
    [("apps", 1, "the program: commands, studio, helper programs")],
    [("report", 1, "results as text, JSON, CSV and pages")],
    [("fea", 0.5, "CAD mesh of a link -> 6x6 compliance"), ("calibration", 0.5, "readings -> what the model lacks")],
    [("fea", 0.5, None), ("vjm", 0.5, "links and joints -> stiffness, equilibrium, stability")],
    [("io", 1, "files that people write, results that programs read")],
    [("spatial", 1, "poses, wrenches, 6x6 matrices, units")],
    [("common", 1, "errors, progress, threads")],
]
COLOURS = {"apps": "#e8e8e8", "report": "#e3ecf7", "fea": "#fbe9d7", "calibration": "#e4f2e1", "vjm": "#f6e3ee",
           "io": "#f2f2e2", "spatial": "#f2f2e2", "common": "#f2f2e2"}


def sub_modules(page):
    names = re.findall(r"^\| `([\w/]+)` \|", page, re.M)
    result = {}
    for name in names:
        module, _, rest = name.partition("/")
        if rest and "/" not in rest:
            result.setdefault(module, []).append(rest.replace("_", " "))
    return result


def text(x, y, size, words, weight="normal"):
    words = words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("-&gt;", "&#8594;")
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}" font-weight="{weight}">{words}</text>'


def box(x, y, width, height, name, purpose, parts):
    lines = [f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="{COLOURS[name]}" stroke="#555"/>',
             text(x + 14, y + 27, 19, name, "bold"), text(x + 14, y + 49, 15, purpose)]
    at, line = x + 14, y + height - (28 if height < 1.5 * ROW else 100)
    for part in parts:
        length = 8.1 * len(part) + 18
        if at + length > x + width - 8:
            at, line = x + 14, line + 32
        lines += [f'<rect x="{at:g}" y="{line - 6:g}" width="{length:g}" height="25" rx="4" fill="white" stroke="#999"/>',
                  text(at + 9, line + 12, 14, part)]
        at += length + 6
    return lines


def main():
    page, picture = sys.argv[1:]
    with open(page) as file:
        parts = sub_modules(file.read())
    lines, y = [], GAP
    for number, row in enumerate(ROWS):
        x = LEFT
        for name, share, purpose in row:
            width = share * (WIDTH - 2 * LEFT - (len(row) - 1) * GAP)
            tall = number + 1 < len(ROWS) and any(n == name and p is None for n, _, p in ROWS[number + 1])
            if purpose is not None:
                lines += box(x, y, width, 2 * ROW + GAP if tall else ROW, name, purpose, parts.get(name, []))
            x += width + GAP
        y += ROW + GAP
    lines.append(text(LEFT, y + 18, 15, "A module may use those below it, and no others. fea and vjm stand side by side: "
                                        "neither knows the other; report knows vjm and calibration, not fea."))
    with open(picture, "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + 32}" font-family="sans-serif">\n'
                   '<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(lines) + "\n</svg>\n")


if __name__ == "__main__":
    main()
