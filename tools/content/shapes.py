"""Vectors as tuples, and the shapes that models are put together from. Metres, y up, faces counter-clockwise."""

import math


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return mul(a, 1.0 / length) if length > 1e-12 else (0.0, 1.0, 0.0)


def perpendicular(direction):
    """Two unit vectors that make a right-handed frame (u, v, direction)."""
    helper = (1.0, 0.0, 0.0) if abs(direction[0]) < 0.8 else (0.0, 0.0, 1.0)
    u = unit(cross(helper, direction))
    return u, cross(direction, u)


def tube(primitive, points, radii, sides, texture_m=None):
    """A round tube along `points` with smooth normals. One texture tile covers texture_m = (round it, along it)."""
    direction = unit(sub(points[1], points[0]))
    u, _ = perpendicular(direction)
    rings, along = [], 0.0
    around = max(1, round(math.tau * max(radii) / texture_m[0])) if texture_m else 1
    for k, (point, radius) in enumerate(zip(points, radii)):
        before, after = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
        direction = unit(sub(after, before))
        u = unit(sub(u, mul(direction, dot(u, direction))))  # carried along without twist
        v = cross(direction, u)
        if k:
            step = sub(point, points[k - 1])
            along += math.sqrt(dot(step, step))
        ring = []
        for i in range(sides + 1):
            angle = math.tau * i / sides
            normal = add(mul(u, math.cos(angle)), mul(v, math.sin(angle)))
            uv = (around * i / sides, -along / texture_m[1]) if texture_m else (0.0, 0.0)
            ring.append(primitive.add(add(point, mul(normal, radius)), normal, uv))
        rings.append(ring)
    for low, high in zip(rings, rings[1:]):
        for i in range(sides):
            primitive.triangle(low[i], low[i + 1], high[i + 1])
            primitive.triangle(low[i], high[i + 1], high[i])


def box(primitive, center, half, tile_m=None, turn=0.0, lean=0.0):
    """A box; `turn` about y, then `lean` about x tilted before it, in radians. Flat normals."""
    ct, st, cl, sl = math.cos(turn), math.sin(turn), math.cos(lean), math.sin(lean)

    def rotated(p):
        x, y, z = p[0], p[1] * cl - p[2] * sl, p[1] * sl + p[2] * cl
        return (x * ct + z * st, y, z * ct - x * st)

    for axis in range(3):
        for sign in (-1.0, 1.0):
            n, a, b = [0.0] * 3, [0.0] * 3, [0.0] * 3
            n[axis] = sign
            a[(axis + 1) % 3] = 1.0
            b[(axis + 2) % 3] = sign
            corners = []
            for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                local = tuple(half[i] * (n[i] + s * a[i] + t * b[i]) for i in range(3))
                # The grain runs along the longest side: v follows it.
                long_axis = half.index(max(half))
                flat = [local[i] for i in range(3) if i != axis and i != long_axis] or [0.0]
                uv = (flat[0] / tile_m[0] + 0.37 * center[1], local[long_axis] / tile_m[1]) if tile_m else (0.0, 0.0)
                corners.append(primitive.add(add(center, rotated(local)), rotated(tuple(n)), uv))
            primitive.triangle(corners[0], corners[1], corners[2])
            primitive.triangle(corners[0], corners[2], corners[3])
