"""Writes 8-bit PNG files (RGB or RGBA) with nothing but zlib.

Source: W3C, "Portable Network Graphics (PNG) Specification", sections 5 (chunks) and 9 (filters).
"""

import struct
import zlib

_MAGIC = b"\x89PNG\r\n\x1a\n"
_COLOR_TYPE = {3: 2, 4: 6}  # channels -> colour type: truecolour, truecolour with alpha


def _chunk(kind, payload):
    return struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))


def _filtered(row, above, step):
    """The row under the filter (none, sub, up or average) whose result has the smallest sum of magnitudes."""
    left = bytes(step) + row[:-step]
    candidates = (
        row,
        bytes((a - b) & 255 for a, b in zip(row, left)),
        bytes((a - b) & 255 for a, b in zip(row, above)),
        bytes((a - ((b + c) >> 1)) & 255 for a, b, c in zip(row, left, above)),
    )
    costs = [sum(v if v < 128 else 256 - v for v in candidate) for candidate in candidates]
    best = costs.index(min(costs))
    return bytes([best]) + candidates[best]


def encode(width, height, channels, data):
    """PNG bytes of `data`: rows from the top, `channels` (3 or 4) bytes a pixel, sRGB."""
    stride = width * channels
    if len(data) != stride * height:
        raise ValueError(f"{len(data)} bytes of pixels, {width}x{height}x{channels} needs {stride * height}")
    above, rows = bytes(stride), []
    for y in range(height):
        row = bytes(data[y * stride : (y + 1) * stride])
        rows.append(_filtered(row, above, channels))
        above = row
    header = struct.pack(">IIBBBBB", width, height, 8, _COLOR_TYPE[channels], 0, 0, 0)
    return (
        _MAGIC
        + _chunk(b"IHDR", header)
        + _chunk(b"sRGB", b"\0")
        + _chunk(b"IDAT", zlib.compress(b"".join(rows), 9))
        + _chunk(b"IEND", b"")
    )
