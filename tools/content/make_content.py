#!/usr/bin/env python3
"""Writes content/textures and content/models: the same bytes on every run. Needs only Python's standard library.

Usage: make_content.py [NAME ...]   names without their endings, such as `grass oak`; none: everything
"""

import os
import sys

sys.dont_write_bytecode = True

import facades
import grounds
import landmarks
import leaves
import moving
import props
import trees

CONTENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "content")

TEXTURES = {
    "grass": grounds.grass,
    "meadow": grounds.meadow,
    "rock": grounds.rock,
    "gravel": grounds.gravel,
    "asphalt": grounds.asphalt,
    "pavement": grounds.pavement,
    "water": grounds.water,
    "roof_red": grounds.roof_red,
    "roof_dark": grounds.roof_dark,
    "bark": grounds.bark,
    "facade_brick": facades.brick,
    "facade_plaster": facades.plaster,
    "facade_office": facades.office,
    "facade_glass": facades.glass,
    "facade_stone": facades.stone,
    "facade_shops": facades.shops,
    "leaves_oak": leaves.oak,
    "leaves_birch": leaves.birch,
    "leaves_spruce": leaves.spruce,
}

MODELS = {
    "oak": trees.oak,
    "birch": trees.birch,
    "spruce": trees.spruce,
    "bush": trees.bush,
    "street_lamp": props.street_lamp,
    "bench": props.bench,
    "barrel": props.barrel,
    "boulder": props.boulder,
    "beacon": landmarks.beacon,
    "beacon_fire": landmarks.beacon_fire,
    "gate": landmarks.gate,
    "bird": moving.bird,
    "cart": moving.cart,
    "flag": moving.flag,
}


def main(names):
    known = {**TEXTURES, **MODELS}
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; known: {', '.join(known)}", file=sys.stderr)
        return 2
    for name, make in known.items():
        if names and name not in names:
            continue
        if name in TEXTURES:
            path, data = os.path.join("textures", name + ".png"), make().to_png()
        else:
            path, data = os.path.join("models", name + ".glb"), make().to_glb()
        target = os.path.join(CONTENT, path)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        with open(target + ".new", "wb") as file:
            file.write(data)
        os.replace(target + ".new", target)
        print(f"content/{path}: {len(data):,} bytes", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
