"""Single scattering by plain quadrature: what the Monte Carlo is checked against before it is believed."""

import math

import numpy as np

import scenes

ACROSS, ALONG = 12, 400  # rays a block and side, steps along a ray


def phase(lobes, cos):
    total = sum(w for w, _ in lobes)
    return sum(w / total * (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cos) ** 1.5) for w, g in lobes)


def cone(lamps, direction):
    if "aim_at_m" not in lamps:
        return np.ones(direction.shape[:-1])
    axis = np.array(lamps["aim_at_m"]) - lamps["position_m"]
    cos = direction @ (axis / np.linalg.norm(axis))
    inner, outer = (math.cos(math.radians(lamps[k])) for k in ("inner_deg", "outer_deg"))
    s = np.clip((cos - outer) / (inner - outer), 0, 1)
    return s * s * (3 - 2 * s)


def blocks(a, b, lobes, lamps, distance_m, albedo, columns, rows):
    """Backscatter and light of the card, [row, column], of every block of the image of a wall at x = distance_m."""
    u = (np.arange(columns * ACROSS) + 0.5) / (columns * ACROSS) * 2 - 1
    v = ((np.arange(rows * ACROSS) + 0.5) / (rows * ACROSS) * 2 - 1) * rows / columns
    rays = np.stack(np.broadcast_arrays(1.0, u[None, :] * scenes.HALF_WIDTH, v[:, None] * scenes.HALF_WIDTH), -1)
    lengths = np.linalg.norm(rays, axis=-1)
    rays, reach, eye = rays / lengths[..., None], distance_m * lengths, np.array(scenes.EYE_M)
    light = np.zeros((2, *reach.shape))
    for position in lamps["positions_m"]:
        lamp = lamps | {"position_m": position}
        for k in range(ALONG):
            t = reach * (k + 0.5) / ALONG
            w, r = from_lamp(eye + rays * t[..., None], position)
            light[0] += b * phase(lobes, -(w * rays).sum(-1)) * beam(lamp, w, r, a + b, t) * reach / ALONG
        w, r = from_lamp(eye + rays * reach[..., None], position)
        light[1] += albedo / np.pi * np.maximum(w[..., 0], 0) * beam(lamp, w, r, a + b, reach)
    return light.reshape(2, rows, ACROSS, columns, ACROSS).mean(axis=(2, 4))


def from_lamp(points, position):
    w = points - np.array(position)
    r = np.linalg.norm(w, axis=-1)
    return w / r[..., None], r


def beam(lamp, w, r, c, t):
    return lamp["intensity_w_per_sr"] * cone(lamp, w) / r**2 * np.exp(-c * (r + t))
