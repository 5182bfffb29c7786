"""Leaf cards: pictures with alpha whose invisible texels carry the colour of the leaves beside them.

Filters and mip levels mix invisible texels into the edge of what is seen; were they black, every leaf would get a
dark fringe.
"""

import math
import random

import png
from canvas import mixed, scaled


class Cutout:
    """Starts empty; leaves are laid over one another. Colours are kept times alpha."""

    def __init__(self, size):
        self.size = size
        self.texels = [(0.0, 0.0, 0.0, 0.0)] * (size * size)

    def over(self, x, y, color, alpha):
        if not (0 <= x < self.size and 0 <= y < self.size) or alpha <= 0.0:
            return
        at = y * self.size + x
        r, g, b, a = self.texels[at]
        rest = 1.0 - alpha
        self.texels[at] = (
            color[0] * alpha + r * rest, color[1] * alpha + g * rest, color[2] * alpha + b * rest, alpha + a * rest,
        )

    def leaf(self, x, y, angle, length, width, color):
        """A pointed leaf from (x, y) pixels along `angle`: light midrib, one half in the other's shade."""
        ux, uy = math.cos(angle), math.sin(angle)
        tip_x, tip_y = x + ux * length, y + uy * length
        reach = width
        for row in range(int(min(y, tip_y) - reach), int(max(y, tip_y) + reach) + 1):
            for column in range(int(min(x, tip_x) - reach), int(max(x, tip_x) + reach) + 1):
                dx, dy = column + 0.5 - x, row + 0.5 - y
                along, across = (dx * ux + dy * uy) / length, dy * ux - dx * uy
                if not 0.0 < along < 1.0:
                    continue
                half = 0.5 * width * math.sin(math.pi * along**0.8) ** 0.85
                cover = half - abs(across) + 0.5
                if cover <= 0.0:
                    continue
                side = 1.06 if across > 0 else 0.90
                rib = 1.14 if abs(across) < 0.7 else 1.0
                self.over(column, row, scaled(color, side * rib * (0.90 + 0.18 * along)), min(1.0, cover))

    def line(self, x0, y0, x1, y1, width, color):
        """A twig or needle; round pixels along it."""
        steps = max(1, int(math.hypot(x1 - x0, y1 - y0) * 1.5))
        half = width / 2
        for i in range(steps + 1):
            px, py = x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps
            for row in range(int(py - half), int(py + half) + 1):
                for column in range(int(px - half), int(px + half) + 1):
                    cover = half + 0.5 - math.hypot(column + 0.5 - px, row + 0.5 - py)
                    self.over(column, row, color, min(1.0, cover))

    def _bled(self):
        """Straight colours: seen texels their own, the others that of the finest mip level with something to see."""
        levels, size = [self.texels], self.size
        while size > 1:
            fine, w = levels[-1], size
            size //= 2
            levels.append([
                tuple(sum(v) / 4.0 for v in zip(*(fine[at + d] for d in (0, 1, w, w + 1))))
                for y in range(0, w, 2)
                for at in range(y * w, y * w + w, 2)
            ])
        for y in range(self.size):
            for x in range(self.size):
                for shift, level in enumerate(levels):
                    r, g, b, a = level[(y >> shift) * (self.size >> shift) + (x >> shift)]
                    if a > 0.004:
                        yield r / a, g / a, b / a
                        break

    @property
    def pixels(self):
        return list(self._bled())

    def coverage(self):
        """Share of texels that pass a cutoff of 0.5."""
        return sum(t[3] >= 0.5 for t in self.texels) / len(self.texels)

    def to_png(self):
        data = bytearray()
        for color, texel in zip(self._bled(), self.texels):
            data.extend(min(255, int(c + 0.5)) for c in (*color, 255.0 * texel[3]))
        return png.encode(self.size, self.size, 4, data)


def _spray(seed, count, length, width, palette, spread):
    """A clump of leaves round the card's middle, the lower ones darker; and the twigs that hold them."""
    card, rng, middle = Cutout(256), random.Random(seed), 128.0
    for _ in range(9):
        angle, reach = rng.random() * math.tau, 60 + 45 * rng.random()
        card.line(middle, middle, middle + math.cos(angle) * reach, middle + math.sin(angle) * reach, 2.4, (98, 92, 62))
    for i in range(count):
        depth = i / count  # 0: laid down first, below the others
        angle = rng.random() * math.tau
        radius = spread * math.sqrt(rng.random())
        heading = angle + rng.gauss(0.0, 0.7)
        reach = length * (0.8 + 0.4 * rng.random())
        size = reach / length
        root = min(radius, 124.0 - reach) - 0.5 * length  # leaves stay inside the card
        x, y = middle + math.cos(angle) * root, middle + math.sin(angle) * root
        color = mixed(rng.choice(palette), rng.choice(palette), rng.random())
        card.leaf(x, y, heading, reach, width * size, scaled(color, 0.66 + 0.44 * depth))
    return card


def oak():
    return _spray(301, 240, 30.0, 17.0, [(112, 128, 70), (98, 118, 64), (126, 138, 82), (134, 140, 80)], 112.0)


def birch():
    return _spray(311, 300, 21.0, 14.0, [(138, 148, 84), (122, 138, 78), (152, 156, 96), (128, 146, 88)], 114.0)


def spruce():
    """A branch from the upper edge's middle down to the lower edge, with twigs to both sides and needles on all."""
    card, rng = Cutout(256), random.Random(321)
    palette = [(100, 116, 78), (88, 106, 72), (112, 124, 80), (120, 130, 84)]

    def needles(x0, y0, x1, y1, length, shade):
        heading = math.atan2(y1 - y0, x1 - x0)
        steps = max(2, int(math.hypot(x1 - x0, y1 - y0) / 2.2))
        for i in range(steps + 1):
            t = i / steps
            x, y = x0 + (x1 - x0) * t, y0 + (y1 - y0) * t
            for side in (-1, 1):
                angle = heading + side * (0.75 + 0.25 * rng.random())
                reach = length * (0.75 + 0.4 * rng.random()) * (1.0 - 0.35 * t)
                color = scaled(rng.choice(palette), shade * (0.85 + 0.3 * rng.random()))
                card.line(x, y, x + math.cos(angle) * reach, y + math.sin(angle) * reach, 2.0, color)

    for pass_, shade in ((0, 0.72), (1, 1.0)):
        for i in range(13):
            y = 4 + 15.5 * i + 6 * pass_
            half = 116.0 * math.sin(math.pi * (0.16 + 0.76 * (i + 1) / 14)) ** 0.8
            for side in (-1, 1):
                reach = half * (0.85 + 0.25 * rng.random())
                x1, y1 = 128 + side * min(reach, 118), min(246.0, y + reach * (0.50 + 0.25 * rng.random()))
                card.line(128, y, x1, y1, 2.2, (92, 78, 62))
                needles(128, y, x1, y1, 15.0, shade)
    card.line(128, 0, 128, 236, 4.0, (98, 82, 64))
    needles(128, 10, 128, 240, 18.0, 1.05)
    return card
