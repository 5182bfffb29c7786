"""Street furniture and a boulder."""

import math

import grounds
from glb import Material, Model, Primitive
from noise import value_noise
from shapes import add, box, cross, sub, tube, unit


def street_lamp():
    """A tapered pole, an arm that bows out to +x, and a lamp head below its end."""
    iron = Primitive(Material("painted iron", color=(0.075, 0.085, 0.085)))
    lens = Primitive(Material("lens", color=(0.62, 0.60, 0.54), emissive=(0.10, 0.09, 0.07)))
    tube(iron, [(0, -0.2, 0), (0, 0.06, 0)], [0.17, 0.17], 12)
    tube(iron, [(0, 0.06, 0), (0, 0.12, 0), (0, 0.75, 0), (0, 0.85, 0)], [0.17, 0.12, 0.10, 0.065], 12)
    tube(iron, [(0, 0.85, 0), (0, 2.5, 0), (0, 4.0, 0)], [0.065, 0.055, 0.045], 12)
    arc = [(0.0, 4.0, 0.0)]
    for i in range(1, 7):
        angle = math.pi / 2 * i / 6
        arc.append((0.85 * (1 - math.cos(angle)), 4.0 + 0.92 * math.sin(angle), 0.0))
    arc.append((1.15, 4.93, 0.0))
    tube(iron, arc, [0.045 - 0.002 * i for i in range(len(arc))], 8)
    tube(iron, [(1.1, 5.0, 0), (1.1, 4.95, 0), (1.1, 4.84, 0)], [0.02, 0.10, 0.21], 12)
    tube(lens, [(1.1, 4.84, 0), (1.1, 4.78, 0), (1.1, 4.75, 0)], [0.19, 0.13, 0.001], 12)
    box(iron, (0.0, 0.45, 0.10), (0.05, 0.16, 0.012))
    return Model("street_lamp", [iron, lens])


def bench():
    """1.8 m long, looking towards +z: slats on two cast frames with arm rests."""
    wood = Primitive(Material("slats", png=grounds.wood().to_png()))
    iron = Primitive(Material("cast iron", color=(0.06, 0.065, 0.065)))
    tile = (0.5, 1.0)
    for i in range(5):
        box(wood, (0.0, 0.45 - 0.004 * abs(i - 2), -0.18 + 0.105 * i), (0.9, 0.018, 0.045), tile)
    for i in range(4):
        y = 0.56 + 0.105 * i
        box(wood, (0.0, y, -0.25 - 0.22 * (y - 0.45)), (0.9, 0.042, 0.016), tile, lean=-0.21)
    for x in (-0.72, 0.72):
        tube(iron, [(x, 0.0, 0.27), (x, 0.25, 0.23), (x, 0.42, 0.25)], [0.03, 0.022, 0.026], 6)
        tube(iron, [(x, 0.0, -0.34), (x, 0.25, -0.25), (x, 0.45, -0.24), (x, 0.93, -0.37)], [0.03, 0.022, 0.026, 0.018], 6)
        tube(iron, [(x, 0.42, 0.27), (x, 0.415, -0.25)], [0.024, 0.024], 6)
        tube(iron, [(x, 0.42, 0.25), (x, 0.62, 0.24), (x, 0.66, 0.16), (x, 0.66, -0.29)], [0.022, 0.02, 0.024, 0.02], 6)
        for z in (0.27, -0.34):
            box(iron, (x, 0.012, z), (0.045, 0.014, 0.05))
    return Model("bench", [wood, iron])


def barrel():
    """Of staves with four hoops, 0.9 m high, about its middle, so that it can roll."""
    wood = Primitive(Material("staves", png=grounds.wood().to_png()))
    iron = Primitive(Material("hoops", color=(0.10, 0.09, 0.085)))

    def radius(y):
        return 0.36 - 0.10 * (y / 0.45) ** 2

    heights = [-0.45 + 0.15 * i for i in range(7)]
    tube(wood, [(0.0, y, 0.0) for y in heights], [radius(y) for y in heights], 20, (0.5, 1.0))
    for end in (-1.0, 1.0):
        y = 0.42 * end
        rim = [wood.add((radius(y) * math.cos(a), y, radius(y) * math.sin(a)), (0.0, end, 0.0),
                        (math.cos(a), math.sin(a))) for a in (math.tau * i / 20 for i in range(20))]
        middle = wood.add((0.0, y, 0.0), (0.0, end, 0.0), (0.0, 0.0))
        for a, b in zip(rim, rim[1:] + rim[:1]):
            wood.triangle(middle, b, a) if end > 0 else wood.triangle(middle, a, b)
    for y in (-0.38, -0.17, 0.17, 0.38):
        tube(iron, [(0.0, y - 0.025, 0.0), (0.0, y + 0.025, 0.0)],
             [radius(y - 0.025) + 0.008, radius(y + 0.025) + 0.008], 20)
    return Model("barrel", [wood, iron])


def _icosphere(levels):
    """Unit vertices and triangles of an icosahedron whose edges were halved `levels` times."""
    g = (1.0 + math.sqrt(5.0)) / 2.0
    points = [unit(p) for p in (
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g),
        (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1),
    )]
    faces = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
        (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]
    for _ in range(levels):
        halves, finer = {}, []

        def half(a, b):
            key = (min(a, b), max(a, b))
            if key not in halves:
                halves[key] = len(points)
                points.append(unit(add(points[a], points[b])))
            return halves[key]

        for a, b, c in faces:
            ab, bc, ca = half(a, b), half(b, c), half(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return points, faces


def boulder():
    """A sphere cut by planes and roughened, 1.6 m wide, sunk a little; textured from the three axes."""
    stone = Primitive(Material("rock", png=grounds.rock().halved().to_png()))
    points, faces = _icosphere(2)
    bumps = value_noise(64, 64, 8, 8, 441)
    cuts = [(unit((math.cos(2.4 * i), 0.9 * math.cos(1.7 * i), math.sin(2.4 * i))), 0.72 + 0.05 * (i % 4)) for i in range(11)]
    shaped = []
    for p in points:
        reach = 1.0
        for normal, distance in cuts:
            facing = p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2]
            if facing > 0.05:
                reach = min(reach, distance / facing)
        u, v = int(math.atan2(p[2], p[0]) / math.tau * 64) % 64, int((p[1] + 1.0) * 31.9)
        reach *= 0.97 + 0.07 * bumps[v * 64 + u]
        shaped.append((0.98 * p[0] * reach, 0.78 * p[1] * reach + 0.42, 0.84 * p[2] * reach))
    normals = [(0.0, 0.0, 0.0)] * len(shaped)
    areas = []
    for face in faces:
        a, b, c = (shaped[i] for i in face)
        area = cross(sub(b, a), sub(c, a))
        areas.append(area)
        for i in face:
            normals[i] = add(normals[i], area)
    made = {}
    for face, area in zip(faces, areas):
        if all(shaped[i][1] < -0.12 for i in face):
            continue  # under the ground
        axis = max(range(3), key=lambda i: abs(area[i]))
        ids = []
        for i in face:
            if (i, axis) not in made:
                p = shaped[i]
                uv = (p[(axis + 1) % 3] / 1.4, -p[(axis + 2) % 3] / 1.4)
                made[i, axis] = stone.add(p, unit(normals[i]), uv)
            ids.append(made[i, axis])
        stone.triangle(*ids)
    return Model("boulder", [stone])
