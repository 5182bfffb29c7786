"""Facade textures: each covers 12 x 9.6 m, three storeys of 3.2 m, with the ground at the lower edge."""

import random

from canvas import Canvas, mixed, scaled
from noise import fractal, grain

SIZE = 512
WIDTH_M, HEIGHT_M, STOREY_M = 12.0, 9.6, 3.2
BAY_M = 3.0


def _canvas(color):
    return Canvas(SIZE, SIZE, (WIDTH_M, HEIGHT_M), color)


def _noise(cells, octaves, seed):
    return fractal(SIZE, SIZE, cells, cells, octaves, seed)


def _glazing(c, rng, x0, y0, x1, y1, curtains=True):
    """A pane: the sky above and the dark room below, and in some windows a curtain or a blind."""
    bright = 0.85 + 0.3 * rng.random()
    c.rect(x0, y0, x1, y1, scaled((62, 68, 74), bright), 1.0, top=scaled((128, 142, 152), bright))
    width, kind = x1 - x0, rng.random()
    if curtains and kind < 0.45:
        cloth = scaled((206, 200, 188), 0.85 + 0.2 * rng.random())
        for left in (x0, x1 - 0.26 * width):
            c.rect(left, y0, left + 0.26 * width, y1, cloth, 0.72)
            for fold in range(3):
                at = left + 0.26 * width * (fold + 0.3) / 3
                c.rect(at, y0, at + 0.02 * width, y1, scaled(cloth, 0.75), 0.6)
    elif curtains and kind < 0.62:
        c.rect(x0, y1 - (0.25 + 0.5 * rng.random()) * (y1 - y0), x1, y1, (208, 202, 188), 0.75)
    c.rect(x0, y1 - 0.10, x1, y1, (20, 22, 24), 0.35)  # the reveal's shadow
    c.rect(x0, y0, x0 + 0.05, y1, (20, 22, 24), 0.25)


def _window(c, rng, x0, y0, x1, y1, paint, bars=(1, 1), curtains=True):
    """Pane, frame, and `bars` (upright, level) between the lights."""
    c.rect(x0 - 0.05, y0 - 0.03, x1 + 0.05, y1 + 0.06, scaled(paint, 0.42), 0.45)
    _glazing(c, rng, x0, y0, x1, y1, curtains)
    c.frame(x0, y0, x1, y1, 0.07, paint)
    upright, level = bars
    for i in range(1, upright + 1):
        at = x0 + (x1 - x0) * i / (upright + 1)
        c.rect(at - 0.035, y0, at + 0.035, y1, paint)
    for i in range(1, level + 1):
        at = y0 + (y1 - y0) * (0.68 if level == 1 else i / (level + 1))
        c.rect(x0, at - 0.03, x1, at + 0.03, paint)


def _sill(c, x0, x1, y, color):
    c.rect(x0 - 0.12, y - 0.14, x1 + 0.12, y, scaled(color, 0.92), top=scaled(color, 1.08))
    c.rect(x0 - 0.10, y - 0.22, x1 + 0.10, y - 0.14, (30, 28, 26), 0.32)
    for x in (x0 - 0.08, x1 - 0.02):
        c.streak(x, x + 0.10, y - 0.22, 0.7, (48, 44, 38), 0.22)


def _string_course(c, y, height, color):
    c.rect(0, y, WIDTH_M, y + height, scaled(color, 0.94), top=scaled(color, 1.08))
    c.rect(0, y - 0.10, WIDTH_M, y, (30, 28, 26), 0.30)


def _bays(width):
    """(bay number, left, right) of a window `width` metres wide in the middle of each bay."""
    for i in range(int(WIDTH_M / BAY_M)):
        middle = (i + 0.5) * BAY_M
        yield i, middle - width / 2, middle + width / 2


def _grime(c, seed):
    c.shade(_noise(3, 4, seed), 0.03)
    c.shade(fractal(SIZE, SIZE, 24, 3, 3, seed + 1), 0.02)  # rain runs down


def _masonry(seed, length_m, height_m, joint_m, colors, spread, joint_color):
    """A paint() function: courses in a half bond, each block with a colour of its own."""
    rng = random.Random(seed)
    across, up = round(WIDTH_M / length_m), round(HEIGHT_M / height_m)
    length, height = WIDTH_M / across, HEIGHT_M / up

    def any_color():
        color = mixed(rng.choice(colors), rng.choice(colors), rng.random())
        return scaled(color, 1 + spread * (2 * rng.random() - 1))

    blocks = [[any_color() for _ in range(across)] for _ in range(up)]

    def block(x, y, _):
        j = int(y / height) % up
        u = (x / length + 0.5 * (j % 2)) % across
        fx, fy = (u % 1.0) * length, y - int(y / height) * height
        edge = min(fx, length - fx, fy, height - fy)
        color = blocks[j][int(u)]
        if edge < joint_m / 2:
            return mixed(color, joint_color, 0.8)
        return scaled(color, 1.05 if height - fy < 2 * joint_m else 0.95 if fy < 2 * joint_m else 1.0)

    return block


