#!/usr/bin/env python3
"""Makes a reference picture from the light that draw.py has drawn.

develop.py FOLDER OUT.png

FOLDER contains light.npz. Removes the noise of the samples, and applies the program's tone mapping and background, so
that the picture differs from the program's picture only by the light in the scene. Needs only numpy.
"""

import os
import struct
import sys
import zlib

import numpy as np

PATCH = 2  # pixels, half the width of the patches that are compared
# Differences between the surfaces of two pixels at which they no longer share their light: angle between the normals
# (rad), relative difference of the colours, distance from the tangent plane in pixels.
TURN, TINT, STEP = 0.5, 0.2, 3.0
STEADY = 1e-2  # keeps the slopes of the regression small where the pixels do not determine them


def patch_sum(a):
    """Sum over the square of each pixel and its neighbours up to PATCH; the result is smaller by PATCH at each side."""
    for axis in (-1, -2):
        size = a.shape[axis] - 2 * PATCH
        a = sum(np.take(a, range(k, k + size), axis) for k in range(2 * PATCH + 1))
    return a


def without_noise(halves, normal, position, color, window):
    """Light without the noise of the samples: first-order regression with the weights of non-local means (after Bitterli
    et al. 2016, Nonlinearly weighted first-order regression for denoising Monte Carlo renderings). A pixel becomes the
    value of a linear function of the place in the picture, fitted to those pixels in a window that show the same surface
    and whose light differs by no more than the noise. `halves`: (2, 3, height, width), the light of two drawings with
    different random numbers. Each half is averaged with weights from the other half, so that the weights do not depend
    on the noise that they average. `normal`, `position`, `color`: (3, height, width). `window`: pixels, half its
    width."""
    height, width = halves.shape[-2:]

    def outer(a, by):
        return np.pad(a, [(0, 0)] * (a.ndim - 2) + [(by, by)] * 2, mode="reflect")

    def moved(a, dx, dy, rim=0):
        """The part of a padded array that is moved by (dx, dy) and has `rim` more pixels at each side."""
        y, x = ((size - shown) // 2 - rim for size, shown in zip(a.shape[-2:], (height, width)))
        return a[..., y + dy : y + dy + height + 2 * rim, x + dx : x + dx + width + 2 * rim]

    # Variance of the light of one half, from the difference of the halves, and the mean of its surroundings.
    variance = patch_sum(outer((halves[0] - halves[1]) ** 2 / 2, PATCH)) / (2 * PATCH + 1) ** 2
    light, spread = outer(halves, window + PATCH), outer(variance, window + PATCH)
    place, facing, tint = outer(position, window), outer(normal, window), outer(color, window)
    here, here_spread = moved(light, 0, 0, PATCH), moved(spread, 0, 0, PATCH)
    # Size of a pixel on the surface: the nearest one of the neighbours in the picture.
    sides = ((1, 0), (-1, 0), (0, 1), (0, -1))
    pixel = np.maximum(np.min([np.linalg.norm(moved(place, *side) - position, axis=0) for side in sides], 0), 1e-6)
    narrow_color, narrow_step = (TINT * (color.max(0) + 0.02)) ** -2, (STEP * pixel) ** -2

    squares = np.zeros((2, 3, 3, height, width), np.float32)
    products = np.zeros((2, 3, 3, height, width), np.float32)
    for dx in range(-window, window + 1):
        for dy in range(-window, window + 1):
            surface = ((moved(facing, dx, dy) - normal) ** 2).sum(0) / TURN**2
            surface += ((moved(tint, dx, dy) - color) ** 2).sum(0) * narrow_color
            surface += ((moved(place, dx, dy) - position) * normal).sum(0) ** 2 * narrow_step
            there_spread = moved(spread, dx, dy, PATCH)
            excess = (here - moved(light, dx, dy, PATCH)) ** 2 - here_spread - np.minimum(here_spread, there_spread)
            excess /= 1e-8 + here_spread + there_spread
            distance = patch_sum(excess.sum(1)) / (3 * (2 * PATCH + 1) ** 2)
            weights = np.exp(-np.maximum(distance, 0) - surface)[::-1]  # each half gets the weights of the other one
            value = weights[:, None] * moved(light, dx, dy)
            at = (1, dx / window, dy / window)
            for i in range(3):
                products[:, i] += at[i] * value
                for j in range(i, 3):
                    squares[:, i, j] += at[i] * at[j] * weights

    matrix = squares + squares.swapaxes(1, 2)  # only one half of the symmetric matrix was summed
    matrix[:, range(3), range(3)] /= 2
    matrix = np.moveaxis(matrix, (1, 2), (-2, -1)).astype(float)
    matrix[..., (1, 2), (1, 2)] += STEADY * matrix[..., :1, 0] + 1e-9
    fitted = np.linalg.solve(matrix, np.moveaxis(products, (1, 2), (-2, -1)))[..., 0, :].mean(0)
    return np.moveaxis(np.maximum(fitted, 0), -1, 0)


def light_of(parts):
    """The picture's linear light without noise, (height, width, 3), and its opacity."""
    first = lambda name: np.moveaxis(parts[name].astype(np.float32), -1, 1)
    color, normal, position = (first(name).mean(0) for name in ("diffuse_color", "normal", "position"))
    mirror = first("glossy_color").mean(0)
    surface = np.where(color.max(0) > 1e-4, color, mirror)  # metal has no diffuse colour
    diffuse = without_noise(first("diffuse_direct") + first("diffuse_indirect"), normal, position, surface, 9)
    mirrored = without_noise(first("glossy_direct") + first("glossy_indirect"), normal, position, surface, 5)
    opacity = parts["opacity"].mean(0)
    light = np.moveaxis(diffuse * color + mirrored * mirror, 0, -1)
    return light / np.maximum(opacity, 1e-6), opacity


def tone_map(color):
    """As in shaders/lighting.glsl."""
    start, desaturation = 0.8, 0.15
    peak = np.maximum(color.max(-1, keepdims=True), 1e-9)
    d = 1 - start
    new_peak = 1 - d * d / (peak + d - start)
    g = 1 - 1 / (desaturation * (peak - new_peak) + 1)
    pressed = color * new_peak / peak
    pressed = pressed * (1 - g) + new_peak * g
    return np.where(peak < start, color, pressed)


def background(size):
    """The dark wall of shaders/background.frag without its noise; rows from bottom to top."""
    x = (2 * (np.arange(size[0]) + 0.5) / size[0] - 1)[None, :]
    y = (1 - 2 * (np.arange(size[1]) + 0.5) / size[1])[:, None]  # Vulkan: downwards
    near = np.exp(-1.1 * (x * x + (y + 0.15) ** 2))[..., None]
    return (1 - near) * np.array([0.0045, 0.0050, 0.0060]) + near * np.array([0.036, 0.040, 0.047])


def write_png(file, picture):
    """Writes sRGB bytes, (height, width, 3), rows from top to bottom."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = picture.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    with open(file, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)))
        f.write(chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def main():
    folder, out = sys.argv[1:]
    with np.load(os.path.join(folder, "light.npz")) as parts:
        light, opacity = light_of(parts)
    shown = tone_map(light) * opacity + background(light.shape[1::-1]) * (1 - opacity)
    shown = np.clip(shown, 0, 1)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    write_png(out, np.rint(255 * encoded[::-1]).astype(np.uint8))


if __name__ == "__main__":
    main()
