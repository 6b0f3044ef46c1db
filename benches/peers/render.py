"""Seconds a stereo pair takes, ours and others', in one run on one machine: python render.py [--runs 3] [--rodsight PATH]

The scene is scenes/paper.toml: a rod over sand, two lamps, clear sea water, 1920 by 1080 px an eye. Prints a table in Markdown.
"""

import argparse
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, FOCAL_PX = 1920, 1080, 1566.577619644
EYES_M = [[0.0, -0.5, -1.0], [0.0, 0.5, -1.0]]
LAMPS_M, AIM_M = [[0.1, -0.9, -1.35], [0.1, 0.9, -1.35]], [2.5, 0.0, -0.7]
CENTRE_M, DIRECTION, LENGTH_M, RADIUS_M = [2.26, -0.4, -0.86], [-0.023, 0.029, 0.111], 2.9, 0.05
SEABED_Z_M = 0.15
IB = [0.227, 0.0516, 0.0372], [0.118, 0.125, 0.131]  # a, b at 600, 525, 475 nm


def rodsight(binary, mode):
    """The whole command, and what it says of rendering alone."""

    def run():
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "scene.toml"
            text = (ROOT / "scenes/paper.toml").read_text()
            scene.write_text(re.sub(r'^mode = "\w+"', f'mode = "{mode}"', text, flags=re.M))
            start = time.perf_counter()
            command = [binary, "render", scene, "-o", Path(folder) / "pair"]
            done = subprocess.run(command, capture_output=True, text=True)
            total = time.perf_counter() - start
        if done.returncode:
            raise RuntimeError(done.stderr.strip())
        return total, float(re.search(r" in ([0-9.]+) s", done.stdout)[1])

    return run


def mitsuba(spp):
    sys.path.insert(0, str(ROOT / "benches/oracle"))
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    import numpy as np
    import scenes

    a, b = (np.array(x) for x in IB)
    color = lambda x: {"type": "rgb", "value": [float(v) for v in x]}
    diffuse = lambda albedo: {"type": "diffuse", "reflectance": color(albedo)}
    water = scenes.water(0.0, 1.0, [])
    water |= {"sigma_t": color(a + b), "albedo": color(b / (a + b)), "has_spectral_extinction": True}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": 16},
            **scenes.volume(water, 30.0),
            **scenes.lamps_of(scenes.SPOTS),
            **scenes.rod(CENTRE_M, DIRECTION, LENGTH_M, RADIUS_M, diffuse([0.9, 0.3, 0.04])),
            "seabed": scenes.seabed(SEABED_Z_M, diffuse([0.42, 0.36, 0.26])),
        }
    )
    cameras = [mi.load_dict({**scenes.camera(WIDTH, HEIGHT, eye_m=eye), "medium": scenes.medium_of(scene)}) for eye in EYES_M]

    def run(spp=spp):
        start = time.perf_counter()
        for seed, camera in enumerate(cameras):
            np.array(mi.render(scene, sensor=camera, spp=spp, seed=seed))
        return (time.perf_counter() - start,) * 2

    run(1)  # compiles
    return run


def vtk_msaa(samples=8):
    """Colour with MSAA and depth, then instances by flat colours without it: a window each."""
    import vtk

    colors, instances = vtk_window(vtk, samples, False), vtk_window(vtk, 0, True)

    def draw(window, eye):
        renderer = window.GetRenderers().GetFirstRenderer()
        camera = renderer.GetActiveCamera()
        camera.SetPosition(eye)
        camera.SetFocalPoint(eye[0] + 1, eye[1], eye[2])
        camera.SetViewUp(0, 0, -1)
        camera.SetViewAngle(2 * math.degrees(math.atan(HEIGHT / 2 / FOCAL_PX)))
        renderer.ResetCameraClippingRange()
        window.Render()
        pixels, depth = vtk.vtkUnsignedCharArray(), vtk.vtkFloatArray()
        window.GetPixelData(0, 0, WIDTH - 1, HEIGHT - 1, 0, pixels, 0)
        window.GetZbufferData(0, 0, WIDTH - 1, HEIGHT - 1, depth)
        return pixels

    def run():
        start = time.perf_counter()
        pixels = [draw(window, eye) for eye in EYES_M for window in (colors, instances)]
        seconds = time.perf_counter() - start
        if min(p.GetValueRange(0)[1] for p in pixels) == 0:
            raise RuntimeError("VTK drew nothing")
        return seconds, seconds

    run()  # compiles
    return run


def vtk_window(vtk, samples, flat):
    renderer = vtk.vtkRenderer()
    rod = vtk.vtkCylinderSource()  # along y
    rod.SetResolution(64)
    rod.SetRadius(RADIUS_M)
    rod.SetHeight(LENGTH_M)
    bed = vtk.vtkPlaneSource()
    bed.SetOrigin(-20, -20, SEABED_Z_M)
    bed.SetPoint1(-20, 20, SEABED_Z_M)
    bed.SetPoint2(20, -20, SEABED_Z_M)
    turn = vtk.vtkTransform()
    turn.Translate(CENTRE_M)
    length = math.hypot(*DIRECTION)
    x, y, z = (v / length for v in DIRECTION)
    turn.RotateWXYZ(math.degrees(math.acos(y)), z, 0.0, -x)  # from y to the direction
    for index, (source, albedo) in enumerate([(bed, (0.42, 0.36, 0.26)), (rod, (0.9, 0.3, 0.04))]):
        mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
        mapper.SetInputConnection(source.GetOutputPort())
        actor.SetMapper(mapper)
        actor.GetProperty().SetLighting(not flat)
        actor.GetProperty().SetColor(((index + 1) / 255, 0, 0) if flat else albedo)
        if source is rod:
            actor.SetUserTransform(turn)
        renderer.AddActor(actor)
    for position in LAMPS_M:
        lamp = vtk.vtkLight()
        lamp.SetPositional(True)
        lamp.SetPosition(position)
        lamp.SetFocalPoint(AIM_M)
        lamp.SetConeAngle(65.0)
        renderer.AddLight(lamp)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(samples)
    window.SetSize(WIDTH, HEIGHT)
    window.AddRenderer(renderer)
    return window


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--rodsight", default=ROOT / "target/release/rodsight")
    options = parser.parse_args()
    modes = ["air", "single", "full"]
    peers = {f"rodsight {mode}": lambda m=mode: rodsight(options.rodsight, m) for mode in modes}
    peers |= {"VTK, MSAA 8": vtk_msaa, "Mitsuba volpath, 16 spp": lambda: mitsuba(16)}
    runs, times = {}, {}
    for name, make in peers.items():
        try:
            runs[name], times[name] = make(), []
            runs[name]()
        except (ImportError, RuntimeError, OSError) as error:
            print(f"{name} left out: {error}", file=sys.stderr)
            runs.pop(name, None)
    for _ in range(options.runs):
        for name, run in runs.items():
            times[name].append(run())
    processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    print(f"{processor[1] if processor else platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, ", end="")
    print(
        f"{options.runs} runs each in turn, medians (fastest)\n\n| renderer | s a pair, files written | s a pair, rendering |\n|---|---|---|"
    )
    for name, run in runs.items():
        total, alone = zip(*times[name])
        cell = lambda x: f"{statistics.median(x):.2f} ({min(x):.2f})"
        print(f"| {name} | {cell(total) if name.startswith('rodsight') else '–'} | {cell(alone)} |")


if __name__ == "__main__":
    main()
