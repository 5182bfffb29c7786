#!/usr/bin/env python3
"""Writes the icons of the sample game and of the template: the same bytes on every run. Needs only Python's standard library."""

import os

FOLDER = os.path.dirname(os.path.abspath(__file__))


def ridge(seed, base, height, steps=8, size=128):
    """A line of hills from the left edge to the right, closed at the bottom; heights by a small generator of numbers."""
    points = []
    for i in range(steps + 1):
        seed = (seed * 1103515245 + 12345) % 2**31
        points.append((size * i / steps, base - height * (seed / 2**31)))
    return "M0,%d L" % size + " ".join("%.1f,%.1f" % p for p in points) + " L%d,%d Z" % (size, size)


def beacon(x, foot, scale, burns):
    """A basket of fire on a post."""
    parts = [f'<path d="M{x - 2 * scale:.1f},{foot} L{x - 1 * scale:.1f},{foot - 16 * scale:.1f} h{2 * scale:.1f} '
             f'L{x + 2 * scale:.1f},{foot} Z" fill="#3b2b22"/>',
             f'<path d="M{x - 5 * scale:.1f},{foot - 21 * scale:.1f} h{10 * scale:.1f} l{-2.5 * scale:.1f},{6 * scale:.1f} '
             f'h{-5 * scale:.1f} Z" fill="#241a16"/>']
    if burns:
        for share, color in ((1.0, "#f26b21"), (0.6, "#ffd23f")):
            w, h = 5 * scale * share, 15 * scale * share
            top = foot - 21 * scale
            parts.append(f'<path d="M{x - w:.1f},{top:.1f} C{x - w:.1f},{top - h / 2:.1f} {x:.1f},{top - h / 2:.1f} {x:.1f},{top - h:.1f} '
                         f'C{x + w / 2:.1f},{top - h / 2:.1f} {x + w:.1f},{top - h / 2:.1f} {x + w:.1f},{top:.1f} Z" fill="{color}"/>')
    return "".join(parts)


def icon(sky_top, sky_low, hills, fires):
    layers = "".join(f'<path d="{ridge(seed, base, height)}" fill="{color}"/>' for seed, base, height, color in hills)
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="128" height="128" viewBox="0 0 128 128">\n'
            f'<defs><linearGradient id="sky" x2="0" y2="1"><stop stop-color="{sky_top}"/><stop offset="1" stop-color="{sky_low}"/>'
            '</linearGradient><clipPath id="frame"><rect width="128" height="128" rx="24"/></clipPath></defs>\n'
            f'<g clip-path="url(#frame)"><rect width="128" height="128" fill="url(#sky)"/>{layers}{"".join(fires)}</g>\n</svg>\n')


def write(path, text):
    with open(os.path.join(FOLDER, path), "w", encoding="ascii", newline="\n") as file:
        file.write(text)


write("farfield-beacons.svg", icon("#1c2a52", "#f0955c",
      [(7, 88, 34, "#54507c"), (11, 100, 26, "#3a3a5c"), (3, 118, 14, "#22263c")],
      [beacon(22, 82, 0.5, True), beacon(108, 80, 0.5, True), beacon(64, 112, 2.2, True)]))
write("../../game/template/icon.svg", icon("#5aa0dc", "#e8f2f8",
      [(5, 84, 28, "#8fb0b8"), (9, 98, 24, "#6f9a70"), (2, 118, 14, "#4c7a48")], [beacon(64, 112, 2.2, True)]))
