"""Reference numbers of light under water by Monte Carlo: python run.py [--passes N] [GROUP[:WORD+WORD] ...]

A pass adds SEEDS independent renders to a case; `--passes N` runs every case up to N of them. Results go to results/GROUP.json
after each pass, so that a run may be stopped and taken up again. `rod:1C+64` runs those cases of a group
whose keys have these values.
"""

import argparse
import csv
import functools
import json
import math
import os
import time
from pathlib import Path

import numpy as np
import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import drjit
import closed_form
import guided
import scenes

HERE = Path(__file__).parent
TABLE = HERE / "../../crates/optics/data/jerlov.csv"
WATERS = ["IB", "II", "III", "1C", "3C", "5C"]
COLUMNS, ROWS = 8, 4  # blocks of the image
SEEDS = 8
FULL, SINGLE = 64, 2  # depths
CARD = [0.5, 0.0, 0.25]  # albedo of the card per channel
LAMPS = {"spots": scenes.SPOTS, "point": scenes.POINT}


def coefficients(name, wavelength_nm):
    """Absorption and scattering per metre, as measured by Williamson and Hollins (2022)."""
    for row in csv.DictReader(TABLE.open()):
        if row["water_type"] == name and int(row["wavelength_nm"]) == wavelength_nm and "Williamson" in row["source"]:
            return float(row["a_per_m"]), float(row["b_per_m"])
    raise KeyError(f"{TABLE}: no row of Williamson and Hollins for {name} at {wavelength_nm} nm")


def statistics(samples):
    """Mean and standard error over independent renders, of the whole and of its parts. samples: [seed, row, column]"""
    root = np.sqrt(len(samples))
    whole = samples.mean(axis=(1, 2))
    return {
        "mean": rounded(whole.mean()),
        "standard_error": rounded(whole.std(ddof=1) / root),
        "blocks": rounded(samples.mean(axis=0).ravel()),
        "blocks_standard_error": rounded(samples.std(axis=0, ddof=1).ravel() / root),
    }


def pooled(old, new):
    """Statistics of the renders of two runs together."""
    n, m = old["seeds"], new["seeds"]
    if old["samples_per_seed"] != new["samples_per_seed"]:
        raise ValueError(f"renders of {old['samples_per_seed']} and {new['samples_per_seed']} samples cannot be pooled: {old}")
    result = dict(new, seeds=n + m)
    for key in [key for key, value in new.items() if isinstance(value, dict)]:
        result[key] = dict(new[key])
        for mean, error in (("mean", "standard_error"), ("blocks", "blocks_standard_error")):
            if mean not in new[key]:
                continue
            a, b, da, db = (np.array(x) for x in (old[key][mean], new[key][mean], old[key][error], new[key][error]))
            squares = da**2 * n * (n - 1) + db**2 * m * (m - 1) + (a - b) ** 2 * n * m / (n + m)
            result[key][mean] = rounded((n * a + m * b) / (n + m))
            result[key][error] = rounded(np.sqrt(squares / ((n + m) * (n + m - 1))))
    return result


def rounded(values):
    return np.vectorize(lambda v: float(f"{v:.6g}"))(values).tolist()


def render(scene, first_seed, spp):
    """[seed, row, column, channel]; nothing is clamped or left out."""
    loaded = mi.load_dict({"type": "scene", **scene})
    return images(loaded, loaded.sensors()[0], first_seed, spp)


def images(scene, camera, first_seed, spp):
    seeds = range(first_seed, first_seed + SEEDS)
    return np.array([np.array(mi.render(scene, sensor=camera, seed=seed, spp=spp)) for seed in seeds], dtype=np.float64)


def card_scene(a, b, lamps, distance_m, depth, is_guided=True, lobes=guided.PETZOLD3):
    positions = lamps["positions_m"]
    return {
        "integrator": scenes.integrator(depth),
        "sensor": scenes.camera(COLUMNS, ROWS),
        **scenes.volume(scenes.water(a, b, positions, is_guided, lobes)),
        **scenes.lamps_of(lamps),
        "wall": scenes.wall(distance_m, scenes.matt(CARD, positions)),
    }


def card_case(lamps, name, wavelength_nm, distance_m, depth, seed):
    a, b = coefficients(name, wavelength_nm)
    spp = 2048 if depth == SINGLE else 1024
    light = render(card_scene(a, b, LAMPS[lamps], distance_m, depth), seed, spp)
    return {
        "absorption_per_m": a,
        "scattering_per_m": b,
        "samples_per_seed": spp * COLUMNS * ROWS,
        "backscatter": statistics(light[..., 1]),
        "card": statistics(light[..., 0] - light[..., 1]),
    }


def card_cases(lamps, depth, distances_m=(2.0, 1.0, 4.0)):
    waters = [(name, 525) for name in WATERS] + [("1C", 600)]
    for distance_m in distances_m:
        for name, nm in waters:
            key = {"lamps": lamps, "water": name, "wavelength_nm": nm, "distance_m": distance_m, "max_depth": depth}
            yield key, lambda seed, n=name, w=nm, d=distance_m: card_case(lamps, n, w, d, depth, seed)