def brick():
    c = _canvas((0, 0, 0))
    colors = [(158, 104, 84), (146, 92, 76), (168, 116, 94), (136, 88, 76), (164, 122, 104)]
    c.paint(_masonry(201, 0.25, 0.075, 0.022, colors, 0.12, (168, 158, 146)))
    _grime(c, 202)
    rng, stone = random.Random(203), (190, 182, 168)
    for storey in range(3):
        base = storey * STOREY_M
        for _, x0, x1 in _bays(1.25):
            y0, y1 = base + 0.9, base + 2.6
            _window(c, rng, x0, y0, x1, y1, (214, 210, 202))
            c.rect(x0 - 0.18, y1, x1 + 0.18, y1 + 0.24, scaled(stone, 0.94), top=scaled(stone, 1.06))
            _sill(c, x0, x1, y0, stone)
    _string_course(c, STOREY_M - 0.12, 0.16, stone)
    c.shade(grain(SIZE, SIZE, 204), 0.025)
    return c


def _shutter(c, x0, y0, x1, y1, color):
    c.rect(x0 + 0.03, y0 - 0.05, x1 + 0.05, y1, (40, 38, 34), 0.28)
    c.rect(x0, y0, x1, y1, color)
    slats = int((y1 - y0) / 0.09)
    for i in range(slats):
        y = y0 + (y1 - y0) * i / slats
        c.rect(x0 + 0.06, y, x1 - 0.06, y + 0.035, scaled(color, 0.70))
    c.frame(x0, y0, x1, y1, 0.05, scaled(color, 1.08))
    c.rect(x0, (y0 + y1) / 2 - 0.03, x1, (y0 + y1) / 2 + 0.03, scaled(color, 1.08))


def _plaster_wall(c, seed):
    c.shade(_noise(8, 6, seed), 0.025)
    c.tint(_noise(3, 5, seed + 1), (176, 164, 142), 0.14)
    _grime(c, seed + 2)


def plaster():
    c = _canvas((206, 190, 160))
    _plaster_wall(c, 211)
    rng, trim, green = random.Random(214), (212, 206, 194), (92, 112, 98)
    for storey in range(3):
        base = storey * STOREY_M
        for _, x0, x1 in _bays(1.05):
            y0, y1 = base + 0.85, base + 2.55
            c.frame(x0 - 0.14, y0 - 0.02, x1 + 0.14, y1 + 0.16, 0.16, trim)
            _window(c, rng, x0, y0, x1, y1, (216, 212, 204))
            _sill(c, x0, x1, y0, trim)
            faded = scaled(green, 0.94 + 0.12 * rng.random())
            _shutter(c, x0 - 0.64, y0, x0 - 0.10, y1, faded)
            _shutter(c, x1 + 0.10, y0, x1 + 0.64, y1, faded)
    _string_course(c, STOREY_M - 0.08, 0.14, trim)
    c.shade(grain(SIZE, SIZE, 215), 0.02)
    return c


def office():
    c = _canvas((178, 174, 166))
    c.shade(_noise(6, 5, 221), 0.03)
    _grime(c, 222)
    rng, frame = random.Random(224), (92, 94, 96)
    for storey in range(3):
        base = storey * STOREY_M
        y0, y1 = base + 1.0, base + 2.85
        for i in range(8):
            x0 = i * 1.5 + 0.14
            x1 = x0 + 1.22
            _window(c, rng, x0, y0, x1, y1, frame, (0, 0), curtains=False)
            if rng.random() < 0.4:  # blinds
                c.rect(x0 + 0.06, y1 - (0.3 + 1.2 * rng.random()), x1 - 0.06, y1 - 0.06, (190, 188, 182), 0.7)
            c.rect(x0, y0 + 0.5, x1, y0 + 0.55, frame)
            c.rect(i * 1.5 - 0.012, base + 0.05, i * 1.5 + 0.012, y0 - 0.1, (112, 108, 102), 0.8)  # panel joints
            c.rect((i + 1) * 1.5 - 0.12, y0 - 0.02, (i + 1) * 1.5 - 0.10, y1, (60, 58, 56), 0.35)
        c.rect(0, base - 0.012, WIDTH_M, base + 0.014, (112, 108, 102), 0.8)
        c.rect(0, y0 - 0.10, WIDTH_M, y0, (150, 150, 148), top=(198, 198, 194))
        c.rect(0, y0 - 0.20, WIDTH_M, y0 - 0.10, (30, 30, 30), 0.28)
        c.rect(0, y1, WIDTH_M, y1 + 0.06, (70, 70, 70), 0.5)
        for _ in range(10):
            x = rng.random() * 11.8
            c.streak(x, x + 0.05 + 0.1 * rng.random(), y0 - 0.2, 0.5, (70, 66, 60), 0.16)
    c.shade(grain(SIZE, SIZE, 225), 0.02)
    return c


