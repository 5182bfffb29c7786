"""Trees and a bush: trunk and limbs as tubes, leaves as cards.

The normals of a card's corners are those of the crown more than of the card: light falls on the crown as on a soft,
round body. Cards stand rather upright and face outwards, within a limit, since shading turns a normal that points away
from the viewer: a level card seen from below would show the ground's light only, as no leaf that lets light through does.
Corners deep inside the crown and low in it are darker.
"""

import math
import random

import grounds
import leaves
from glb import CLAMP, Material, Model, Primitive
from shapes import add, cross, dot, mul, perpendicular, tube, unit


_UPRIGHT = 0.35  # how much of a card's slope is left; 1: it lies along the crown, 0: it stands upright
_OF_CARD = 0.6  # weight of the card's own direction beside the crown's in the normals


def _random_unit(rng):
    z, angle = 2.0 * rng.random() - 1.0, rng.random() * math.tau
    flat = math.sqrt(1.0 - z * z)
    return (flat * math.cos(angle), z, flat * math.sin(angle))


class Crown:
    """Ellipsoid lobes (centre, radii) inside one big ellipsoid that gives the overall shading."""

    def __init__(self, center, radii, lobes):
        self.center, self.radii, self.lobes = center, radii, lobes

    def _scaled(self, p, center, radii):
        return tuple((p[i] - center[i]) / radii[i] for i in range(3))

    def normal(self, p, lobe):
        """Outwards from the crown and, as much, from the lobe; flattened, as what shading turns must not point down much."""
        of_lobe = unit(tuple(v / r for v, r in zip(self._scaled(p, *lobe), lobe[1])))
        of_crown = unit(tuple(v / r for v, r in zip(self._scaled(p, self.center, self.radii), self.radii)))
        both = add(of_lobe, of_crown)
        return unit((both[0], 0.40 * both[1] + 0.08, both[2]))

    def brightness(self, p, lobe):
        """What the sky reaches: less inside the lobe, inside the crown and below."""
        inside = min(1.0, math.sqrt(sum(v * v for v in self._scaled(p, *lobe))))
        q = self._scaled(p, self.center, self.radii)
        outside = min(1.0, math.sqrt(dot(q, q)))
        height = min(1.0, max(0.0, 0.5 + 0.5 * q[1]))
        return (0.62 + 0.38 * inside**2) * (0.66 + 0.34 * outside**2) * (0.80 + 0.20 * height)


def _leaf_cards(primitive, rng, crown, count, size, sag=0.0, tilt=0.75):
    """`count` square cards over the lobes, shared out by the lobes' surfaces; each faces outwards within `tilt` radians."""
    areas = [(a * b) ** 0.8 + (a * c) ** 0.8 + (b * c) ** 0.8 for _, (a, b, c) in crown.lobes]
    for _ in range(count):
        lobe = rng.choices(crown.lobes, areas)[0]
        out = _random_unit(rng)
        if out[1] < -0.35 and rng.random() < 0.7:
            out = (out[0], -out[1], out[2])  # few leaves under a crown
        depth = 0.95 - 0.40 * rng.random() ** 2
        center = tuple(lobe[0][i] + out[i] * lobe[1][i] * depth for i in range(3))
        facing = add(crown.normal(center, lobe), mul(_random_unit(rng), math.sin(tilt)))
        facing = unit((facing[0], _UPRIGHT * facing[1], facing[2]))
        u, v = perpendicular(facing)
        spin = rng.random() * math.tau
        right = add(mul(u, math.cos(spin)), mul(v, math.sin(spin)))
        up = cross(facing, right)
        half = 0.5 * size * (0.8 + 0.4 * rng.random())
        ids = []
        for s, t in ((-1, 1), (1, 1), (1, -1), (-1, -1)):
            p = add(center, add(mul(right, half * s), mul(up, -half * t)))
            p = (p[0], max(0.02, p[1] - (sag * half if t > 0 else 0.0)), p[2])
            normal = unit(add(crown.normal(p, lobe), mul(facing, _OF_CARD)))
            ids.append(primitive.add(p, normal, (0.5 + 0.5 * s, 0.5 + 0.5 * t), crown.brightness(p, lobe)))
        primitive.triangle(ids[0], ids[1], ids[2])
        primitive.triangle(ids[0], ids[2], ids[3])


