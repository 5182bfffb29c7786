"""Things that move of themselves: a bird (skin), a cart (nodes), a flag (skin)."""

import math

import grounds
from glb import AnimatedModel, Material, Node, Primitive
from shapes import box, mul, tube


def _turn(axis, angle):
    """Quaternion (x, y, z, w)."""
    s = math.sin(angle / 2)
    return (axis[0] * s, axis[1] * s, axis[2] * s, math.cos(angle / 2))


def _product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def _samples(seconds, rate, value):
    """Times and values of `value(part of the clip)`; the last repeats the first, so that the clip can loop."""
    count = round(seconds * rate)
    return [seconds * i / count for i in range(count + 1)], [value(i / count) for i in range(count + 1)]


def _between(along, joints):
    """Weights of a chain of joints at places `joints` (ascending) for a point `along` it."""
    if along <= joints[0][0]:
        return [(joints[0][1], 1.0)]
    for (a, first), (b, second) in zip(joints, joints[1:]):
        if along <= b and first == second:
            return [(first, 1.0)]
        if along <= b:
            t = (along - a) / (b - a)
            t = t * t * (3 - 2 * t)
            return [(first, 1 - t), (second, t)]
    return [(joints[-1][1], 1.0)]


def bird():
    """A gull, 1.1 m across. `circle`: it flies round its origin 36 m away and 24 m up, eight flaps, then a glide;
    `flap`: the same wings where its origin is, for flocks that somebody moves."""
    white = Primitive(Material("down", color=(0.74, 0.74, 0.72), two_sided=True))
    grey = Primitive(Material("wing", color=(0.30, 0.32, 0.35), two_sided=True))
    # Joints: 0 body, 1 and 2 the left wing, 3 and 4 the right one.
    body = [((0.0, 0.0, -0.30), 0.012), ((0.0, 0.02, -0.24), 0.045), ((0.0, 0.015, -0.12), 0.075),
            ((0.0, 0.0, 0.02), 0.07), ((0.0, 0.0, 0.16), 0.04), ((0.0, 0.005, 0.30), 0.012)]
    tube(white, [p for p, _ in body], [r for _, r in body], 10)
    tail = [white.add(p, (0.0, 1.0, 0.0), (0.0, 0.0)) for p in ((-0.02, 0.005, 0.24), (0.02, 0.005, 0.24),
                                                              (0.09, 0.0, 0.42), (-0.09, 0.0, 0.42))]
    white.triangle(tail[0], tail[3], tail[2])
    white.triangle(tail[0], tail[2], tail[1])
    white.weights = [[(0, 1.0)]] * len(white.vertices)
    for side, inner, outer in ((-1.0, 1, 2), (1.0, 3, 4)):
        rows = []
        for i in range(10):
            s = i / 9
            x = 0.04 + 0.52 * s
            front, back = -0.10 - 0.05 * math.sin(math.pi * s) + 0.16 * s * s, 0.08 - 0.03 * s + 0.10 * s * s
            row = []
            for part in (0.0, 0.35, 0.7, 1.0):
                z = front + (back - front) * part
                p = (side * x, 0.03 + 0.025 * (1 - (2 * part - 0.7) ** 2) * (1 - s), z)
                row.append(grey.add(p, (0.0, 1.0, 0.0), (s, part)))
                grey.weights.append(_between(x, [(0.06, 0), (0.12, inner), (0.30, inner), (0.38, outer)]))
            rows.append(row)
        for a, b in zip(rows, rows[1:]):
            for i in range(3):
                quad = (a[i], a[i + 1], b[i + 1], b[i]) if side > 0 else (b[i], b[i + 1], a[i + 1], a[i])
                grey.triangle(quad[0], quad[1], quad[2])
                grey.triangle(quad[0], quad[2], quad[3])
    radius, height, seconds, rate = 36.0, 24.0, 20.0, 15

    def flap(part):
        """Wing lift in radians: eight flaps in the first half of the round, then held."""
        beat = math.sin(math.tau * 16 * part)
        strength = min(1.0, max(0.0, 6.0 * min(part, 0.5 - part))) if part < 0.5 else 0.0
        return 0.12 + 0.55 * beat * strength

    def place(part):
        a = math.tau * part
        return (radius * math.cos(a), height + 1.5 * math.sin(2 * a), radius * math.sin(a))

    def heading(part):
        # Flies along +a (towards +z at a = 0), nose at -z, banked into the turn.
        yaw = _turn((0.0, 1.0, 0.0), -math.tau * part + math.pi)
        return _product(yaw, _turn((0.0, 0.0, 1.0), -0.35))

    fast = 30
    wings = [
        ("wing.L", "rotation", *_samples(seconds, fast, lambda t: _turn((0, 0, 1), -flap(t)))),
        ("tip.L", "rotation", *_samples(seconds, fast, lambda t: _turn((0, 0, 1), -0.7 * (flap(t - 0.008) - 0.12)))),
        ("wing.R", "rotation", *_samples(seconds, fast, lambda t: _turn((0, 0, 1), flap(t)))),
        ("tip.R", "rotation", *_samples(seconds, fast, lambda t: _turn((0, 0, 1), 0.7 * (flap(t - 0.008) - 0.12)))),
    ]
    clips = {"circle": [
        ("body", "translation", *_samples(seconds, rate, place)),
        ("body", "rotation", *_samples(seconds, rate, heading)),
        *wings,
    ], "flap": wings}
    nodes = [Node("bird", primitives=[white, grey]), Node("body"),
             Node("wing.L", (-0.06, 0.03, 0.0), "body"), Node("tip.L", (-0.26, 0.0, 0.0), "wing.L"),
             Node("wing.R", (0.06, 0.03, 0.0), "body"), Node("tip.R", (0.26, 0.0, 0.0), "wing.R")]
    return AnimatedModel("bird", nodes, clips, ["body", "wing.L", "tip.L", "wing.R", "tip.R"])


