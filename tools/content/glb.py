"""Writes glTF 2.0 binary files. Source: Khronos, "glTF 2.0 Specification", sections 3.6 to 3.9 and 4 (GLB)."""

import json
import struct

_FLOAT, _USHORT, _UBYTE = 5126, 5123, 5121
_ARRAY, _ELEMENTS = 34962, 34963
REPEAT, CLAMP = 10497, 33071


class Material:
    """Rough and not metallic. `png`: base colour image in bytes, or None; `mask`: alpha cutoff 0.5, seen from both sides."""

    def __init__(self, name, color=(1.0, 1.0, 1.0), png=None, mask=False, wrap=REPEAT, emissive=None):
        self.name, self.color, self.png = name, color, png
        self.mask, self.wrap, self.emissive = mask, wrap, emissive


class Primitive:
    """Triangles of one material. A vertex is (position, normal, uv) or (position, normal, uv, brightness in 0..1)."""

    def __init__(self, material):
        self.material = material
        self.vertices, self.indices = [], []

    def add(self, *vertex):
        self.vertices.append(vertex)
        return len(self.vertices) - 1

    def triangle(self, a, b, c):
        self.indices += (a, b, c)


class _Buffer:
    def __init__(self):
        self.bytes, self.views, self.accessors = bytearray(), [], []

    def view(self, data, target=None):
        self.bytes += bytes(-len(self.bytes) % 4)
        entry = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)}
        if target:
            entry["target"] = target
        self.bytes += data
        self.views.append(entry)
        return len(self.views) - 1

    def accessor(self, data, target, component, kind, count, **more):
        view = self.view(data, target)
        self.accessors.append(
            {"bufferView": view, "componentType": component, "type": kind, "count": count, **more}
        )
        return len(self.accessors) - 1


def _floats(rows):
    return b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)


def _attributes(buffer, vertices):
    count, positions = len(vertices), [tuple(struct.unpack("<3f", struct.pack("<3f", *v[0]))) for v in vertices]
    attributes = {
        "POSITION": buffer.accessor(
            _floats(positions), _ARRAY, _FLOAT, "VEC3", count,
            min=[min(axis) for axis in zip(*positions)], max=[max(axis) for axis in zip(*positions)],
        ),
        "NORMAL": buffer.accessor(_floats(v[1] for v in vertices), _ARRAY, _FLOAT, "VEC3", count),
        "TEXCOORD_0": buffer.accessor(_floats(v[2] for v in vertices), _ARRAY, _FLOAT, "VEC2", count),
    }
    if len(vertices[0]) == 4:
        shades = b"".join(bytes((round(255 * v[3]),) * 3 + (255,)) for v in vertices)
        attributes["COLOR_0"] = buffer.accessor(shades, _ARRAY, _UBYTE, "VEC4", count, normalized=True)
    return attributes


def encode(name, primitives):
    """GLB bytes of one node with one mesh."""
    buffer, images, textures, samplers, materials, parts = _Buffer(), [], [], [], [], []
    for primitive in primitives:
        m = primitive.material
        pbr = {"baseColorFactor": [*m.color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        if m.png is not None:
            images.append({"bufferView": buffer.view(m.png), "mimeType": "image/png"})
            samplers.append({"magFilter": 9729, "minFilter": 9987, "wrapS": m.wrap, "wrapT": m.wrap})
            textures.append({"source": len(images) - 1, "sampler": len(samplers) - 1})
            pbr["baseColorTexture"] = {"index": len(textures) - 1}
        material = {"name": m.name, "pbrMetallicRoughness": pbr}
        if m.mask:
            material |= {"alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": True}
        if m.emissive:
            material["emissiveFactor"] = list(m.emissive)
        materials.append(material)
        indices = struct.pack(f"<{len(primitive.indices)}H", *primitive.indices)
        parts.append({
            "attributes": _attributes(buffer, primitive.vertices),
            "indices": buffer.accessor(indices, _ELEMENTS, _USHORT, "SCALAR", len(primitive.indices)),
            "material": len(materials) - 1,
        })
    buffer.bytes += bytes(-len(buffer.bytes) % 4)
    document = {
        "asset": {"version": "2.0", "generator": "Farfield content", "copyright": "CC0 1.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [{"name": name, "primitives": parts}],
        "materials": materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.bytes)}],
    }
    if images:
        document |= {"images": images, "textures": textures, "samplers": samplers}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(buffer.bytes), b"BIN\0") + bytes(buffer.bytes)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class Model:
    """A named list of primitives."""

    def __init__(self, name, primitives):
        self.name, self.primitives = name, primitives

    def triangles(self):
        return sum(len(p.indices) for p in self.primitives) // 3

    def to_glb(self):
        return encode(self.name, self.primitives)