def single_cases():
    for lamps in LAMPS:
        yield from card_cases(lamps, SINGLE, [2.0])


def check_cases():
    """The oracle against closed forms, and guided against plain sampling."""
    ISOTROPIC, HG = [(1.0, 0.0)], [(1.0, 0.924)]
    for title, lamps, a, b, lobes in [
        ("vacuum", "spots", 0.0, 1e-9, ISOTROPIC),
        ("absorbing", "spots", 0.2, 1e-9, ISOTROPIC),
        ("isotropic", "point", 0.1, 0.43, ISOTROPIC),
        ("henyey_greenstein", "point", 0.1, 0.43, HG),
        ("petzold3", "spots", 0.1, 0.43, guided.PETZOLD3),
    ]:
        key = {"check": title, "lamps": lamps, "distance_m": 2.0, "max_depth": SINGLE}
        yield key, lambda seed, a=a, b=b, l=lobes, p=LAMPS[lamps]: closed_form_case(a, b, l, p, seed)
    # Lamps of finite size: near a point the light has no finite variance, and plain sampling would need far more time than we have.
    for is_guided in (True, False):
        key = {"check": "guided" if is_guided else "plain", "lamps": "balls", "distance_m": 2.0, "max_depth": FULL}
        yield key, lambda seed, g=is_guided: sampling_case(g, 0.1, 0.43, seed)


def closed_form_case(a, b, lobes, lamps, seed):
    light = render(card_scene(a, b, lamps, 2.0, SINGLE, False, lobes), seed, 4096)
    backscatter, card = closed_form.blocks(a, b, lobes, lamps, 2.0, CARD[0], COLUMNS, ROWS)
    return {
        "absorption_per_m": a,
        "scattering_per_m": b,
        "samples_per_seed": 4096 * COLUMNS * ROWS,
        "lobes": lobes,
        "backscatter": statistics(light[..., 1]) | {"closed_form": backscatter.ravel().tolist()},
        "card": statistics(light[..., 0] - light[..., 1]) | {"closed_form": card.ravel().tolist()},
    }


def sampling_case(is_guided, a, b, seed):
    scene = card_scene(a, b, scenes.SPOTS, 2.0, FULL, is_guided)
    for k, position in enumerate(scenes.SPOTS["positions_m"]):
        scene[f"lamp{k}"] = scenes.ball_lamp(position, scenes.SPOTS["intensity_w_per_sr"], 0.1)
    light = render(scene, seed, 2048)
    return {
        "absorption_per_m": a,
        "scattering_per_m": b,
        "samples_per_seed": 2048 * COLUMNS * ROWS,
        "backscatter": statistics(light[..., 1]),
        "card": statistics(light[..., 0] - light[..., 1]),
    }


EDGE_COLUMNS, EDGE_HALF_WIDTH = 60, np.tan(np.radians(15))


def edge_case(name, distance_m, seed):
    """A half plane that shines with radiance 1 to the right of the line of sight, black to its left."""
    a, b = coefficients(name, 525)
    black = {"type": "diffuse", "reflectance": scenes.rgb(0.0)}
    shine = {"type": "area", "radiance": scenes.rgb(1.0)}
    eye_y = scenes.EYE_M[1]
    scene = {
        "integrator": scenes.integrator(FULL),
        "sensor": scenes.camera(EDGE_COLUMNS, 1, EDGE_HALF_WIDTH),
        **scenes.volume(scenes.water(a, b, [])),
        "bright": scenes.wall(distance_m, black, eye_y + 6, shine, (6.0, 6.0)),
        "dark": scenes.wall(distance_m, black, eye_y - 6, None, (6.0, 6.0)),
    }
    light = render(scene, seed, 256)
    return {
        "absorption_per_m": a,
        "scattering_per_m": b,
        "samples_per_seed": 256 * EDGE_COLUMNS,
        "profile": statistics(light[..., 0]),
    }


def edge_cases():
    for name, distance_m in [("IB", 3), ("III", 2), ("1C", 1), ("1C", 2), ("3C", 2), ("5C", 1), ("5C", 2), ("1C", 4)]:
        key = {"water": name, "wavelength_nm": 525, "distance_m": float(distance_m), "max_depth": FULL}
        key |= {"columns": EDGE_COLUMNS, "half_width_deg": 15.0}
        yield key, lambda seed, n=name, d=float(distance_m): edge_case(n, d, seed)


