"""A small plot of how the cost of a point develops, drawn as SVG by hand."""

import math

WIDTH, HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 60, 190, 20, 45
COLOURS = ["#0b6e99", "#c4501b", "#4c7a34"]


def scaling(sizes):
    """CPU time a point over the number of points, a line a way to run them."""
    series = {}
    for size in sizes:
        series.setdefault((size.jobs, size.place), []).append((size.points, 1e3 * size.cpu / size.points))
    top = 1.1 * max(value for line in series.values() for _, value in line)
    low = math.log10(min(size.points for size in sizes))
    span = max(math.log10(max(size.points for size in sizes)) - low, 1e-9)

    def place(points, value):
        x = LEFT + (math.log10(points) - low) / span * (WIDTH - LEFT - RIGHT)
        return f"{x:.1f},{HEIGHT - BOTTOM - value / top * (HEIGHT - TOP - BOTTOM):.1f}"

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             f'font-family="sans-serif" font-size="12" fill="#333">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    parts += [grid(place, sizes, value) for value in ticks(top)]
    for points in sorted({size.points for size in sizes}):
        x, y = place(points, 0).split(",")
        parts.append(f'<text x="{x}" y="{float(y) + 18:.1f}" text-anchor="middle">{points:,}</text>')
    for index, ((jobs, where), line) in enumerate(series.items()):
        colour = COLOURS[index % len(COLOURS)]
        parts.append(f'<polyline fill="none" stroke="{colour}" stroke-width="2" '
                     f'points="{" ".join(place(*pair) for pair in line)}"/>')
        for pair in line:
            x, y = place(*pair).split(",")
            parts.append(f'<circle cx="{x}" cy="{y}" r="3" fill="{colour}"/>')
        parts.append(f'<text x="{WIDTH - RIGHT + 15}" y="{TOP + 20 + 18 * index}" fill="{colour}">'
                     f'{jobs} at a time, {where}</text>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">points</text>')
    parts.append(f'<text transform="translate(14 {(HEIGHT - BOTTOM + TOP) / 2}) rotate(-90)" '
                 'text-anchor="middle">CPU time a point, ms</text></svg>')
    return "\n".join(parts) + "\n"


def grid(place, sizes, value):
    """A horizontal line with its number."""
    points = [size.points for size in sizes]
    (x1, y), (x2, _) = place(min(points), value).split(","), place(max(points), value).split(",")
    return (f'<line x1="{x1}" y1="{y}" x2="{x2}" y2="{y}" stroke="#ddd"/>'
            f'<text x="{LEFT - 8}" y="{float(y) + 4:.1f}" text-anchor="end">{value:g}</text>')


def ticks(top):
    """About four round numbers up to the top."""
    raw = top / 4
    unit = 10 ** math.floor(math.log10(raw))
    step = min((m * unit for m in (1, 2, 5, 10)), key=lambda m: abs(m - raw))
    return [round(step * index, 12) for index in range(int(top / step) + 1)]
