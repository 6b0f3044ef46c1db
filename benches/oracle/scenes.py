"""Scenes in Mitsuba: rig coordinates of rodsight (x forward, y starboard, z down; metres), one wavelength, three channels.

The water is grey, so that the three channels of a render are three surfaces under the same light and the same random walk:
their differences cost no noise.
"""

import json
import math

import mitsuba as mi
import numpy as np

import guided

EYE_M = [0.0, -0.5, -1.0]  # the left eye of scenes/rigs/paper.toml
HALF_WIDTH = 960 / 1566.577619644  # tangents of half the field
SPOTS = {
    "positions_m": [[0.1, -0.9, -1.35], [0.1, 0.9, -1.35]],
    "aim_at_m": [2.5, 0.0, -0.7],
    "inner_deg": 35.0,
    "outer_deg": 65.0,
    "intensity_w_per_sr": 2.0,
}
POINT = {"positions_m": [[0.0, 0.0, -1.3]], "intensity_w_per_sr": 2.0}


def water(a, b, lamps_m, is_guided=True, lobes=guided.PETZOLD3):
    """A homogeneous medium; `a`, `b` per metre."""
    c = a + b
    return {
        "type": "homogeneous",
        "id": "water",
        "sigma_t": {"type": "spectrum", "value": c},
        "albedo": {"type": "spectrum", "value": b / c},
        "has_spectral_extinction": False,
        "phase": phase(lobes, lamps_m if is_guided else []),
    }


def phase(lobes, lamps_m):
    if lamps_m:
        return {"type": "guided", "lobes": json.dumps(lobes), "lamps_m": json.dumps(lamps_m)}
    (weight, g), *rest = lobes
    lobe = {"type": "hg", "g": g} if g else {"type": "isotropic"}
    if not rest:
        return lobe
    share = sum(w for w, _ in rest) / (weight + sum(w for w, _ in rest))
    return {"type": "blendphase", "weight": share, "one": lobe, "two": phase(rest, [])}


def in_water():
    return {"type": "ref", "id": "water"}


def medium_of(scene):
    """The water of a loaded scene, for cameras that are loaded by themselves."""
    return next(shape.interior_medium() for shape in scene.shapes() if shape.interior_medium())


def volume(medium, radius_m=15.0):
    """The water ends at a sphere of index 1."""
    return {
        "water": medium,
        "volume": {
            "type": "sphere",
            "center": EYE_M,
            "radius": radius_m,
            "bsdf": {"type": "null"},
            "interior": in_water(),
        },
    }


def matt(albedo, lamps_m):
    """`albedo` per channel."""
    return {"type": "guided_matt", "albedo": json.dumps(albedo), "lamps_m": json.dumps(lamps_m)}


def point_lamp(position_m, intensity):
    return {"type": "point", "position": position_m, "intensity": rgb(intensity), "medium": in_water()}


def ball_lamp(position_m, intensity, radius_m):
    """A lamp of finite size; it is black, and it shades."""
    return {
        "type": "sphere",
        "center": position_m,
        "radius": radius_m,
        "bsdf": {"type": "diffuse", "reflectance": rgb(0.0)},
        "exterior": in_water(),
        "interior": in_water(),
        "emitter": {"type": "area", "radiance": rgb(intensity / (math.pi * radius_m**2))},
    }


def rgb(value):
    return {"type": "rgb", "value": [value] * 3}


def cone_picture(inner_deg, outer_deg, size=1024):
    """rodsight's cone, smooth in the cosine, over the tangent plane of a spot."""
    inner, outer = (math.cos(math.radians(x)) for x in (inner_deg, outer_deg))
    t = (2 * (np.arange(size) + 0.5) / size - 1) * math.tan(math.radians(outer_deg))
    cos = 1 / np.sqrt(1 + t[None, :] ** 2 + t[:, None] ** 2)
    s = np.clip((cos - outer) / (inner - outer), 0, 1)
    return np.repeat((s * s * (3 - 2 * s))[..., None], 3, axis=2).astype(np.float32)