def _limb(primitive, rng, start, end, radius, sides, texture_m, rise=0.25, tip=0.25):
    """A limb that leaves `start` steeply and bends over towards `end`."""
    bend = add(mul(add(start, end), 0.5), (0.1 * rng.gauss(0, 1), rise * abs(end[1] - start[1]), 0.1 * rng.gauss(0, 1)))
    tube(primitive, [start, bend, end], [radius, 0.65 * radius, tip * radius], sides, texture_m)


def _bark_material(name, canvas):
    return Material(name, png=canvas.to_png())


def _leaf_material(name, cutout):
    return Material(name, png=cutout.to_png(), mask=True, wrap=CLAMP)


def oak():
    rng, tile = random.Random(401), (1.0, 2.0)
    wood = Primitive(_bark_material("bark", grounds.bark().halved()))
    foliage = Primitive(_leaf_material("oak leaves", leaves.oak()))
    trunk = [(0.0, -0.3, 0.0), (0.02, 0.4, 0.0), (0.06, 1.6, 0.05), (-0.05, 3.2, 0.1), (0.05, 5.2, 0.0), (0.1, 7.2, 0.0)]
    tube(wood, trunk, [0.52, 0.36, 0.29, 0.25, 0.17, 0.05], 8, tile)
    lobes = [((0.1, 7.0, 0.0), (2.1, 1.9, 2.1)), ((0.0, 5.2, 0.0), (2.6, 1.8, 2.6))]
    for i in range(7):
        angle = math.tau * (i + 0.35 * rng.random()) / 7
        reach, height = 2.1 + 0.5 * rng.random(), 3.9 + 1.9 * ((i * 3) % 7) / 7 + 0.3 * rng.random()
        end = (reach * math.cos(angle), height, reach * math.sin(angle))
        base = 2.3 + 0.35 * (height - 3.5) + 0.4 * rng.random()
        _limb(wood, rng, (0.0, base, 0.06), end, 0.13, 5, tile)
        size = 1.25 + 0.3 * rng.random()
        lobes.append((end, (size, 0.85 * size, size)))
    crown = Crown((0.0, 5.4, 0.0), (3.7, 3.5, 3.7), lobes)
    _leaf_cards(foliage, rng, crown, 240, 1.55)
    return Model("oak", [wood, foliage])


def birch():
    rng, tile = random.Random(411), (0.8, 0.8)
    wood = Primitive(_bark_material("birch bark", grounds.birch_bark()))
    foliage = Primitive(_leaf_material("birch leaves", leaves.birch()))
    trunk = [(0.0, -0.3, 0.0), (0.0, 0.5, 0.0), (0.08, 2.6, 0.03), (0.02, 5.2, -0.06), (0.12, 8.0, 0.0), (0.1, 10.2, 0.04)]
    tube(wood, trunk, [0.22, 0.15, 0.13, 0.105, 0.065, 0.02], 8, tile)
    lobes = [((0.1, 9.4, 0.0), (0.8, 1.4, 0.8)), ((0.1, 7.5, 0.0), (1.25, 1.8, 1.25)), ((0.05, 5.5, 0.0), (1.45, 1.8, 1.45))]
    for i in range(8):
        angle = 2.4 * i + 0.5 * rng.random()
        height = 3.6 + 5.0 * i / 8
        reach = 1.45 - 0.09 * i
        end = (reach * math.cos(angle), height, reach * math.sin(angle))
        _limb(wood, rng, (0.06, height - 0.9, 0.0), end, 0.05, 4, tile, rise=0.5)
        lobes.append(((end[0], end[1] - 0.3, end[2]), (0.75, 1.0, 0.75)))
    crown = Crown((0.08, 6.6, 0.0), (2.1, 4.4, 2.1), lobes)
    _leaf_cards(foliage, rng, crown, 285, 1.15, sag=0.4)
    return Model("birch", [wood, foliage])


