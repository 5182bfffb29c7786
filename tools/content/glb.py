"""Writes glTF 2.0 binary files. Source: Khronos, "glTF 2.0 Specification", sections 3.6 to 3.9 and 4 (GLB)."""

import json
import struct

_FLOAT, _USHORT, _UBYTE = 5126, 5123, 5121
_ARRAY, _ELEMENTS = 34962, 34963
REPEAT, CLAMP = 10497, 33071


class Material:
    """Rough and not metallic. `png`: base colour image in bytes, or None; `mask`: alpha cutoff 0.5, seen from both sides."""

    def __init__(self, name, color=(1.0, 1.0, 1.0), png=None, mask=False, wrap=REPEAT, emissive=None, two_sided=False):
        self.name, self.color, self.png = name, color, png
        self.mask, self.wrap, self.emissive, self.two_sided = mask, wrap, emissive, two_sided


class Primitive:
    """Triangles of one material. A vertex is (position, normal, uv) or (position, normal, uv, brightness in 0..1)."""

    def __init__(self, material):
        self.material = material
        self.vertices, self.indices = [], []
        self.weights = []  # of a skinned model, a vertex each: [(joint, weight), ..], at most four

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
    if len(vertices[0]) >= 4:
        shades = b"".join(bytes((round(255 * v[3]),) * 3 + (255,)) for v in vertices)
        attributes["COLOR_0"] = buffer.accessor(shades, _ARRAY, _UBYTE, "VEC4", count, normalized=True)
    return attributes


def _influences(buffer, weights):
    padded = [(list(w) + [(0, 0.0)] * 4)[:4] for w in weights]
    joints = b"".join(bytes(joint for joint, _ in w) for w in padded)
    shares = b"".join(bytes(_unorm8([share for _, share in w])) for w in padded)
    return {
        "JOINTS_0": buffer.accessor(joints, _ARRAY, _UBYTE, "VEC4", len(weights)),
        "WEIGHTS_0": buffer.accessor(shares, _ARRAY, _UBYTE, "VEC4", len(weights), normalized=True),
    }


def _unorm8(shares):
    """Bytes that sum to 255 exactly, as glTF asks of weights."""
    out = [round(255 * share) for share in shares]
    out[out.index(max(out))] += 255 - sum(out)
    return out