def _wheel(iron, wood, radius):
    """A spoked wheel about the x axis."""
    rim = [(0.0, radius * math.cos(math.tau * i / 20), radius * math.sin(math.tau * i / 20)) for i in range(21)]
    tube(iron, rim, [0.045] * 21, 6)
    tube(wood, [(-0.09, 0.0, 0.0), (0.09, 0.0, 0.0)], [0.07, 0.07], 8)
    for i in range(8):
        a = math.tau * i / 8
        out = (0.0, math.cos(a), math.sin(a))
        tube(wood, [mul(out, 0.05), mul(out, radius - 0.02)], [0.025, 0.02], 5)


def cart():
    """A handcart that is pulled 40 m along -z and back, its wheels turning as far as it goes; 1.5 m wide."""
    png = grounds.wood().to_png()

    def materials():
        return Primitive(Material("boards", png=png)), Primitive(Material("iron", color=(0.09, 0.085, 0.08)))

    wood, iron = materials()
    tile = (0.5, 1.0)
    box(wood, (0.0, 0.72, 0.0), (0.55, 0.04, 0.95), tile)
    for x in (-0.53, 0.53):
        box(wood, (x, 0.93, 0.0), (0.025, 0.18, 0.95), tile)
        tube(wood, [(x, 0.70, -0.9), (x, 0.78, -1.9)], [0.035, 0.03], 6)
    for z in (-0.93, 0.93):
        box(wood, (0.0, 0.93, z), (0.55, 0.18, 0.025), tile)
    tube(wood, [(-0.55, 0.78, -1.85), (0.55, 0.78, -1.85)], [0.03, 0.03], 6)
    tube(iron, [(-0.72, 0.5, 0.0), (0.72, 0.5, 0.0)], [0.03, 0.03], 6)
    box(iron, (0.0, 0.6, 0.0), (0.06, 0.1, 0.06))
    wheel_wood, wheel_iron = materials()
    _wheel(wheel_iron, wheel_wood, 0.5)
    other_wood, other_iron = materials()
    _wheel(other_iron, other_wood, 0.5)
    seconds, reach = 40.0, 20.0

    def along(part):
        return -reach * math.sin(math.tau * part)

    def rolled(part):
        return _turn((1.0, 0.0, 0.0), along(part) / 0.5)

    # Between keys a wheel may turn a quarter at most, or it would seem to turn back.
    clips = {"roll": [
        ("cart", "translation", *_samples(seconds, 4, lambda t: (0.0, 0.0, along(t)))),
        ("wheel.L", "rotation", *_samples(seconds, 10, rolled)),
        ("wheel.R", "rotation", *_samples(seconds, 10, rolled)),
    ]}
    nodes = [Node("cart", primitives=[wood, iron]),
             Node("wheel.L", (-0.68, 0.5, 0.0), "cart", [wheel_wood, wheel_iron]),
             Node("wheel.R", (0.68, 0.5, 0.0), "cart", [other_wood, other_iron])]
    return AnimatedModel("cart", nodes, clips)


def flag():
    """A flag of 2.4 x 1.5 m on a pole of 9 m, in the wind along +x."""
    pole = Primitive(Material("pole", color=(0.62, 0.62, 0.60)))
    cloth = Primitive(Material("cloth", color=(0.55, 0.06, 0.05), two_sided=True))
    stripe = Primitive(Material("stripe", color=(0.80, 0.78, 0.70), two_sided=True))
    tube(pole, [(0, -0.3, 0), (0, 4.5, 0), (0, 9.0, 0)], [0.07, 0.055, 0.035], 10)
    tube(pole, [(0, 9.0, 0), (0, 9.06, 0), (0, 9.14, 0)], [0.04, 0.07, 0.01], 8)
    pole.weights = [[(0, 1.0)]] * len(pole.vertices)
    bones, length = 6, 2.4
    places = [(0.05 + length * i / bones, i) for i in range(bones + 1)]
    for part, low, high in ((cloth, 7.2, 7.7), (stripe, 7.7, 8.2), (cloth, 8.2, 8.7)):
        rows = []
        for i in range(25):
            x = 0.05 + length * i / 24
            rows.append([])
            for y in (low, high):
                rows[-1].append(part.add((x, y, 0.0), (0.0, 0.0, 1.0), (x, y)))
                part.weights.append(_between(x, places))
        for a, b in zip(rows, rows[1:]):
            part.triangle(a[0], b[0], b[1])
            part.triangle(a[0], b[1], a[1])
    seconds = 3.0
    tracks = []
    for i in range(1, bones + 1):
        def sway(t, i=i):
            swing = 0.20 + 0.05 * i
            turn = _turn((0, 1, 0), swing * math.sin(math.tau * (2 * t - 0.17 * i)))
            return _product(turn, _turn((0, 0, 1), -0.05 - 0.03 * math.sin(math.tau * (t - 0.1 * i))))
        tracks.append((f"cloth{i}", "rotation", *_samples(seconds, 15, sway)))
    nodes = [Node("flag", primitives=[pole, cloth, stripe]), Node("cloth0", (0.05, 8.0, 0.0))]
    for i in range(1, bones + 1):
        nodes.append(Node(f"cloth{i}", (length / bones, 0.0, 0.0), f"cloth{i - 1}"))
    return AnimatedModel("flag", nodes, {"wind": tracks}, [f"cloth{i}" for i in range(bones + 1)])