def glass():
    c = _canvas((104, 126, 140))
    c.tint(_noise(2, 4, 231), (172, 184, 190), 0.42)  # clouds in the panes
    c.tint([-v for v in _noise(3, 4, 232)], (72, 90, 102), 0.35)
    rng, metal = random.Random(233), (152, 156, 160)
    for storey in range(3):
        base = storey * STOREY_M
        for i in range(8):
            x0, x1 = i * 1.5, (i + 1) * 1.5
            # Each pane leans a little differently and so mirrors another part of the sky.
            tone = rng.random()
            ink = (186, 198, 204) if tone > 0.5 else (58, 72, 82)
            c.rect(x0, base + 0.75, x1, base + STOREY_M, ink, 0.34 * abs(2 * tone - 1), top=mixed(ink, (190, 200, 206), 0.4))
            if rng.random() < 0.22:
                c.rect(x0, base + STOREY_M - 0.5 - rng.random(), x1, base + STOREY_M, (186, 184, 176), 0.4)
            c.rect(x0, base, x1, base + 0.75, scaled((84, 100, 110), 0.94 + 0.12 * rng.random()), 0.85)
    for storey in range(3):
        base = storey * STOREY_M
        c.rect(0, base + 0.72, WIDTH_M, base + 0.79, metal)
        c.rect(0, base - 0.04, WIDTH_M, base + 0.04, metal)
        c.rect(0, base + HEIGHT_M - 0.04, WIDTH_M, base + HEIGHT_M, metal)
        c.rect(0, base + 0.68, WIDTH_M, base + 0.72, (40, 46, 50), 0.5)
        c.rect(0, base + STOREY_M - 0.08, WIDTH_M, base + STOREY_M - 0.04, (40, 46, 50), 0.5)
    for i in range(9):
        c.rect(i * 1.5 - 0.035, 0, i * 1.5 + 0.035, HEIGHT_M, metal)
        c.rect(i * 1.5 + 0.035, 0, i * 1.5 + 0.075, HEIGHT_M, (40, 46, 50), 0.4)
    c.shade(_noise(24, 3, 234), 0.02)
    return c


def stone():
    c = _canvas((0, 0, 0))
    colors = [(176, 164, 142), (164, 152, 132), (186, 174, 152), (156, 148, 134), (178, 160, 134)]
    c.paint(_masonry(241, 0.75, 0.4, 0.035, colors, 0.06, (132, 122, 106)))
    c.shade(_noise(12, 5, 242), 0.05)
    c.tint(_noise(3, 5, 243), (140, 136, 120), 0.20)
    _grime(c, 244)
    rng, trim = random.Random(246), (192, 182, 162)
    for storey in range(3):
        base = storey * STOREY_M
        for _, x0, x1 in _bays(1.15):
            y0, y1 = base + 0.75, base + 2.5
            for side in (x0 - 0.22, x1):
                for block in range(6):  # toothed jambs
                    y = y0 + (y1 - y0) * block / 6
                    wide = 0.06 if block % 2 else 0.0
                    left = side - (wide if side < x0 else 0.0)
                    c.rect(left, y + 0.015, left + 0.22 + wide, y + (y1 - y0) / 6, scaled(trim, 0.95 + 0.1 * rng.random()))
            _window(c, rng, x0, y0, x1, y1, (120, 98, 78), (1, 2))
            c.rect(x0 - 0.25, y1, x1 + 0.25, y1 + 0.30, scaled(trim, 0.92), top=scaled(trim, 1.06))
            c.rect((x0 + x1) / 2 - 0.13, y1 - 0.02, (x0 + x1) / 2 + 0.13, y1 + 0.38, scaled(trim, 1.03))
            c.frame((x0 + x1) / 2 - 0.13, y1 - 0.02, (x0 + x1) / 2 + 0.13, y1 + 0.38, 0.02, (120, 112, 98))
            _sill(c, x0, x1, y0, trim)
    _string_course(c, STOREY_M - 0.14, 0.20, trim)
    c.shade(grain(SIZE, SIZE, 247), 0.025)
    return c


