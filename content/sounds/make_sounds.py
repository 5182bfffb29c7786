#!/usr/bin/env python3
"""Writes the sample world's sounds beside itself: wind, water, a cart, a chime. One channel, 16 bits, 11025 Hz.

Everything is made of sines whose numbers of periods are whole in a recording that is repeated, so that its end meets its
beginning. The same numbers come out every time."""

import math
import pathlib
import random
import struct
import wave

RATE_HZ = 11025


def noise(random_numbers, count, low_hz, high_hz, tones):
    """A band of noise that repeats after `count` samples; louder low tones."""
    seconds = count / RATE_HZ
    out = [0.0] * count
    for _ in range(tones):
        periods = max(1, round(seconds * low_hz * (high_hz / low_hz) ** random_numbers.random()))
        phase, loud = 2 * math.pi * random_numbers.random(), (low_hz * seconds / periods) ** 0.5
        step = 2 * math.pi * periods / count
        for i in range(count):
            out[i] += loud * math.sin(phase + step * i)
    return out


def swell(count, periods, depth, phase=0.0):
    """A loudness that comes and goes, whole periods of it."""
    return [1 - depth * (0.5 + 0.5 * math.cos(2 * math.pi * periods * i / count + phase)) for i in range(count)]


def product(a, b):
    return [x * y for x, y in zip(a, b)]


def wind():
    numbers, count = random.Random(1), int(3.0 * RATE_HZ)
    hum = product(noise(numbers, count, 90, 420, 70), swell(count, 1, 0.6))
    whistle = product(noise(numbers, count, 500, 900, 30), swell(count, 2, 0.9, 1.0))
    return [h + 0.4 * w for h, w in zip(hum, whistle)]


def water():
    numbers, count = random.Random(2), int(2.6 * RATE_HZ)
    near = product(noise(numbers, count, 300, 2600, 110), swell(count, 2, 0.85))
    far = product(noise(numbers, count, 200, 1200, 60), swell(count, 3, 0.7, 2.0))
    return [a + 0.7 * b for a, b in zip(near, far)]


def cart():
    numbers, count = random.Random(3), int(1.6 * RATE_HZ)
    rumble = product(noise(numbers, count, 60, 300, 60), swell(count, 8, 0.7))
    out = [0.5 * r / 8 for r in rumble]
    for start_s, pitch_hz in ((0.15, 640), (0.75, 700), (1.05, 560)):
        first, length = int(start_s * RATE_HZ), int(0.28 * RATE_HZ)
        for i in range(length):  # a wheel that creaks, its pitch bending
            bend = pitch_hz * (1 + 0.15 * math.sin(math.pi * i / length))
            envelope = math.sin(math.pi * i / length) ** 2
            out[first + i] += 0.7 * envelope * math.copysign(abs(math.sin(2 * math.pi * bend * i / RATE_HZ)) ** 0.6,
                                                            math.sin(2 * math.pi * bend * i / RATE_HZ))
    return out


def chime():
    count = int(1.6 * RATE_HZ)
    out = [0.0] * count
    for pitch_hz, loud, decay_s, start_s in ((523.25, 1.0, 0.5, 0.0), (1413.0, 0.5, 0.25, 0.0), (2826.0, 0.2, 0.12, 0.0),
                                             (783.99, 0.9, 0.5, 0.22), (2117.0, 0.4, 0.2, 0.22)):
        first = int(start_s * RATE_HZ)
        for i in range(first, count):
            t = (i - first) / RATE_HZ
            attack = min(1.0, t / 0.004)
            out[i] += loud * attack * math.exp(-t / decay_s) * math.sin(2 * math.pi * pitch_hz * t)
    return [x * min(1.0, (count - i) / 400) for i, x in enumerate(out)]  # ends in silence


def write(name, samples):
    loudest = max(abs(x) for x in samples)
    data = b"".join(struct.pack("<h", round(0.8 * 32767 * x / loudest)) for x in samples)
    with wave.open(str(pathlib.Path(__file__).parent / f"{name}.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(data)


for make in (wind, water, cart, chime):
    write(make.__name__, make())