# The rod over sand of scenes/paper.toml at 160 by 90 px, its sand without texture. Channels: the scene, the same with a black rod,
# all black but the water.
ROD = {
    "centre_m": [2.26, -0.4, -0.86],
    "direction": [-0.023, 0.029, 0.111],
    "length_m": 2.9,
    "radius_m": 0.05,
    "albedo": [0.3, 0.0, 0.0],
    "seabed_z_m": 0.15,
    "seabed_albedo": [0.36, 0.36, 0.0],
    "width_px": 160,
    "height_px": 90,
}
ROD_BLOCKS = {  # column, row, width, height
    "rod": [81, 40, 4, 4],
    "water_in_shadow": [86, 20, 8, 10],
    "water": [125, 15, 20, 15],
    "water_beside_rod": [68, 30, 6, 10],
    "sand_in_shadow": [100, 80, 4, 8],
    "sand": [125, 80, 20, 8],
    "whole": [0, 0, 160, 90],
}


@functools.lru_cache(maxsize=1)
def rod_scene(a, b, depth):
    positions = scenes.SPOTS["positions_m"]
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": scenes.integrator(depth),
            **scenes.volume(scenes.water(a, b, positions), 30.0),
            **scenes.lamps_of(scenes.SPOTS),
            **scenes.rod(
                *(ROD[k] for k in ("centre_m", "direction", "length_m", "radius_m")), scenes.matt(ROD["albedo"], positions)
            ),
            "seabed": scenes.seabed(ROD["seabed_z_m"], scenes.matt(ROD["seabed_albedo"], positions)),
        }
    )


def rod_case(a, b, block, depth, seed):
    crop = ROD_BLOCKS[block]
    scene = rod_scene(a, b, depth)
    camera = scenes.camera(ROD["width_px"], ROD["height_px"], crop=crop) | {"medium": scenes.medium_of(scene)}
    spp = math.ceil((16_384 if depth == FULL else 32_768) / (crop[2] * crop[3]))
    light = images(scene, mi.load_dict(camera), seed, spp)
    names = ("radiance", "radiance_black_rod", "radiance_all_black")
    means = {name: statistics(light[..., k]) for k, name in enumerate(names)}
    for mean in means.values():
        del mean["blocks"], mean["blocks_standard_error"]
    samples = spp * crop[2] * crop[3]
    return {"absorption_per_m": a, "scattering_per_m": b, "samples_per_seed": samples} | means


def rod_cases():
    waters = [("air", SINGLE)] + [(name, depth) for name in ("1C", "IB", "3C") for depth in (FULL, SINGLE)]
    for name, depth in waters:
        a, b = coefficients(name, 525) if name != "air" else (0.0, 1e-9)
        for block in ROD_BLOCKS:
            key = {"water": name, "wavelength_nm": 525, "max_depth": depth, "block": block, "pixels": ROD_BLOCKS[block]}
            yield key, lambda seed, a=a, b=b, k=block, d=depth: rod_case(a, b, k, d, seed)


GROUPS = {
    "checks": check_cases,
    "single": single_cases,
    "spots": lambda: card_cases("spots", FULL),
    "edge": edge_cases,
    "rod": rod_cases,
    "point": lambda: card_cases("point", FULL, [2.0]),
}


def write(path, group, cases):
    meta = {
        "about": "Monte Carlo means and standard errors, W m^-2 sr^-1; see benches/oracle/README.md",
        "mitsuba": mi.__version__,
        "drjit": drjit.__version__,
        "phase": guided.PETZOLD3,
        "eye_m": scenes.EYE_M,
        "half_width": scenes.HALF_WIDTH,
        "columns": COLUMNS,
        "rows": ROWS,
        "card_albedo": CARD[0],
        "lamps": LAMPS,
        "rod": ROD,
    }
    part = path.with_suffix(".part")
    lines = ",\n".join(json.dumps(case) for case in cases)
    part.write_text(f'{{\n"meta": {json.dumps(meta)},\n"cases": [\n{lines}\n]\n}}\n')
    os.replace(part, path)


def add_pass(path, group, key, run, passes):
    """One more pass of a case, unless it has as many."""
    cases = json.loads(path.read_text())["cases"] if path.exists() else []
    old = next((case for case in cases if key.items() <= case.items()), None)
    seeds = old["seeds"] if old else 0
    if seeds >= passes * SEEDS:
        return
    start = time.time()
    new = key | {"seeds": SEEDS} | run(seeds)
    if old:
        new = pooled(old, new)
        cases[cases.index(old)] = new
    else:
        cases.append(new)
    write(path, group, cases)
    means = [f"{k} {v['mean']:.5g} ± {v['standard_error']:.2g}" for k, v in new.items() if isinstance(v, dict)]
    print(group, *key.values(), new["seeds"], *means, f"{time.time() - start:.0f} s", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--passes", type=int, default=4)
    parser.add_argument("groups", nargs="*", default=list(GROUPS))
    options = parser.parse_args()
    guided.register()
    for passes in range(1, options.passes + 1):
        for group, _, words in (name.partition(":") for name in options.groups):
            path = HERE / "results" / f"{group}.json"
            path.parent.mkdir(exist_ok=True)
            for key, run in GROUPS[group]():
                if not words or set(words.split("+")) <= set(map(str, key.values())):
                    add_pass(path, group, key, run, passes)


if __name__ == "__main__":
    main()