def _shop(c, rng, x0, x1, paint, cloth):
    """One shop front between two piers: stall riser, window, door, sign and a striped awning."""
    c.rect(x0, 0, x1, 3.05, paint, top=scaled(paint, 1.1))
    door = x1 - 1.15
    _glazing(c, rng, x0 + 0.15, 0.55, door - 0.1, 2.35, curtains=False)
    for _ in range(9):  # goods in the window
        x = x0 + 0.3 + rng.random() * (door - x0 - 0.9)
        wares = rng.choice([(176, 140, 104), (150, 96, 84), (188, 180, 160), (112, 128, 110), (168, 156, 96)])
        c.rect(x, 0.6, x + 0.15 + 0.3 * rng.random(), 0.8 + 0.7 * rng.random(), wares, 0.75)
    c.frame(x0 + 0.15, 0.55, door - 0.1, 2.35, 0.06, scaled(paint, 0.72))
    middle = (x0 + 0.05 + door) / 2
    c.rect(middle - 0.03, 0.55, middle + 0.03, 2.35, scaled(paint, 0.72))
    c.frame(x0 + 0.2, 0.1, door - 0.15, 0.45, 0.04, scaled(paint, 0.8))
    _glazing(c, rng, door + 0.1, 0.25, x1 - 0.15, 2.35, curtains=False)
    c.frame(door, 0.02, x1 - 0.05, 2.42, 0.12, scaled(paint, 0.8))
    c.rect(x1 - 0.32, 1.05, x1 - 0.27, 1.35, (190, 176, 130))
    # The awning hides the glazing's upper part; the sign stands above it.
    stripes = max(6, round((x1 - x0) / 0.3) // 2 * 2)
    for i in range(stripes):
        a, b = x0 + (x1 - x0) * i / stripes, x0 + (x1 - x0) * (i + 1) / stripes
        ink = cloth if i % 2 else (216, 210, 196)
        c.rect(a, 1.98, b, 2.5, scaled(ink, 0.86), top=ink)
        c.rect(a, 1.88, b, 1.98, scaled(ink, 0.72))
    c.rect(x0, 1.55, x1, 1.88, (16, 16, 18), 0.38)
    c.rect(x0, 2.52, x1, 3.0, scaled(paint, 0.62))
    c.frame(x0, 2.52, x1, 3.0, 0.03, scaled(paint, 1.1))
    x = x0 + 0.5
    while x < x1 - 0.6:  # strokes that read as letters from across the street
        w = 0.08 + 0.12 * rng.random()
        c.rect(x, 2.64, x + 0.05, 2.88, (216, 204, 170))
        c.rect(x, 2.64 + 0.1 * int(3 * rng.random()), x + w, 2.69 + 0.08 * rng.random() + 0.1, (216, 204, 170), 0.9)
        x += w + (0.10 if rng.random() < 0.8 else 0.28)


def shops():
    c = _canvas((186, 170, 150))
    _plaster_wall(c, 251)
    rng, trim = random.Random(254), (206, 198, 184)
    for storey in (1, 2):
        base = storey * STOREY_M
        for _, x0, x1 in _bays(1.2):
            y0, y1 = base + 0.7, base + 2.55
            c.frame(x0 - 0.16, y0 - 0.02, x1 + 0.16, y1 + 0.18, 0.18, trim)
            _window(c, rng, x0, y0, x1, y1, (206, 202, 194), (1, 1))
            c.rect(x0 - 0.24, y1 + 0.18, x1 + 0.24, y1 + 0.28, trim)
            _sill(c, x0, x1, y0, trim)
    pier = (160, 152, 140)
    for left, right, paint, cloth in (
        (0.25, 3.75, (78, 96, 88), (126, 78, 70)),
        (4.25, 7.75, (112, 84, 68), (86, 112, 100)),
        (8.25, 11.75, (84, 92, 112), (172, 142, 90)),
    ):
        _shop(c, rng, left, right, paint, cloth)
        c.rect(left - 0.25, 0, left, 3.05, pier, top=scaled(pier, 1.08))
        c.rect(right, 0, right + 0.25, 3.05, pier, top=scaled(pier, 1.08))
    _string_course(c, 3.02, 0.22, trim)
    c.shade(grain(SIZE, SIZE, 255), 0.02)
    return c