def bush():
    rng = random.Random(421)
    foliage = Primitive(_leaf_material("bush leaves", leaves.oak()))
    lobes = [((0.0, 0.85, 0.0), (0.75, 0.6, 0.75))]
    for i in range(6):
        angle = math.tau * (i + 0.4 * rng.random()) / 6
        lobes.append(((0.6 * math.cos(angle), 0.48 + 0.22 * rng.random(), 0.6 * math.sin(angle)), (0.45, 0.42, 0.45)))
    crown = Crown((0.0, 0.55, 0.0), (1.1, 0.95, 1.1), lobes)
    _leaf_cards(foliage, rng, crown, 120, 0.75)
    return Model("bush", [foliage])


def _branch(primitive, root, heading, length, width, drop, turn, shade):
    """A spruce branch: two quads, the outer one hanging more; `turn` leans it about its own length."""
    out = (math.cos(heading), 0.0, math.sin(heading))
    side = unit(add((-out[2], 0.0, out[0]), (0.0, turn, 0.0)))
    middle = add(root, add(mul(out, 0.55 * length), (0.0, -0.40 * drop, 0.0)))
    tip = add(root, add(mul(out, length), (0.0, -drop, 0.0)))
    rows = []
    for k, point in enumerate((root, middle, tip)):
        t = (0.0, 0.5, 1.0)[k]
        half = width * (0.34, 0.5, 0.42)[k]
        row = []
        for s in (-1.0, 1.0):
            p = add(point, add(mul(side, half * s), (0.0, -0.10 * width * (t + 0.3), 0.0)))
            p = (p[0], max(0.05, p[1]), p[2])
            normal = unit(add(add(out, mul(side, 0.45 * s)), (0.0, 0.40, 0.0)))
            row.append(primitive.add(p, normal, (0.5 + 0.5 * s, t), shade * (0.50 + 0.50 * t)))
        rows.append(row)
    for near, far in zip(rows, rows[1:]):
        primitive.triangle(near[0], near[1], far[1])
        primitive.triangle(near[0], far[1], far[0])


def spruce():
    rng, height = random.Random(431), 14.0
    wood = Primitive(_bark_material("bark", grounds.bark().halved()))
    needles = Primitive(_leaf_material("spruce branches", leaves.spruce()))
    tube(wood, [(0, -0.3, 0), (0, 0.6, 0), (0.05, 6.0, 0), (0, 13.4, 0)], [0.30, 0.21, 0.14, 0.015], 7, (1.0, 2.0))
    whorls, heading = 17, 0.0
    for k in range(whorls):
        t = k / (whorls - 1)
        y = 2.6 + (height - 3.1) * t**0.92
        reach = (2.75 * (1.0 - t) ** 0.85 + 0.38) * (0.94 + 0.12 * rng.random())
        count = max(4, round(9 - 5 * t))
        heading += 0.9
        for i in range(count):
            length = reach * (0.85 + 0.28 * rng.random())
            at = heading + math.tau * (i + 0.35 * rng.random()) / count
            width = 0.35 + 0.62 * length
            drop = min(length * (0.72 + 0.25 * t + 0.2 * rng.random()), y - 0.25)
            root = (0.0, y + 0.2 * rng.random(), 0.0)
            _branch(needles, root, at, length, width, drop, 0.35 * rng.gauss(0, 1), 0.85 + 0.15 * t)
    # The leader: two upright cards crossing, tip upwards.
    for heading in (0.4, 0.4 + math.pi / 2):
        side = (math.cos(heading), 0.0, math.sin(heading))
        ids = []
        for s, y, v in ((-1, 13.0, 0.45), (1, 13.0, 0.45), (1, height, 1.0), (-1, height, 1.0)):
            normal = unit(add(mul(side, 0.6 * s), (0.0, 0.8, 0.0)))
            ids.append(needles.add((side[0] * 0.3 * s, y, side[2] * 0.3 * s), normal, (0.5 + 0.28 * s, v), 1.0))
        needles.triangle(ids[0], ids[1], ids[2])
        needles.triangle(ids[0], ids[2], ids[3])
    return Model("spruce", [wood, needles])
