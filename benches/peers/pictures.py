"""Reads just enough PNG to tell how much of a picture is covered."""

import struct
import zlib


def covered(path):
    """Share of pixels that differ from the one in the corner by more than 8 of 255 in a channel."""
    width, height, channels, rows = read(path)
    corner = rows[0][:channels]
    # For each channel the values that count as background.
    near = [frozenset(range(max(c - 8, 0), c + 9)) for c in corner]
    count = 0
    for row in rows:
        for x in range(0, width * channels, channels):
            for k in range(channels):
                if row[x + k] not in near[k]:
                    count += 1
                    break
    return count / (width * height)


def read(path):
    """Width, height, channels and rows of an 8-bit RGB or RGBA picture without interlacing."""
    with open(path, "rb") as file:
        return decode(file.read(), path)


def decode(data, path="picture"):
    """The same of a file's bytes; `path` is for messages."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path} is no PNG")
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if depth != 8 or color not in (2, 6) or interlaced:
                raise ValueError(f"{path}: only 8-bit RGB and RGBA without interlacing are read")
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    channels = 3 if color == 2 else 4
    raw, stride = zlib.decompress(packed), width * channels
    rows, above = [], bytearray(stride)
    for y in range(height):
        start = y * (stride + 1)
        above = unfiltered(raw[start], bytearray(raw[start + 1 : start + 1 + stride]), above, channels)
        rows.append(above)
    return width, height, channels, rows


def unfiltered(kind, row, above, step):
    if kind == 1:
        for i in range(step, len(row)):
            row[i] = (row[i] + row[i - step]) & 255
    elif kind == 2:
        for i, up in enumerate(above):
            row[i] = (row[i] + up) & 255
    elif kind in (3, 4):
        for i, up in enumerate(above):
            left = row[i - step] if i >= step else 0
            corner = above[i - step] if i >= step else 0
            row[i] = (row[i] + ((left + up) // 2 if kind == 3 else paeth(left, up, corner))) & 255
    elif kind:
        raise ValueError("unknown PNG filter")
    return row


def paeth(left, up, corner):
    guess = left + up - corner
    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
    return left if a <= b and a <= c else up if b <= c else corner
