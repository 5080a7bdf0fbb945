#!/usr/bin/env python3
# SPDX-License-Identifier: CC0-1.0
"""Scores the pictures of a renderer against the truth of this pack, and writes a page.

    python3 score.py PICTURES -o report.html

PICTURES is a folder with NAME.exr (or NAME.pfm) for each scene of scenes.tsv: linear Rec. 709 in R, G and B. Variance of its
values, if there is any, is in NAME.variance.exr, or in channels variance.R, variance.G and variance.B. An aov.exr is compared
with that of the pack, in the channels that both have.

Exit codes: 0 all scenes pass, 1 some do not, 2 there is something that cannot be scored.
Python 3.8 or later; no packages.
"""

import argparse
import base64
import concurrent.futures
import html
import math
import os
import struct
import sys
import zlib
from collections import Counter
from itertools import accumulate
from statistics import NormalDist

# The rules, as README.md has them.
LEVEL = 0.001  # chance that noise alone is beyond the bound somewhere at a scale
ALLOWANCE = 0.005  # share of a pixel, or of the mean of the picture where that is more, that is free
OUTLIERS = 0.001  # share of values of pixels that may be beyond the bound
BLOCK, BLOCK_PIXELS = 8, 16  # side of a block, and fewest scored pixels of one that counts
COLUMNS = ["bias", "error", "noise", "rmse", "flip", "z_mean", "z_square", "pixels", "blocks", "whole"]
# What planes may differ by at most: angle in degrees, lengths.
PLANES = [("normal", "XYZ", 1.0, "degrees"), ("position", "XYZ", 0.01, ""), ("depth", "Z", 0.01, "")]


class Wrong(Exception):
    """What cannot be scored, in one line."""


# Pictures


class Picture:
    """Channels by name, each a list of numbers row by row from the top."""

    def __init__(self, path, width, height, channels):
        self.path, self.width, self.height, self.channels = path, width, height, channels

    def planes(self, names, what):
        """Three channels by name; where there are none, by the end of their names, if that is of one layer only."""
        if all(name in self.channels for name in names):
            return [self.channels[name] for name in names]
        ends = [[c for c in self.channels if c.endswith("." + n.split(".")[-1])] for n in names]
        if all(len(e) == 1 for e in ends) and "." not in names[0]:
            return [self.channels[e[0]] for e in ends]
        have = ", ".join(sorted(self.channels)) or "none"
        raise Wrong(f"{self.path}: expected channels {', '.join(names)} ({what}), found {have}")


COMPRESSIONS = ["NONE", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"]
ROWS = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16}


