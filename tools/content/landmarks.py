"""What the sample game is about: beacons, their fire, and a gate."""

import math

import grounds
from glb import Material, Model, Primitive
from shapes import box, tube


def beacon():
    """A tapered round tower of pale stone, 5 m high, with logs in an iron basket on top."""
    stone = Primitive(Material("pale stone", color=(1.0, 0.96, 0.88), png=grounds.gravel().halved().to_png()))
    iron = Primitive(Material("basket", color=(0.06, 0.06, 0.065)))
    wood = Primitive(Material("logs", color=(0.34, 0.22, 0.12)))
    tube(stone, [(0, -1.5, 0), (0, 0.5, 0), (0, 4.4, 0), (0, 4.8, 0), (0, 5.0, 0)], [1.7, 1.6, 1.15, 1.35, 1.3], 20, (2.0, 2.0))
    tube(stone, [(0, 5.0, 0), (0, 5.001, 0)], [1.3, 0.01], 20, (2.0, 2.0))
    for i in range(10):
        angle = math.tau * i / 10
        x, z = math.cos(angle), math.sin(angle)
        tube(iron, [(0.75 * x, 5.0, 0.75 * z), (1.0 * x, 5.5, 1.0 * z), (1.1 * x, 6.1, 1.1 * z)], [0.035, 0.03, 0.02], 6)
    for y, radius in ((5.35, 0.93), (5.8, 1.05), (6.1, 1.1)):
        ring = [(radius * math.cos(math.tau * i / 24), y, radius * math.sin(math.tau * i / 24)) for i in range(25)]
        tube(iron, ring, [0.025] * 25, 5)
    for i in range(9):
        angle, y = 2.4 * i, 5.1 + 0.09 * i
        x, z = 0.75 * math.cos(angle), 0.75 * math.sin(angle)
        tube(wood, [(-x, y, -z), (x, y + 0.12, z)], [0.1, 0.085], 7)
    return Model("beacon", [stone, iron, wood])


def beacon_fire():
    """Flames as tall as a man and more, over the basket: to be seen for kilometres. Each is a twisted, pointed tongue."""
    hot = Primitive(Material("flames", color=(0.0, 0.0, 0.0), emissive=(1.0, 0.42, 0.08)))
    core = Primitive(Material("heart of the fire", color=(0.0, 0.0, 0.0), emissive=(1.0, 0.85, 0.4)))
    for i in range(9):
        angle = 2.4 * i
        out = 0.62 if i else 0.0
        height = 3.4 - 0.28 * (i % 4) - (0.5 if i else 0.0)
        points, radii = [], []
        for k in range(7):
            up = k / 6
            sway = 0.22 * math.sin(4.0 * up + 1.7 * i)
            reach = out * (1.0 - 0.75 * up) + sway * up
            points.append((reach * math.cos(angle + up), 5.15 + height * up, reach * math.sin(angle + up)))
            radii.append(0.34 * (1.0 - up) ** 0.8 + 0.01)
        tube(core if i == 0 else hot, points, radii, 8)
    return Model("beacon_fire", [hot, core])


def gate():
    """A field gate of five bars, 3 m wide, hung at the origin: it reaches to +x."""
    wood = Primitive(Material("gate wood", png=grounds.wood().to_png()))
    tile = (0.5, 1.0)
    box(wood, (0.0, 0.5, 0.0), (0.09, 1.0, 0.09), tile)
    box(wood, (2.95, 0.68, 0.0), (0.05, 0.55, 0.04), tile)
    for i in range(5):
        box(wood, (1.5, 0.25 + 0.23 * i, 0.0), (1.46, 0.05, 0.025), tile)
    for k in range(12):
        t = (k + 0.5) / 12
        box(wood, (0.1 + 2.8 * t, 0.25 + 0.92 * t, 0.045), (0.13, 0.045, 0.02), tile)
    return Model("gate", [wood])