class _Document:
    """A glTF document while meshes are added to it."""

    def __init__(self):
        self.buffer, self.images, self.textures, self.samplers, self.materials = _Buffer(), [], [], [], []

    def mesh(self, name, primitives):
        """The glTF mesh of a list of primitives."""
        buffer, parts = self.buffer, []
        for primitive in primitives:
            m = primitive.material
            pbr = {"baseColorFactor": [*m.color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
            if m.png is not None:
                self.images.append({"bufferView": buffer.view(m.png), "mimeType": "image/png"})
                self.samplers.append({"magFilter": 9729, "minFilter": 9987, "wrapS": m.wrap, "wrapT": m.wrap})
                self.textures.append({"source": len(self.images) - 1, "sampler": len(self.samplers) - 1})
                pbr["baseColorTexture"] = {"index": len(self.textures) - 1}
            material = {"name": m.name, "pbrMetallicRoughness": pbr}
            if m.mask:
                material |= {"alphaMode": "MASK", "alphaCutoff": 0.5}
            if m.mask or m.two_sided:
                material["doubleSided"] = True
            if m.emissive:
                material["emissiveFactor"] = list(m.emissive)
            self.materials.append(material)
            indices = struct.pack(f"<{len(primitive.indices)}H", *primitive.indices)
            attributes = _attributes(buffer, primitive.vertices)
            if primitive.weights:
                attributes |= _influences(buffer, primitive.weights)
            parts.append({
                "attributes": attributes,
                "indices": buffer.accessor(indices, _ELEMENTS, _USHORT, "SCALAR", len(primitive.indices)),
                "material": len(self.materials) - 1,
            })
        return {"name": name, "primitives": parts}

    def to_glb(self, roots, nodes, meshes, **more):
        """GLB bytes. `more`: further top-level members, where not empty."""
        buffer = self.buffer
        buffer.bytes += bytes(-len(buffer.bytes) % 4)
        document = {
            "asset": {"version": "2.0", "generator": "Farfield content", "copyright": "CC0 1.0"},
            "scene": 0,
            "scenes": [{"nodes": roots}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": self.materials,
            "accessors": buffer.accessors,
            "bufferViews": buffer.views,
            "buffers": [{"byteLength": len(buffer.bytes)}],
        }
        if self.images:
            document |= {"images": self.images, "textures": self.textures, "samplers": self.samplers}
        document |= {key: value for key, value in more.items() if value}
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(buffer.bytes), b"BIN\0") + bytes(buffer.bytes)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def encode(name, primitives):
    """GLB bytes of one node with one mesh."""
    document = _Document()
    meshes = [document.mesh(name, primitives)]
    return document.to_glb([0], [{"name": name, "mesh": 0}], meshes)


class Model:
    """A named list of primitives."""

    def __init__(self, name, primitives):
        self.name, self.primitives = name, primitives

    def triangles(self):
        return sum(len(p.indices) for p in self.primitives) // 3

    def to_glb(self):
        return encode(self.name, self.primitives)


class Node:
    """A node of an animated model: where it stands in its parent, and what it shows."""

    def __init__(self, name, translation=(0.0, 0.0, 0.0), parent=None, primitives=()):
        self.name, self.translation, self.parent = name, translation, parent
        self.primitives = list(primitives)  # of a skinned model: of the first node alone, in model space


class AnimatedModel:
    """Nodes, parents before children, and clips: {name: [(node's name, "rotation" or "translation", times, values)]}.

    `joints`: names of nodes that the first node's vertices follow by Primitive.weights, bound where the nodes stand.
    """

    def __init__(self, name, nodes, clips, joints=()):
        self.name, self.nodes, self.clips, self.joints = name, nodes, clips, list(joints)

    def to_glb(self):
        document, buffer = _Document(), None
        buffer = document.buffer
        index = {node.name: i for i, node in enumerate(self.nodes)}
        meshes, nodes, places = [], [], []
        for node in self.nodes:
            entry = {"name": node.name}
            if node.translation != (0.0, 0.0, 0.0):
                entry["translation"] = list(node.translation)
            children = [index[child.name] for child in self.nodes if child.parent == node.name]
            if children:
                entry["children"] = children
            if node.primitives:
                meshes.append(document.mesh(node.name, node.primitives))
                entry["mesh"] = len(meshes) - 1
            base = places[index[node.parent]] if node.parent else (0.0, 0.0, 0.0)
            places.append(tuple(a + b for a, b in zip(base, node.translation)))
            nodes.append(entry)
        skins = []
        if self.joints:
            binds = b"".join(
                struct.pack("<16f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-c for c in places[index[joint]]), 1)
                for joint in self.joints
            )
            matrices = buffer.accessor(binds, None, _FLOAT, "MAT4", len(self.joints))
            skins.append({"joints": [index[joint] for joint in self.joints], "inverseBindMatrices": matrices})
            nodes[0]["skin"] = 0
        animations = [self._animation(buffer, name, tracks, index) for name, tracks in self.clips.items()]
        roots = [i for i, node in enumerate(self.nodes) if node.parent is None]
        return document.to_glb(roots, nodes, meshes, skins=skins, animations=animations)

    @staticmethod
    def _animation(buffer, name, tracks, index):
        samplers, channels = [], []
        for node, path, times, values in tracks:
            kind = "VEC4" if path == "rotation" else "VEC3"
            single = [struct.unpack("<f", struct.pack("<f", t))[0] for t in times]
            samplers.append({
                "input": buffer.accessor(struct.pack(f"<{len(times)}f", *times), None, _FLOAT, "SCALAR", len(times),
                                         min=[min(single)], max=[max(single)]),
                "output": buffer.accessor(_floats(values), None, _FLOAT, kind, len(values)),
            })
            channels.append({"sampler": len(samplers) - 1, "target": {"node": index[node], "path": path}})
        return {"name": name, "samplers": samplers, "channels": channels}