def read(path):
    """A picture, by its first bytes."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise Wrong(f"{path}: cannot be read: {error.strerror}") from None
    try:
        if data[:4] == b"\x76\x2f\x31\x01":
            return read_exr(path, data)
        if data[:3] in (b"PF\n", b"PF\r", b"PF "):
            return read_pfm(path, data)
    except (struct.error, zlib.error, IndexError, ValueError, KeyError, OverflowError) as error:
        raise Wrong(f"{path}: damaged: {error}") from None
    raise Wrong(f"{path}: expected OpenEXR or PFM: pictures of 8 bits have lost what is tested")


def read_exr(path, data):
    """OpenEXR File Layout (openexr.com): one part of scan lines or tiles, of which the finest level is read; no compression, RLE,
    ZIPS, ZIP, PIZ or PXR24."""
    (version,) = struct.unpack_from("<I", data, 4)
    if version & 0x1800:
        raise Wrong(f"{path}: expected one part of scan lines or tiles, found deep data or several parts")
    at, header = 8, {}
    while data[at]:
        name, at = text(data, at)
        _, at = text(data, at)
        (size,) = struct.unpack_from("<I", data, at)
        header[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    window = struct.unpack("<4i", header["dataWindow"])
    if window != struct.unpack("<4i", header["displayWindow"]):
        raise Wrong(f"{path}: expected a data window that is the whole picture, found {window}")
    left, top, right, bottom = window
    width, height = right - left + 1, bottom - top + 1
    if not (0 < width <= 8192 and 0 < height <= 8192):
        raise Wrong(f"{path}: {width} x {height} pixels; possible is up to 8192 x 8192")
    channels, k, listed = [], 0, header["channels"]
    while listed[k]:
        name, k = text(listed, k)
        kind, _, x, y = struct.unpack_from("<4i", listed, k)
        if kind not in (0, 1, 2) or (x, y) != (1, 1):
            raise Wrong(f"{path}: channel {name} is not of every pixel, or of an unknown kind")
        channels.append((name, "Ief"[kind]))
        k += 16
    compression = header["compression"][0]
    if compression not in ROWS:
        found = COMPRESSIONS[compression] if compression < len(COMPRESSIONS) else compression
        raise Wrong(f"{path}: expected no compression, RLE, ZIPS, ZIP, PIZ or PXR24, found {found}")
    tiled = version & 0x200
    wide, high = struct.unpack_from("<II", header["tiles"]) if tiled else (width, ROWS[compression])
    if not (0 < wide and 0 < high):
        raise Wrong(f"{path}: damaged: tiles of {wide} x {high} pixels")
    planes = {name: [[] for _ in range(height)] for name, _ in channels}
    # The tiles of the finest level come first.
    blocks = -(-height // high) * -(-width // wide)
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        if tiled:
            column, row, *level, size = struct.unpack_from("<5i", data, offset)
            x, y, offset = column * wide, row * high, offset + 20
            if any(level):
                raise Wrong(f"{path}: damaged: a tile of level {level} among those of the finest")
        else:
            x, (y, size), offset = 0, struct.unpack_from("<ii", data, offset), offset + 8
            y -= top
        if not (0 <= x < width and 0 <= y < height and size >= 0):
            raise Wrong(f"{path}: damaged: a block of {size} bytes at {x}, {y}")
        across, down = min(wide, width - x), min(high, height - y)
        parts = [(across, kind) for _, kind in channels]
        expected = down * across * sum(struct.calcsize(kind) for _, kind in channels)
        raw = data[offset : offset + size]
        if size < expected:
            raw = unpacked(raw, compression, parts, down, expected)
        if len(raw) != expected:
            raise Wrong(f"{path}: damaged: {len(raw)} bytes in place of {expected} at {x}, {y}")
        k = 0
        for row in range(y, y + down):
            for name, kind in channels:
                if not planes[name][row]:
                    planes[name][row] = [None] * width
                planes[name][row][x : x + across] = struct.unpack_from(f"<{across}{kind}", raw, k)
                k += across * struct.calcsize(kind)
    if any(not row or None in row for plane in planes.values() for row in plane):
        raise Wrong(f"{path}: damaged: rows are missing")
    return Picture(path, width, height, {n: [v for row in p for v in row] for n, p in planes.items()})


def text(data, at):
    end = data.index(0, at)
    return data[at:end].decode("latin-1"), end + 1


def inflated(raw, expected):
    """No more than one byte beyond what is expected, whatever the file claims."""
    return zlib.decompressobj().decompress(raw, expected + 1)


def unpacked(raw, compression, parts, down, expected):
    """A block's rows, each with its channels one after the other. `parts` has their widths and kinds."""
    if compression == 0:
        return raw
    if compression == 4:
        return unpacked_piz(raw, parts, down)
    if compression == 5:
        return unpacked_pxr24(raw, parts, down)
    # Bytes, then differences of them, then the halves of all bytes put together again.
    if compression == 1:
        out, k = bytearray(), 0
        while k < len(raw):
            count = raw[k] - 256 if raw[k] > 127 else raw[k]
            if count < 0:
                out += raw[k + 1 : k + 1 - count]
                k += 1 - count
            else:
                out += raw[k + 1 : k + 2] * (count + 1)
                k += 2
        raw = bytes(out)
    else:
        raw = inflated(raw, expected)
    sums = bytes(accumulate(raw, lambda before, byte: (before + byte - 128) & 255))
    out = bytearray(len(sums))
    half = (len(sums) + 1) // 2
    out[0::2], out[1::2] = sums[:half], sums[half:]
    return bytes(out)


def unpacked_pxr24(raw, parts, down):
    """Differences along a row, their bytes in planes from the highest; floats have lost their lowest byte (ImfPxr24Compressor.cpp)."""
    kept = {"I": 4, "e": 2, "f": 3}
    raw, k, out = inflated(raw, down * sum(width * kept[kind] for width, kind in parts)), 0, []
    for _ in range(down):
        for width, kind in parts:
            count = kept[kind]
            planes = [raw[k + width * p : k + width * (p + 1)] for p in range(count)]
            k += width * count
            size = struct.calcsize(kind)
            steps = (int.from_bytes(bytes(step), "big") << 8 * (size - count) for step in zip(*planes))
            values = accumulate(steps, lambda before, step: (before + step) & (1 << 8 * size) - 1)
            out.append(b"".join(value.to_bytes(size, "little") for value in values))
    return b"".join(out)