def spot_lamp(position_m, lamps):
    return {
        "type": "spot",
        "to_world": mi.ScalarTransform4f().look_at(origin=position_m, target=lamps["aim_at_m"], up=[0, 0, -1]),
        "intensity": rgb(lamps["intensity_w_per_sr"]),
        "cutoff_angle": lamps["outer_deg"],
        "beam_width": lamps["outer_deg"] - 1e-3,  # flat: the picture has the profile
        "texture": {
            "type": "bitmap",
            "bitmap": mi.Bitmap(cone_picture(lamps["inner_deg"], lamps["outer_deg"])),
            "raw": True,
            "wrap_mode": "clamp",
        },
        "medium": in_water(),
    }


def lamps_of(lamps):
    make = (lambda p: spot_lamp(p, lamps)) if "aim_at_m" in lamps else (lambda p: point_lamp(p, lamps["intensity_w_per_sr"]))
    return {f"lamp{i}": make(p) for i, p in enumerate(lamps["positions_m"])}


def camera(width, height, half_width=HALF_WIDTH, crop=None, eye_m=EYE_M):
    """An eye that looks along x; pixels are square and means over their area. `crop`: column, row, width, height."""
    film = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    if crop:
        film |= dict(zip(("crop_offset_x", "crop_offset_y", "crop_width", "crop_height"), crop))
    return {
        "type": "perspective",
        "fov_axis": "x",
        "fov": math.degrees(2 * math.atan(half_width)),
        "near_clip": 1e-5,  # the water before it would be left out
        "far_clip": 100.0,
        "to_world": mi.ScalarTransform4f().look_at(origin=eye_m, target=[eye_m[0] + 1, eye_m[1], eye_m[2]], up=[0, 0, -1]),
        "film": film,
        "sampler": {"type": "independent"},
        "medium": in_water(),
    }


def integrator(max_depth):
    """Depth 2 is single scattering. Roulette starts late: it would kill the light paths that guiding has found."""
    return {"type": "volpath", "max_depth": max_depth, "rr_depth": 16}


def wall(distance_m, bsdf, centre_y_m=EYE_M[1], emitter=None, half_m=(20.0, 20.0)):
    """A plane across the line of sight, its face to the camera."""
    t = mi.ScalarTransform4f()
    shape = {
        "type": "rectangle",
        "to_world": t.look_at(origin=[distance_m, centre_y_m, EYE_M[2]], target=[0, centre_y_m, EYE_M[2]], up=[0, 0, -1])
        @ t.scale([half_m[0], half_m[1], 1]),
        "bsdf": bsdf,
        "exterior": in_water(),
        "interior": in_water(),
    }
    if emitter:
        shape["emitter"] = emitter
    return shape


def seabed(z_m, bsdf):
    t = mi.ScalarTransform4f()
    return {
        "type": "rectangle",
        "to_world": t.look_at(origin=[0, 0, z_m], target=[0, 0, z_m - 1], up=[1, 0, 0]) @ t.scale([20, 20, 1]),
        "bsdf": bsdf,
        "exterior": in_water(),
        "interior": in_water(),
    }


def rod(centre_m, direction, length_m, radius_m, bsdf):
    centre, d = np.array(centre_m), np.array(direction) / np.linalg.norm(direction)
    ends = [(centre + s * 0.5 * length_m * d).tolist() for s in (-1, 1)]
    t = mi.ScalarTransform4f()
    cap = lambda end, outwards: {
        "type": "disk",
        "to_world": t.look_at(origin=end, target=(np.array(end) + outwards).tolist(), up=[1, 0.1, 0])
        @ t.scale([radius_m, radius_m, 1]),
        "bsdf": bsdf,
        "exterior": in_water(),
        "interior": in_water(),
    }
    side = {
        "type": "cylinder",
        "p0": ends[0],
        "p1": ends[1],
        "radius": radius_m,
        "bsdf": bsdf,
        "exterior": in_water(),
        "interior": in_water(),
    }
    return {"rod": side, "rod_top": cap(ends[0], -d), "rod_foot": cap(ends[1], d)}
