"""Ground, water, roof, bark and wood textures; each function returns a Canvas."""

import math
import random

from canvas import Canvas, mixed, scaled
from noise import cells, fractal, grain

SIZE = 256


def _blades(canvas, seed, count, length, palette, lean=0.5):
    """Blades of grass as seen from above and a little aslant: short strokes from dark roots to lighter tips."""
    rng = random.Random(seed)
    for _ in range(count):
        color = mixed(rng.choice(palette), rng.choice(palette), rng.random())
        angle = -math.pi / 2 + rng.gauss(0.0, lean)
        reach = length * (0.6 + 0.8 * rng.random())
        bright = 0.82 + 0.36 * rng.random()
        canvas.stroke(
            rng.random() * canvas.width, rng.random() * canvas.height, math.cos(angle), math.sin(angle), reach,
            scaled(color, 0.68 * bright), scaled(color, 1.12 * bright), 0.75,
        )


def grass():
    c = Canvas(SIZE, SIZE, (4.0, 4.0), (110, 118, 78))
    c.shade(fractal(SIZE, SIZE, 16, 16, 4, 11), 0.12)
    _blades(c, 12, 9000, 9.0, [(124, 136, 86), (136, 146, 98), (114, 128, 80), (150, 150, 106)], 0.8)
    c.tint(fractal(SIZE, SIZE, 4, 4, 4, 13), (146, 142, 98), 0.10)
    c.shade(fractal(SIZE, SIZE, 6, 6, 3, 14), 0.04)
    return c


def meadow():
    c = Canvas(SIZE, SIZE, (4.0, 4.0), (112, 114, 68))
    c.shade(fractal(SIZE, SIZE, 12, 12, 4, 21), 0.14)
    palette = [(150, 148, 92), (132, 140, 80), (168, 158, 108), (122, 134, 74), (178, 166, 118)]
    _blades(c, 22, 7500, 15.0, palette, 0.6)
    c.tint(fractal(SIZE, SIZE, 3, 3, 4, 23), (120, 130, 74), 0.14)
    rng = random.Random(24)
    for _ in range(150):
        x, y = int(rng.random() * SIZE), int(rng.random() * SIZE)
        color = rng.choice([(226, 224, 206), (222, 200, 98), (186, 158, 190)])
        for dx, dy, a in ((0, 0, 0.9), (1, 0, 0.6), (0, 1, 0.6), (-1, 0, 0.35), (0, -1, 0.35)):
            c.blend(x + dx, y + dy, color, a)
    return c


def rock(seed=31):
    c = Canvas(SIZE, SIZE, (8.0, 8.0), (144, 139, 131))
    # Strata: noise longer than high, bent by coarser noise; cracks where two sets of cells meet.
    c.shade(fractal(SIZE, SIZE, 3, 10, 5, seed, 0.6), 0.11)
    c.tint(fractal(SIZE, SIZE, 4, 4, 4, seed + 1), (160, 146, 124), 0.22)
    c.tint(fractal(SIZE, SIZE, 5, 5, 5, seed + 2), (112, 118, 98), 0.16)  # lichen
    bend_x = fractal(SIZE, SIZE, 5, 5, 5, seed + 3, 0.6)
    bend_y = fractal(SIZE, SIZE, 5, 5, 5, seed + 4, 0.6)
    for count, depth, offset in ((4, 0.34, 5), (9, 0.20, 6)):
        plates = cells(SIZE, SIZE, count, count, seed + offset)
        _, border, owner = (_warped(field, SIZE, bend_x, bend_y, 9.0) for field in plates)
        c.shade([(n - 0.5) * 2.0 for n in owner], 0.09)
        # A crack comes and goes along its way.
        c.shade([-max(0.0, 1.0 - b / 0.05) * min(1.0, max(0.15, 0.5 + 0.5 * v)) for b, v in zip(border, bend_x)], depth)
    c.shade(_relief(bend_x, SIZE), 0.22)
    c.shade(grain(SIZE, SIZE, seed + 7), 0.035)
    return c


