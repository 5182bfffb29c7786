"""Noise that repeats without a seam: fields are flat lists, row by row, of width * height numbers.

Value noise with smoothstep weights, summed over octaves; cells of random points.
Source: Ebert, Musgrave, Peachey, Perlin, Worley, "Texturing and Modeling: A Procedural Approach", chapters 2 and 4.
"""

import math
import random


def _smoothstep(t):
    return t * t * (3.0 - 2.0 * t)


def value_noise(width, height, cells_x, cells_y, seed):
    """One octave in [0, 1] with cells_x * cells_y lattice points to the tile."""
    rng = random.Random(seed)
    lattice = [[rng.random() for _ in range(cells_x)] for _ in range(cells_y)]
    columns = []
    for x in range(width):
        at = x * cells_x / width
        i = int(at)
        columns.append((i, (i + 1) % cells_x, _smoothstep(at - i)))
    field = []
    for y in range(height):
        at = y * cells_y / height
        j = int(at)
        t = _smoothstep(at - j)
        line = [a + (b - a) * t for a, b in zip(lattice[j], lattice[(j + 1) % cells_y])]
        field.extend(line[i] + (line[k] - line[i]) * s for i, k, s in columns)
    return field


def standardized(field):
    """The field with mean 0 and standard deviation 1."""
    mean = sum(field) / len(field)
    deviation = math.sqrt(sum((v - mean) ** 2 for v in field) / len(field)) or 1.0
    return [(v - mean) / deviation for v in field]


def fractal(width, height, cells_x, cells_y, octaves, seed, gain=0.5):
    """Octaves of value noise, each twice as fine and `gain` times as strong; mean 0, deviation 1."""
    total = [0.0] * (width * height)
    amplitude = 1.0
    for octave in range(octaves):
        nx, ny = cells_x << octave, cells_y << octave
        if nx > width or ny > height:
            break
        layer = value_noise(width, height, nx, ny, seed * 1009 + octave)
        total = [t + amplitude * v for t, v in zip(total, layer)]
        amplitude *= gain
    return standardized(total)


def grain(width, height, seed):
    """White noise; mean 0, deviation 1."""
    rng = random.Random(seed)
    return [(rng.random() + rng.random() + rng.random() - 1.5) * 2.0 for _ in range(width * height)]


def cells(width, height, count_x, count_y, seed, jitter=0.9):
    """Worley's cells: three fields. Distance to the nearest point; how much farther the second one is (0 on the
    border of two cells), both in cell widths; and a random number in [0, 1) that each cell owns."""
    rng = random.Random(seed)
    points = [
        [(0.5 + jitter * (rng.random() - 0.5), 0.5 + jitter * (rng.random() - 0.5), rng.random()) for _ in range(count_x)]
        for _ in range(count_y)
    ]
    nearest, border, owner = [], [], []
    for y in range(height):
        v = (y + 0.5) * count_y / height
        j = int(v)
        around = [(dj, points[(j + dj) % count_y]) for dj in (-1, 0, 1)]
        for x in range(width):
            u = (x + 0.5) * count_x / width
            i = int(u)
            first = second = 9.0
            mine = 0.0
            for dj, line in around:
                dy0 = j + dj - v
                for di in (-1, 0, 1):
                    px, py, number = line[(i + di) % count_x]
                    dx, dy = i + di + px - u, dy0 + py
                    d = dx * dx + dy * dy
                    if d < first:
                        first, second, mine = d, first, number
                    elif d < second:
                        second = d
            first, second = math.sqrt(first), math.sqrt(second)
            nearest.append(first)
            border.append(second - first)
            owner.append(mine)
    return nearest, border, owner