def unpacked_piz(raw, parts, down):
    """Words of 16 bits by rank among those that occur, as wavelets, in Huffman's code (ImfPizCompressor.cpp)."""
    first, last = struct.unpack_from("<HH", raw)
    bits = bytes(first) + raw[4 : 5 + last - first] if first <= last else b""
    at = 4 + max(last - first + 1, 0)
    occurring = [0] + [v for v in range(1, 8 * len(bits)) if bits[v >> 3] >> (v & 7) & 1]
    (size,) = struct.unpack_from("<i", raw, at)
    total = down * sum(width * struct.calcsize(kind) // 2 for width, kind in parts)
    words = huffman(raw[at + 4 : at + 4 + size], total)
    k, rows = 0, [[] for _ in range(down)]
    for width, kind in parts:
        each = struct.calcsize(kind) // 2
        for part in range(each):
            wavelet(words, k + part, width, each, down, width * each, len(occurring) <= 1 << 14)
        for row in rows:
            row.extend(occurring[word] for word in words[k : k + width * each])
            k += width * each
    return b"".join(struct.pack(f"<{len(row)}H", *row) for row in rows)


def huffman(data, total):
    """Canonical code, its lengths first in 6 bits each, with a symbol for runs (ImfHuf.cpp)."""
    first, last, _, count = struct.unpack_from("<4I", data)
    if not first <= last <= 1 << 16:
        raise ValueError(f"symbols {first} to {last}")
    held, have, at = 0, 0, 20

    def take(wanted):
        nonlocal held, have, at
        while have < wanted:
            held, have, at = (held << 8 | data[at]), have + 8, at + 1
        have -= wanted
        value, held = held >> have, held & (1 << have) - 1
        return value

    lengths, symbol = {}, first
    while symbol <= last:
        length = take(6)
        if length < 59:
            if length:
                lengths[symbol] = length
            symbol += 1
        else:
            symbol += take(8) + 6 if length == 63 else length - 57
    counts, starts, code = Counter(lengths.values()), [0] * 59, 0
    for length in range(58, 0, -1):
        starts[length] = code
        code = (code + counts[length]) >> 1
    # A 1 before the code tells apart those of other lengths.
    symbols = {}
    for symbol, length in lengths.items():
        symbols[1 << length | starts[length]] = symbol
        starts[length] += 1
    if count > 8 * (len(data) - at):
        raise ValueError(f"{len(data) - at} bytes hold no {count} bits")
    out, code, run = [], 1, -1
    for bit in range(count):
        code = code << 1 | data[at + (bit >> 3)] >> (7 - (bit & 7)) & 1
        if run >= 0:
            run += 1
            if run == 8:
                out += out[-1:] * (code & 255)
                code, run = 1, -1
            continue
        symbol = symbols.get(code)
        if symbol is None:
            if code >> 59:
                raise ValueError("no symbol has this code")
        elif symbol == last:
            code, run = 1, 0
        else:
            out.append(symbol)
            code = 1
        if len(out) > total:
            break
    if len(out) != total:
        raise ValueError(f"{len(out)} words in place of {total}")
    return out


def wavelet(words, at, width, across, height, down, small):
    """Undoes the Haar wavelets of a plane in place (ImfWav.cpp); of 14 bits they are signed, of 16 modulo."""

    def pair(low, high):
        if small:
            signed = high - (high >> 15 << 16)
            first = low + (signed & 1) + (signed >> 1)
            return first & 65535, (first - signed) & 65535
        second = (low - (high >> 1)) & 65535
        return (high + second - 32768) & 65535, second

    step = 1
    while 2 * step <= min(width, height):
        step *= 2
    while step > 1:
        half = step // 2
        for y in range(0, height - step + 1, step):
            for x in range(0, width - step + 1, step):
                a = at + y * down + x * across
                b, c = a + half * across, a + half * down
                d = b + half * down
                (p, r), (q, s) = pair(words[a], words[c]), pair(words[b], words[d])
                (words[a], words[b]), (words[c], words[d]) = pair(p, q), pair(r, s)
            if width & half:
                a = at + y * down + (width & -step) * across
                words[a], words[a + half * down] = pair(words[a], words[a + half * down])
        if height & half:
            y = height & -step
            for x in range(0, width - step + 1, step):
                a = at + y * down + x * across
                words[a], words[a + half * across] = pair(words[a], words[a + half * across])
        step = half


def read_pfm(path, data):
    _, size, scale, rest = data.split(b"\n", 3)
    width, height = map(int, size.split())
    order = "<" if float(scale) < 0 else ">"
    values = struct.unpack(f"{order}{3 * width * height}f", rest[: 12 * width * height])
    rows = [values[3 * width * y : 3 * width * (y + 1)] for y in reversed(range(height))]
    flat = [v for row in rows for v in row]
    return Picture(path, width, height, {"R": flat[0::3], "G": flat[1::3], "B": flat[2::3]})


# The tests


class Truth:
    """A scene's truth: three planes each of mean, variance and footprint, and the pixels that are scored."""

    def __init__(self, path):
        picture = read(path)
        self.width, self.height = picture.width, picture.height
        part = lambda name: picture.planes([f"{name}.{c}" for c in "RGB"], name)
        self.mean = picture.planes(["R", "G", "B"], "radiance")
        self.variance, self.footprint = part("variance"), part("footprint")
        self.mask = picture.channels["mask.Y"]
        self.scored = [k for k, mask in enumerate(self.mask) if mask > 0.5]


def bound(tests):
    """Sidak 1967: the normal law's two-sided bound for that many tests together."""
    chance = -math.expm1(math.log1p(-LEVEL) / max(tests, 1))
    return -NormalDist().inv_cdf(0.5 * chance)


def beyond(tests):
    """Share of values beyond their bound, and the largest in its bound. A test has differences, variances and slack by channel."""
    z = bound(3 * len(tests))
    ratios = [
        abs(d) / max(z * math.sqrt(v) + s, 1e-300) for test in tests for d, v, s in zip(test[0], test[1], test[2])
    ]
    return sum(r > 1 for r in ratios) / max(len(ratios), 1), max(ratios, default=0.0)


def score(truth, planes, extra, allow):
    """Scores by name, the picture that FLIP has seen, and per pixel the largest difference in its bound."""
    level = [sum(truth.mean[c][k] for k in truth.scored) / len(truth.scored) for c in range(3)]
    across = -(-truth.width // BLOCK)
    pixels, blocks, whole = [], {}, [[0.0] * 3, [0.0] * 3, [0.0] * 3, 0]
    shown = signless = noise = squares = energy = z_mean = z_square = 0.0
    for k in truth.scored:
        test = [[0.0] * 3, [0.0] * 3, [0.0] * 3, 1]
        for c in range(3):
            value = truth.mean[c][k]
            d = planes[c][k] - value
            v = truth.variance[c][k] + (extra[c][k] if extra else 0.0)
            free, footprint = allow * max(value, level[c]), truth.footprint[c][k]
            test[0][c], test[1][c], test[2][c] = d, v, footprint + free
            shown += value
            signless += abs(d)
            # The mean of what is normal, without its sign.
            noise += math.sqrt(v * 2 / math.pi)
            squares += d * d
            energy += value * value
            z = d / max(math.sqrt(v + footprint * footprint + free * free), 1e-300)
            z_mean += z
            z_square += z * z
        pixels.append(test)
        block = blocks.setdefault((k // truth.width // BLOCK) * across + k % truth.width // BLOCK, [[0.0] * 3, [0.0] * 3, [0.0] * 3, 0])
        for total in (block, whole):
            for part in range(3):
                for c in range(3):
                    total[part][c] += test[part][c]
            total[3] += 1
    values = 3 * len(pixels)
    z = bound(values)
    ratios = {
        k: max(abs(d) / max(z * math.sqrt(v) + s, 1e-300) for d, v, s in zip(test[0], test[1], test[2]))
        for k, test in zip(truth.scored, pixels)
    }
    pixel_share, _ = beyond(pixels)
    block_share, _ = beyond([block for block in blocks.values() if block[3] >= BLOCK_PIXELS])
    _, whole_worst = beyond([whole])
    mixed = [[p if m > 0.5 else t for p, m, t in zip(planes[c], truth.mask, truth.mean[c])] for c in range(3)]
    flips = flip_hdr(truth.mean, mixed, truth.width, truth.height)
    numbers = {
        "bias": sum(whole[0]) / shown,
        "error": signless / shown,
        "noise": noise / shown,
        "rmse": math.sqrt(squares / energy),
        "flip": sum(flips[k] for k in truth.scored) / len(truth.scored),
        "z_mean": z_mean / values,
        "z_square": z_square / values,
        "pixels": pixel_share,
        "blocks": block_share,
        "whole": whole_worst,
    }
    passes = pixel_share <= OUTLIERS and block_share == 0 and whole_worst <= 1
    return passes, numbers, ratios


def reason(numbers):
    """Why a scene fails, in words: the largest scale first, as it tells most."""
    off = abs(numbers["bias"])
    direction = "bright" if numbers["bias"] > 0 else "dark"
    words = []
    if numbers["whole"] > 1:
        words.append(f"{off:.1%} too {direction} as a whole" if off >= 0.001 else "a colour is off as a whole")
    if numbers["blocks"] > 0:
        words.append(f"{numbers['blocks']:.1%} of the blocks beyond their bound")
    if numbers["pixels"] > OUTLIERS:
        words.append(f"{numbers['pixels']:.1%} of the pixels")
    if numbers["whole"] <= 1 and off < 0.02 and words:
        words.append("right as a whole but spread otherwise")
    return ", ".join(words)


# FLIP: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", and for light without an upper end
# Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images". Constants as published.

PIXELS_PER_DEGREE = 67.02064
SPATIAL = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)]
TO_XYZ = [
    [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
    [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
    [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
]
TO_RGB = [
    [3.2410033, -1.5373989, -0.49861586],
    [-0.96922433, 1.8759301, 0.041554224],
    [0.055639423, -0.2040112, 1.0571489],
]
WHITE = [0.95042855, 1.0, 1.0889004]
ACES = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14]


def filters():
    """Contrast sensitivity: achromatic, red-green and the two of blue-yellow; a Gaussian and its derivatives for features."""
    radius = math.ceil(3 * math.sqrt(SPATIAL[2][1] / (2 * math.pi**2)) * PIXELS_PER_DEGREE)
    spatial = []
    for k, (a, b) in enumerate(SPATIAL):
        amplitude = a * math.sqrt(math.pi / b)
        amplitude = amplitude if k < 2 else math.sqrt(amplitude)
        spatial.append(
            [amplitude * math.exp(-((math.pi * x / PIXELS_PER_DEGREE) ** 2) / b) for x in range(-radius, radius + 1)]
        )
    sums = [sum(taps) for taps in spatial]
    both = math.hypot(sums[2], sums[3])
    spatial = [[v / norm for v in taps] for taps, norm in zip(spatial, [sums[0], sums[1], both, both])]
    deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE
    radius = math.ceil(3 * deviation)
    feature = [[], [], []]
    for x in range(-radius, radius + 1):
        g = math.exp(-x * x / (2 * deviation**2))
        for taps, value in zip(feature, [g, -x * g, (x * x / deviation**2 - 1) * g]):
            taps.append(value)
    for taps in feature:
        positive, negative = sum(v for v in taps if v > 0), -sum(v for v in taps if v <= 0)
        taps[:] = [v / (positive if v > 0 else negative) for v in taps]
    return spatial, feature


FILTERS = filters()


def convolved(padded, stride, taps):
    """Sums of a padded plane over steps of `stride`; its taps are even, or odd, about their middle."""
    radius = len(taps) // 2
    count = len(padded) - 2 * radius * stride
    odd = taps[0] * taps[-1] < 0
    middle = padded[radius * stride : radius * stride + count]
    out = [taps[radius] * v for v in middle]
    for k in range(radius):
        tap, low, high = taps[k], k * stride, (2 * radius - k) * stride
        a, b = padded[low : low + count], padded[high : high + count]
        if odd:
            out = [o + tap * (x - y) for o, x, y in zip(out, a, b)]
        else:
            out = [o + tap * (x + y) for o, x, y in zip(out, a, b)]
    return out


def along_x(plane, width, height, taps):
    radius = len(taps) // 2
    wide = width + 2 * radius
    padded = []
    for y in range(height):
        row = plane[y * width : (y + 1) * width]
        padded += [row[0]] * radius + row + [row[-1]] * radius
    # What reaches from one row into the next is left out.
    out = convolved(padded, 1, taps)
    return [v for y in range(height) for v in out[y * wide : y * wide + width]]


def along_y(plane, width, height, taps):
    radius = len(taps) // 2
    padded = plane[:width] * radius + plane + plane[-width:] * radius
    return convolved(padded, width, taps)


def hunt_lab(r, g, b):
    """CIELAB with the Hunt effect."""

    def bent(t):
        return t ** (1 / 3) if t > 216 / 24389 else t * (841 / 108) + 4 / 29

    x, y, z = (bent((m[0] * r + m[1] * g + m[2] * b) / w) for m, w in zip(TO_XYZ, WHITE))
    lightness = 116 * y - 16
    return lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)


def hyab(a, b):
    return abs(a[0] - b[0]) + math.hypot(a[1] - b[1], a[2] - b[2])


MOST = hyab(hunt_lab(0, 1, 0), hunt_lab(0, 0, 1)) ** 0.7


def seen(planes, width, height, exposure):
    """What an eye makes of a picture: colours in Hunt's CIELAB, strength of edges and of points."""
    a, b, c, d, e = ACES
    opponent = [[], [], []]
    for rgb in zip(*planes):
        r, g, l = (
            min(max((a * v * v + b * v) / (c * v * v + d * v + e), 0.0), 1.0)
            for v in (min(max(v * exposure, -1e15), 1e15) for v in rgb)
        )
        x, y, z = ((m[0] * r + m[1] * g + m[2] * l) / w for m, w in zip(TO_XYZ, WHITE))
        opponent[0].append(116 * y - 16)
        opponent[1].append(500 * (x - y))
        opponent[2].append(200 * (y - z))
    spatial, feature = FILTERS
    both = lambda plane, first, second: along_y(along_x(plane, width, height, first), width, height, second)
    y, cx = (both(opponent[k], spatial[k], spatial[k]) for k in range(2))
    cz = [p + q for p, q in zip(*(both(opponent[2], spatial[k], spatial[k]) for k in (2, 3)))]
    colours = []
    for ly, lx, lz in zip(y, cx, cz):
        ly = (ly + 16) / 116
        xyz = (lx / 500 + ly) * WHITE[0], ly, (ly - lz / 200) * WHITE[2]
        colours.append(hunt_lab(*(min(max(m[0] * xyz[0] + m[1] * xyz[1] + m[2] * xyz[2], 0.0), 1.0) for m in TO_RGB)))
    strength = []
    for k in (1, 2):
        dx, dy = both(opponent[0], feature[k], feature[0]), both(opponent[0], feature[0], feature[k])
        strength.append([math.hypot(p, q) / 116 for p, q in zip(dx, dy)])
    return colours, strength


def exposures(mean):
    """In stops, from the one for the brightest pixel to the one for the median, one apart or less."""
    luminances = sorted(0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in zip(*mean))
    brightest, median = luminances[-1], luminances[len(luminances) // 2]
    lit = [v for v in luminances if v > 0]
    if median <= 0:
        median = lit[len(lit) // 2] if lit else 0.0
    a, b, c, d, e = ACES
    a, b, c = a - 0.85 * c, b - 0.85 * d, -0.85 * e
    value = -0.5 * b / a + math.sqrt((0.5 * b / a) ** 2 - c / a)
    start, stop = (math.log2(value / v) if v > 0 else 0.0 for v in (brightest, median))
    if stop <= start:
        return [start]
    count = min(max(math.ceil(stop - start), 2), 64)
    return [start + k * (stop - start) / (count - 1) for k in range(count)]


def flip_hdr(expected, actual, width, height):
    """HDR-FLIP of every pixel: the largest of all exposures."""
    most = [0.0] * (width * height)
    for stops in exposures(expected):
        first, second = (seen(planes, width, height, 2.0**stops) for planes in (expected, actual))
        for k, (p, q) in enumerate(zip(first[0], second[0])):
            distance = hyab(p, q) ** 0.7
            if distance < 0.4 * MOST:
                colour = distance * 0.95 / (0.4 * MOST)
            else:
                colour = 0.95 + (distance - 0.4 * MOST) * 0.05 / (0.6 * MOST)
            if colour > 0:
                edges, points = (abs(first[1][t][k] - second[1][t][k]) for t in range(2))
                value = colour ** (1 - math.sqrt(max(edges, points) / math.sqrt(2)))
                most[k] = max(most[k], value)
    return most


# Planes


def score_planes(expected, found, mask):
    """The largest difference of each plane that both have, over the pixels that every scene scores."""
    rows = []
    for name, axes, limit, unit in PLANES:
        channels = [f"{name}.{axis}" for axis in axes]
        if not all(c in found.channels for c in channels):
            continue
        worst = 0.0
        for k in mask:
            p, q = ([picture.channels[c][k] for c in channels] for picture in (expected, found))
            if name == "normal":
                length = math.sqrt(sum(v * v for v in q)) or 1.0
                sine = math.sqrt(sum((a - b / length) ** 2 for a, b in zip(p, q))) / 2
                worst = max(worst, math.degrees(2 * math.asin(min(sine, 1.0))))
            else:
                worst = max(worst, max(abs(a - b) for a, b in zip(p, q)))
        rows.append((name, worst, limit, unit))
    return rows


# The page


def png(width, height, pixels):
    """Bytes of a PNG of rows of (r, g, b), 0 to 255."""
    raw = b"".join(b"\0" + bytes(v for p in pixels[y * width : (y + 1) * width] for v in p) for y in range(height))
    chunk = lambda kind, data: (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    )
    header = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b"")


def code(linear):
    v = min(max(linear, 0.0), 1.0)
    v = 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055
    return int(255 * v + 0.5)


def mixed(t, ends):
    """From grey in the middle (t = 0) to one of two colours (t = -1, 1)."""
    t = min(max(t, -1.0), 1.0)
    end = ends[0] if t < 0 else ends[1]
    return tuple(int(235 + (e - 235) * abs(t)) for e in end)


def pictures(truth, planes, ratios):
    """Truth, picture, signed difference, difference in its bound."""
    lit = sorted(max(truth.mean[c][k] for c in range(3)) for k in truth.scored)
    scale = 0.9 / (lit[int(0.995 * (len(lit) - 1))] or 1.0)
    show = lambda image: [tuple(code(scale * image[c][k]) for c in range(3)) for k in range(len(truth.mask))]
    level = sum(sum(truth.mean[c][k] for k in truth.scored) for c in range(3)) / len(truth.scored) / 3
    signed, bounded = [], []
    for k, mask in enumerate(truth.mask):
        if mask > 0.5:
            value = sum(truth.mean[c][k] for c in range(3)) / 3
            d = sum(planes[c][k] for c in range(3)) / 3 - value
            signed.append(mixed(d / (0.25 * max(value, level)), [(33, 102, 172), (178, 24, 43)]))
            r = ratios[k]
            bounded.append(mixed(r / 2 if r <= 1 else 0.5 + r / 10, [(0, 0, 0), (0, 90, 50) if r <= 1 else (150, 0, 90)]))
        else:
            signed.append((255, 255, 255))
            bounded.append((255, 255, 255))
    return [png(truth.width, truth.height, p) for p in (show(truth.mean), show(planes), signed, bounded)]


STYLE = """body{font:15px/1.5 system-ui,sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse}td,th{padding:.2em .7em;text-align:right;border-bottom:1px solid #ddd}
td:first-child,th:first-child{text-align:left}.pass{color:#05603a}.fail{color:#a3123a}
figure{display:inline-block;margin:0 1em 0 0}img{image-rendering:pixelated;width:192px;display:block}
figcaption{font-size:13px;color:#555}h2{margin-bottom:.2em}p.about{margin-top:0}"""

EXPLAINED = """<p>Bias, error and RMSE are shares of the truth; noise is the error that variance alone makes; FLIP is the mean of HDR-FLIP, 0 to 1; z&sup2; is the mean square of the
differences in standard deviations (footprint and allowance are part of them), 1 or less of a renderer that is right. Pixels and
blocks are the shares beyond their bounds, whole is the difference of the whole picture in its bound. A scene passes with at most
{outliers:.1%} of the pixels' values beyond, no block, and a whole of at most 1. Maps: difference from -25 % (blue) to +25 % (red) of the
truth, or of its mean where that is more; difference in its bound, green within and purple beyond.</p>"""


def page(name, version, results, planes, allow):
    """One page without other files."""
    passed = sum(result["passes"] for result in results)
    out = [
        "<!doctype html><html lang='en'><meta charset='utf-8'><title>Conformance of ",
        html.escape(name),
        f"</title><style>{STYLE}</style><h1>{html.escape(name)}: {passed} of {len(results)} scenes pass</h1>",
        f"<p>{html.escape(version)}; allowance {allow:.2%}.</p>",
        "<table><tr><th>scene<th>verdict<th>bias<th>error<th>noise<th>RMSE<th>FLIP<th>z<th>z&sup2;<th>pixels<th>blocks<th>whole"
        "<th>one bounce<th>why</tr>",
    ]
    for result in results:
        n, verdict = result["numbers"], "pass" if result["passes"] else "fail"
        out.append(
            f"<tr><td><a href='#{result['name']}'>{result['name']}</a><td class='{verdict}'>{verdict}"
            f"<td>{n['bias']:+.2%}<td>{n['error']:.2%}<td>{n['noise']:.2%}<td>{n['rmse']:.2%}<td>{n['flip']:.4f}<td>{n['z_mean']:+.2f}"
            f"<td>{n['z_square']:.2f}<td>{n['pixels']:.2%}<td>{n['blocks']:.1%}<td>{n['whole']:.2f}{one_cell(result)}"
            f"<td class='about'>{'' if result['passes'] else reason(n)}</tr>"
        )
    out.append("</table>" + EXPLAINED.format(outliers=OUTLIERS))
    if planes:
        out.append("<h2>Planes</h2><table><tr><th>plane<th>verdict<th>largest difference<th>allowed</tr>")
        for plane, worst, limit, unit in planes:
            verdict = "pass" if worst <= limit else "fail"
            out.append(f"<tr><td>{plane}<td class='{verdict}'>{verdict}<td>{worst:.4f} {unit}<td>{limit} {unit}</tr>")
        out.append("</table>")
    for result in results:
        out.append(f"<h2 id='{result['name']}'>{result['name']}</h2><p class='about'>{html.escape(result['about'])}</p>")
        for caption, data in zip(("truth", "picture", "difference", "in its bound"), result["pictures"]):
            encoded = base64.b64encode(data).decode()
            out.append(f"<figure><img alt='' src='data:image/png;base64,{encoded}'><figcaption>{caption}</figcaption></figure>")
    out.append("</html>\n")
    return "".join(out)


def one_cell(result):
    """Verdict and bias by the truth of one bounce, where there is one."""
    if not result["one"]:
        return "<td>"
    passes, numbers = result["one"]
    verdict = "pass" if passes else "fail"
    return f"<td class='{verdict}'>{verdict} {numbers['bias']:+.2%}"


# The program


def find(folder, name, needed):
    for extension in ("exr", "pfm"):
        path = os.path.join(folder, f"{name}.{extension}")
        if os.path.isfile(path):
            return path
    if needed:
        raise Wrong(f"{os.path.join(folder, name)}.exr: missing; expected a picture of scene {name} (or .pfm)")
    return None


def finite(planes, truth, path):
    for c in range(3):
        for k in truth.scored:
            if not math.isfinite(planes[c][k]):
                x, y = k % truth.width, k // truth.width
                raise Wrong(f"{path}: {'RGB'[c]} at {x}, {y} is {planes[c][k]}; expected finite numbers")


def score_scene(pack, folder, name, about, allow):
    """All of one scene, or the line that says why not."""
    try:
        truth = Truth(os.path.join(pack, "truth", f"{name}.exr"))
        path = find(folder, name, True)
        picture = read(path)
        check_size(picture, truth.width, truth.height)
        planes = picture.planes(["R", "G", "B"], "linear Rec. 709")
        finite(planes, truth, path)
        extra, beside = None, find(folder, f"{name}.variance", False)
        if beside:
            variance = read(beside)
            check_size(variance, truth.width, truth.height)
            extra = variance.planes(["R", "G", "B"], "variance")
            path = beside
        elif "variance.R" in picture.channels:
            extra = picture.planes([f"variance.{c}" for c in "RGB"], "variance")
        if extra:
            finite(extra, truth, path)
            if min(min(plane) for plane in extra) < 0:
                raise Wrong(f"{path}: a variance is below 0")
        passes, numbers, ratios = score(truth, planes, extra, allow)
        shown, one = pictures(truth, planes, ratios), None
        second = os.path.join(pack, "one-bounce", f"{name}.exr")
        if os.path.isfile(second):
            single = Truth(second)
            check_size(picture, single.width, single.height)
            one = score(single, planes, extra, allow)[:2]
        return {"name": name, "about": about, "passes": passes, "numbers": numbers, "pictures": shown, "one": one}
    except Wrong as wrong:
        return str(wrong)


def check_size(picture, width, height):
    if (picture.width, picture.height) != (width, height):
        raise Wrong(f"{picture.path}: {picture.width} x {picture.height} pixels; expected {width} x {height}")


def scenes_of(pack, asked):
    try:
        with open(os.path.join(pack, "VERSION"), encoding="utf-8") as file:
            version = file.read().splitlines()[0]
        with open(os.path.join(pack, "scenes.tsv"), encoding="utf-8") as file:
            rows = [line.split("\t") for line in file.read().splitlines()[1:]]
    except (OSError, IndexError):
        raise Wrong(f"{pack}: no conformance pack; expected VERSION and scenes.tsv in it") from None
    names = [row[0] for row in rows]
    for name in asked:
        if name not in names:
            raise Wrong(f"no scene {name}; there are {', '.join(names)}")
    return version, [(row[0], row[3]) for row in rows if not asked or row[0] in asked]


def allowance(value):
    number = float(value)
    if not 0 <= number <= 1:
        raise ValueError
    return number


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n\n")[0], epilog="Exit codes: 0 all pass, 1 some do not, 2 cannot be scored."
    )
    parser.add_argument("pictures", metavar="PICTURES", help="folder with NAME.exr or NAME.pfm of each scene")
    parser.add_argument("-o", "--output", metavar="PAGE", help="page to write (.html)")
    parser.add_argument("--tsv", metavar="FILE", help="table to write, tab-separated")
    parser.add_argument("--scenes", metavar="LIST", default="", help="only these, comma-separated")
    parser.add_argument(
        "--one-bounce", action="store_true", help="the exit code goes by the truth of one bounce, for scenes that have one"
    )
    parser.add_argument("--name", help="name of the renderer [default: that of the folder]")
    parser.add_argument(
        "--allow", metavar="SHARE", type=allowance, default=ALLOWANCE, help=f"share that is free, 0 to 1 [default: {ALLOWANCE}]"
    )
    parser.add_argument(
        "--pack", metavar="FOLDER", default=os.path.dirname(os.path.abspath(__file__)), help="the pack [default: where this script is]"
    )
    args = parser.parse_args(arguments)
    asked = [name for name in args.scenes.split(",") if name]
    try:
        version, scenes = scenes_of(args.pack, asked)
        if not os.path.isdir(args.pictures):
            raise Wrong(f"{args.pictures}: expected a folder with the pictures")
        with concurrent.futures.ProcessPoolExecutor() as pool:
            jobs = [pool.submit(score_scene, args.pack, args.pictures, *scene, args.allow) for scene in scenes]
            results = [job.result() for job in jobs]
        wrong = [result for result in results if isinstance(result, str)]
        if wrong:
            raise Wrong("\n".join(wrong))
        planes = []
        path = find(args.pictures, "aov", False)
        if path:
            expected, found = read(os.path.join(args.pack, "aov.exr")), read(path)
            check_size(found, expected.width, expected.height)
            mask = Truth(os.path.join(args.pack, "truth", f"{scenes[0][0]}.exr")).scored
            planes = score_planes(expected, found, mask)
        name = args.name or os.path.basename(os.path.abspath(args.pictures))
        write(args.output, page(name, version, results, planes, args.allow))
        rows = ["\t".join(["scene", "verdict", *COLUMNS, "one_verdict", "one_bias", "one_error"])]
        for result in results:
            numbers = [f"{result['numbers'][column]:.6f}" for column in COLUMNS]
            one = ["-"] * 3
            if result["one"]:
                passes, n = result["one"]
                one = ["pass" if passes else "fail", f"{n['bias']:.6f}", f"{n['error']:.6f}"]
            rows.append("\t".join([result["name"], "pass" if result["passes"] else "fail", *numbers, *one]))
        write(args.tsv, "\n".join(rows) + "\n")
    except Wrong as wrong:
        print("\n".join(f"score.py: {line}" for line in str(wrong).splitlines()), file=sys.stderr)
        return 2
    for result in results:
        n = result["numbers"]
        verdict = "pass" if result["passes"] else "FAIL"
        one = ""
        if result["one"]:
            passes, m = result["one"]
            one = f"; one bounce: {'pass' if passes else 'FAIL'}, bias {m['bias']:+.2%}"
        why = "" if result["passes"] else f"  {reason(n)}"
        print(f"{verdict}  {result['name']:24} bias {n['bias']:+8.2%}  error {n['error']:7.2%}  FLIP {n['flip']:.4f}{why}{one}")
    for plane, worst, limit, unit in planes:
        print(f"{'pass' if worst <= limit else 'FAIL'}  {plane:24} {worst:.4f} {unit} (allowed {limit})")
    counts = lambda result: result["one"][0] if args.one_bounce and result["one"] else result["passes"]
    failed = any(not counts(result) for result in results) or any(worst > limit for _, worst, limit, _ in planes)
    return 1 if failed else 0


def write(path, text):
    if path:
        try:
            with open(path, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
        except OSError as error:
            raise Wrong(f"{path}: cannot be written: {error.strerror}") from None


if __name__ == "__main__":
    sys.exit(main())