def _warped(field, width, dx, dy, reach):
    """The field looked up at places pushed aside by up to some `reach` pixels, wrapped."""
    height = len(field) // width
    return [
        field[(i // width + int(reach * dy[i])) % height * width + (i + int(reach * dx[i])) % width]
        for i in range(len(field))
    ]


def _relief(field, width):
    """The field lit from above: its difference from the row below, wrapped."""
    n = len(field)
    return [field[i] - field[(i + width) % n] for i in range(n)]


def gravel():
    c = Canvas(SIZE, SIZE, (4.0, 4.0), (120, 110, 96))
    c.shade(fractal(SIZE, SIZE, 8, 8, 5, 41), 0.12)
    palette = [(158, 148, 132), (142, 134, 124), (170, 160, 142), (136, 122, 104), (150, 146, 140)]
    for count, seed, cover in ((44, 42, 0.75), (26, 43, 0.35)):
        near, border, owner = cells(SIZE, SIZE, count, count, seed)
        out = []
        for p, d, b, n in zip(c.pixels, near, border, owner):
            if n < cover and b > 0.10:
                stone = palette[int(n * 7919) % len(palette)]
                dome = 1.10 - 0.55 * d
                out.append(mixed(p, scaled(stone, dome), min(1.0, (b - 0.10) * 8.0)))
            else:
                out.append(scaled(p, 0.86 + 0.14 * min(1.0, b * 10.0)))
        c.pixels = out
    c.tint(fractal(SIZE, SIZE, 3, 3, 4, 44), (132, 118, 94), 0.16)
    c.shade(grain(SIZE, SIZE, 45), 0.04)
    return c


def asphalt():
    c = Canvas(SIZE, SIZE, (4.0, 4.0), (118, 118, 117))
    near, _, owner = cells(SIZE, SIZE, 110, 110, 51)
    c.shade([(n - 0.5) * 2.0 * max(0.0, 1.0 - d) for d, n in zip(near, owner)], 0.20)
    c.shade(fractal(SIZE, SIZE, 3, 3, 5, 52), 0.045)
    c.tint(fractal(SIZE, SIZE, 5, 5, 4, 53), (132, 128, 120), 0.10)
    _, border, _ = cells(SIZE, SIZE, 2, 2, 54)
    bend = fractal(SIZE, SIZE, 12, 12, 4, 55)
    c.shade([-max(0.0, 1.0 - abs(b + 0.02 * v) / 0.008) for b, v in zip(border, bend)], 0.28)  # hair cracks
    c.shade(grain(SIZE, SIZE, 56), 0.05)
    return c


def pavement():
    """Slabs of 0.5 m in a half bond."""
    c = Canvas(SIZE, SIZE, (4.0, 4.0), (164, 160, 152))
    rng = random.Random(61)
    tones = {(i, j): 0.94 + 0.12 * rng.random() for i in range(8) for j in range(8)}
    c.shade(fractal(SIZE, SIZE, 6, 6, 5, 62), 0.05)

    def slab(x, y, old):
        j = int(y / 0.5) % 8
        u = (x / 0.5 + 0.5 * (j % 2)) % 8.0
        fx, fy = u % 1.0, (y / 0.5) % 1.0
        edge = min(fx, 1.0 - fx, fy, 1.0 - fy) * 0.5
        tone = tones[int(u), j]
        if edge < 0.011:
            return scaled((108, 103, 95), 0.9 + 0.2 * (tone - 0.94) / 0.12)
        return scaled(old, tone * (1.04 if fy > 0.9 else 0.93 if fy < 0.08 else 1.0))

    c.paint(slab)
    c.tint(fractal(SIZE, SIZE, 3, 3, 4, 63), (140, 134, 122), 0.12)
    c.shade(grain(SIZE, SIZE, 64), 0.03)
    return c


def water():
    c = Canvas(SIZE, SIZE, (8.0, 8.0), (96, 122, 132))
    waves = fractal(SIZE, SIZE, 6, 12, 5, 71, 0.55)
    c.shade(_relief(waves, SIZE), 0.12)
    c.tint(_relief(fractal(SIZE, SIZE, 8, 16, 3, 72), SIZE), (176, 196, 204), 0.40)
    c.tint(fractal(SIZE, SIZE, 3, 3, 3, 73), (86, 116, 116), 0.20)
    return c


def roof_red():
    """Pantiles, 0.25 m wide, courses of 0.3 m."""
    c = Canvas(SIZE, SIZE, (3.0, 3.0), (172, 106, 82))
    rng = random.Random(81)
    palette = [(172, 112, 92), (158, 102, 84), (178, 122, 98), (146, 100, 86), (182, 132, 110)]
    tones = {(i, j): scaled(rng.choice(palette), 0.92 + 0.16 * rng.random()) for i in range(12) for j in range(10)}

    def tile(x, y, _):
        i, j = int(x / 0.25) % 12, int(y / 0.3) % 10
        u, v = (x / 0.25) % 1.0, (y / 0.3) % 1.0
        profile = 0.82 + 0.26 * math.sin(math.pi * u) - (0.22 if u < 0.09 else 0.0)
        course = 0.80 if v > 0.90 else 1.06 if v < 0.10 else 1.0  # the course above throws its shadow on the top
        return scaled(tones[i, j], profile * course)

    c.paint(tile)
    c.tint(fractal(SIZE, SIZE, 4, 4, 5, 82), (126, 112, 92), 0.20)
    c.shade(fractal(SIZE, SIZE, 16, 16, 4, 83), 0.06)
    return c


def roof_dark():
    """Slates, 0.25 m wide, courses of 0.1875 m, in a half bond."""
    c = Canvas(SIZE, SIZE, (3.0, 3.0), (108, 110, 116))
    rng = random.Random(91)
    tones = {(i, j): 0.84 + 0.32 * rng.random() for i in range(12) for j in range(16)}
    hues = {k: rng.random() for k in tones}

    def slate(x, y, old):
        j = int(y / 0.1875) % 16
        u = (x / 0.25 + 0.5 * (j % 2)) % 12.0
        k, fu, fv = (int(u), j), u % 1.0, (y / 0.1875) % 1.0
        color = scaled(mixed(old, (124, 116, 112), 0.7 * hues[k]), tones[k])
        if fu < 0.05 or fv > 0.93:
            return scaled(color, 0.62)
        return scaled(color, 1.12 if fv < 0.12 else 1.0)

    c.paint(slate)
    c.tint(fractal(SIZE, SIZE, 4, 4, 5, 92), (122, 122, 104), 0.12)
    c.shade(fractal(SIZE, SIZE, 24, 24, 3, 93), 0.06)
    return c


def bark():
    w, h = 128, 256
    c = Canvas(w, h, (1.0, 2.0), (128, 112, 94))
    c.shade(fractal(w, h, 8, 4, 4, 101, 0.6), 0.10)
    # Plates, three times as high as wide, parted by dark furrows.
    bend = fractal(w, h, 6, 6, 3, 102)
    for nx, ny, seed, depth in ((9, 6, 103, 0.42), (16, 12, 104, 0.24)):
        _, border, owner = cells(w, h, nx, ny, seed)
        c.shade([(n - 0.5) * 2.0 for n in owner], 0.08)
        c.shade([-max(0.0, 1.0 - (b + 0.04 * v) / 0.22) for b, v in zip(border, bend)], depth)
    c.tint(fractal(w, h, 3, 3, 4, 105), (122, 124, 96), 0.16)  # moss
    c.shade(grain(w, h, 106), 0.04)
    return c


def birch_bark():
    w, h = 128, 128
    c = Canvas(w, h, (0.8, 0.8), (200, 194, 184))
    c.shade(fractal(w, h, 3, 12, 4, 111), 0.05)
    c.tint(fractal(w, h, 4, 4, 4, 112), (186, 170, 150), 0.20)
    rng = random.Random(113)
    for _ in range(46):  # lenticels: dark dashes across the stem
        x, y, length = rng.random() * 0.8, rng.random() * 0.8, 0.03 + 0.09 * rng.random()
        c.rect(x, y, x + length, y + 0.008 + 0.008 * rng.random(), (84, 76, 70), 0.55 + 0.4 * rng.random())
    scars = [v - 1.9 for v in fractal(w, h, 4, 6, 3, 114)]
    c.tint(scars, (74, 68, 62), 3.0)
    return c


def wood():
    w, h = 64, 128
    c = Canvas(w, h, (0.5, 1.0), (164, 132, 96))
    c.shade(fractal(w, h, 16, 2, 3, 121, 0.7), 0.10)
    c.tint(fractal(w, h, 4, 4, 4, 122), (148, 138, 122), 0.20)  # weathered grey
    c.shade(grain(w, h, 123), 0.03)
    return c
