"""A picture to draw on: sRGB colours in 0..255 as floats, repeating at its edges."""

import math

import png


def mixed(a, b, t):
    """Colour a towards b by t."""
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def scaled(color, factor):
    return tuple(c * factor for c in color)


class Canvas:
    """Covers size_m metres; rectangles and the like are given in metres, x to the right and y up from the lower edge."""

    def __init__(self, width, height, size_m, color):
        self.width, self.height = width, height
        self.size_m = size_m
        self.pixels = [color] * (width * height)

    # Whole picture -----------------------------------------------------------------------------------

    def shade(self, field, strength):
        """Brightness times 1 + strength * field."""
        self.pixels = [
            (r * (f := 1.0 + strength * v), g * f, b * f) for (r, g, b), v in zip(self.pixels, field)
        ]

    def tint(self, field, color, strength):
        """Towards `color` where the field is positive: by strength * field, at most 1."""
        self.pixels = [
            mixed(p, color, min(1.0, strength * v)) if v > 0.0 else p for p, v in zip(self.pixels, field)
        ]

    def paint(self, function):
        """pixels = function(x_m, y_m, old colour), at pixel centres."""
        sx, sy = self.size_m[0] / self.width, self.size_m[1] / self.height
        w, h, old = self.width, self.height, self.pixels
        self.pixels = [
            function((x + 0.5) * sx, (h - y - 0.5) * sy, old[y * w + x]) for y in range(h) for x in range(w)
        ]

    # Shapes --------------------------------------------------------------------------------------------

    def blend(self, x, y, color, alpha):
        """One pixel (column, row from the top), wrapped."""
        at = (y % self.height) * self.width + x % self.width
        self.pixels[at] = mixed(self.pixels[at], color, alpha)

    def _spans(self, low, high, scale):
        first, last = low * scale, high * scale
        for i in range(math.floor(first), math.ceil(last)):
            cover = min(last, i + 1) - max(first, i)
            if cover > 0.0:
                yield i, cover

    def rect(self, x0, y0, x1, y1, color, alpha=1.0, top=None):
        """A rectangle with soft pixel edges; `top`: its colour at the upper edge, `color` being the lower one's."""
        sx, sy = self.width / self.size_m[0], self.height / self.size_m[1]
        columns = list(self._spans(x0, x1, sx))
        for row, cover_y in self._spans(self.size_m[1] - y1, self.size_m[1] - y0, sy):
            ink = color
            if top is not None:
                height = ((self.height - row - 0.5) / sy - y0) / (y1 - y0)
                ink = mixed(color, top, min(1.0, max(0.0, height)))
            for column, cover_x in columns:
                self.blend(column, row, ink, alpha * cover_x * cover_y)

    def frame(self, x0, y0, x1, y1, thickness, color, alpha=1.0):
        """The border just inside a rectangle."""
        t = thickness
        self.rect(x0, y0, x1, y0 + t, color, alpha)
        self.rect(x0, y1 - t, x1, y1, color, alpha)
        self.rect(x0, y0 + t, x0 + t, y1 - t, color, alpha)
        self.rect(x1 - t, y0 + t, x1, y1 - t, color, alpha)

    def streak(self, x0, x1, y_top, length, color, alpha):
        """What rain leaves below a ledge: dark above, fading downwards."""
        steps = 8
        for i in range(steps):
            upper, lower = y_top - length * i / steps, y_top - length * (i + 1) / steps
            self.rect(x0, lower, x1, upper, color, alpha * (1.0 - i / steps) ** 1.5)

    def stroke(self, x, y, dx, dy, length, root, tip, alpha=0.9):
        """A thin line of `length` pixels along (dx, dy) from pixel (x, y), with weights shared by two pixels."""
        for i in range(int(length)):
            t = i / length
            px, py = x + dx * i, y + dy * i
            column, row = math.floor(px), math.floor(py)
            ink = mixed(root, tip, t)
            part = px - column
            self.blend(column, row, ink, alpha * (1.0 - part))
            self.blend(column + 1, row, ink, alpha * part)

    # Out -----------------------------------------------------------------------------------------------

    def halved(self):
        """Half the size, each pixel the mean of four."""
        w = self.width
        small = Canvas(w // 2, self.height // 2, self.size_m, (0, 0, 0))
        small.pixels = [
            tuple(sum(channel) / 4.0 for channel in zip(*(self.pixels[at + d] for d in (0, 1, w, w + 1))))
            for y in range(0, self.height, 2)
            for at in range(y * w, y * w + w, 2)
        ]
        return small

    def to_png(self):
        data = bytearray()
        for pixel in self.pixels:
            data.extend(0 if c < 0.0 else 255 if c > 255.0 else int(c + 0.5) for c in pixel)
        return png.encode(self.width, self.height, 3, data)
