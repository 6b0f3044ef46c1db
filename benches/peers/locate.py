"""Milliseconds to look for the rod in a stereo pair, ours and others', in one run on one machine, each on one thread:
python locate.py [--runs 7] [--build FOLDER]

The pair is scenes/paper.toml, rendered afresh, 1920 by 1080 px an eye: whole, and a region of 640 by 700 px an eye around the rod. Images
are in memory before any clock starts. Prints a table in Markdown for each size.

rodsight's time is what its solver says of itself: `first call` as the command makes it, else solved before in that process, as others' are.
Needs numpy and opencv-python-headless, and a release build of the command and of the examples imageproc_chain and solve_warm.
"""

import argparse
import json
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

try:
    import cv2
    import numpy as np
except ImportError as error:
    sys.exit(f"{error}: expected OpenCV and numpy; pip install opencv-python-headless numpy")

ROOT = Path(__file__).resolve().parents[2]
EYES = ["left", "right"]
REGION_PX = 640, 700
BLUR_SIGMA_PX = 1.4  # imageproc's Canny blurs by as much, unasked
GREY_CANNY, MASK_CANNY = (50, 150), (100, 200)
GREY_VOTES = 100  # cells of 1 px by 1°: imageproc has no others
PAPER_RHO_PX, PAPER_THETA_DEG, PAPER_VOTES = 2.5, 4.5, 50
PAPER_NEAR_PX, PAPER_ROUNDS = 3.0, 2
LEAST_POINTS, SAME_PX, SAME_DEG = 30, 1.5, 1.0
MOST_OFF_PX = 5.0  # who passes a limb by more has lost it


class Clock:
    """Milliseconds by stage and in all, summed over both eyes."""

    def __init__(self):
        self.ms = {"total": 0.0}

    def __call__(self, stage, function, *arguments):
        start = time.perf_counter()
        result = function(*arguments)
        self.add(stage, (time.perf_counter() - start) * 1e3)
        return result

    def add(self, stage, ms):
        self.ms[stage] = self.ms.get(stage, 0.0) + ms
        self.ms["total"] += ms


def classic(clock, grey):
    blurred = clock("blur", cv2.GaussianBlur, grey, (0, 0), BLUR_SIGMA_PX)
    edges = clock("Canny", cv2.Canny, blurred, *GREY_CANNY)
    return lines_of(clock("HoughLines", cv2.HoughLines, edges, 1.0, math.radians(1.0), GREY_VOTES)), edges


def paper(clock, image, hues):
    """The steps of our `paper`, the 3 by 3 median among them, which the print does not have; it is shown the hues, ours learns them."""
    hsv = clock("HSV", cv2.cvtColor, image, cv2.COLOR_BGR2HSV)
    mask = clock("median", cv2.medianBlur, clock("inRange", in_range, hsv, hues), 3)
    edges = clock("Canny", cv2.Canny, mask, *MASK_CANNY)
    found = clock("HoughLines", cv2.HoughLines, edges, PAPER_RHO_PX, math.radians(PAPER_THETA_DEG), PAPER_VOTES)
    return clock("refine", refine, edges, lines_of(found)), mask


def in_range(hsv, hues):
    low, high, saturation, value = hues
    if low <= high:
        return cv2.inRange(hsv, (low, saturation, value), (high, 255, 255))
    return cv2.bitwise_or(in_range(hsv, (low, 180, saturation, value)), in_range(hsv, (0, high, saturation, value)))


def lines_of(found):
    return [] if found is None else found.reshape(-1, found.shape[-1])[:, :2].astype(float).tolist()


def refine(edges, lines):
    """Points near a line are collected and fitted, lines that coincide become one: twice."""
    points = cv2.findNonZero(edges)
    if points is None:
        return []
    u, v = points.reshape(-1, 2).T + 0.5
    for _ in range(PAPER_ROUNDS):
        fitted = []
        for rho, theta in lines:
            near = np.abs(u * math.cos(theta) + v * math.sin(theta) - rho) < PAPER_NEAR_PX
            if np.count_nonzero(near) < LEAST_POINTS:
                continue
            um, vm = u[near].mean(), v[near].mean()
            du, dv = u[near] - um, v[near] - vm
            theta = 0.5 * math.atan2(-2.0 * (du @ dv), dv @ dv - du @ du)
            rho = um * math.cos(theta) + vm * math.sin(theta)
            if all(abs(rho - r) > SAME_PX or abs(theta - t) > math.radians(SAME_DEG) for r, t in fitted):
                fitted.append((rho, theta))
        lines = fitted
    return lines


def at_row(v, rho, theta):
    return (rho - v * math.sin(theta)) / math.cos(theta)


def call(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, env=os.environ | {"RAYON_NUM_THREADS": "1"})
    if done.returncode:
        sys.exit(f"{command[0]}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


class Job:
    """The pair at one size, and everything that is timed on it. Each run gives milliseconds by stage."""

    def __init__(self, build, pair, truth, corners_px, size_px):
        self.build, self.pair, self.size_px = build, pair, size_px
        self.pick = "{},{}".format(*truth["grasp"]["pick_px"])
        self.regions = [f"{x},{y},{size_px[0]},{size_px[1]}" for x, y in corners_px]
        self.limbs, self.images = [], []
        for eye, (x, y) in zip(EYES, corners_px):
            lines = [truth["rods"][0][eye]["lines"][limb] for limb in ["plus_limb", "minus_limb"]]
            self.limbs.append([at_row(y + size_px[1] / 2, line["rho_px"], line["theta_rad"]) - x for line in lines])
            whole = cv2.imread(str(pair / f"{eye}.png"))
            self.images.append(np.ascontiguousarray(whole[y : y + size_px[1], x : x + size_px[0]]))
        self.greys = [cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in self.images]
        self.hues = [self.hues_of(eye) for eye in EYES]
        masks = [paper(Clock(), image, hues)[1] for image, hues in zip(self.images, self.hues)]
        self.files = {"grey": self.written("grey", self.greys), "mask": self.written("mask", masks)}
        name = "rodsight `{}`".format
        ours = lambda method: {name(method): partial(self.warm, method), name(method) + ", first call": partial(self.cold, method)}
        # What is timed, in groups: the first of a group is what the others are compared with.
        grey = {"OpenCV, grey: blur, Canny, HoughLines": partial(self.opencv, classic, self.greys)}
        grey |= {"imageproc, grey: Canny, Hough": partial(self.imageproc, "grey", GREY_CANNY)}
        colour = {"OpenCV and numpy: the paper's chain": partial(self.opencv, paper, self.images, self.hues)}
        colour |= {"imageproc, its mask: Canny, Hough": partial(self.imageproc, "mask", MASK_CANNY)}
        self.groups = [grey | ours("joint"), colour | ours("paper") | ours("paper-bisector")]

    def written(self, name, images):
        paths = [self.pair / f"{self.size_px[0]}-{name}-{eye}.png" for eye in EYES]
        for path, image in zip(paths, images):
            cv2.imwrite(str(path), image)
        return paths

    def hues_of(self, eye):
        """What our `paper` took for the rod, in OpenCV's units: both shall see the same edges."""
        words = self.solve("paper")["observability"][eye]["segmentation"]
        found = re.match("hue (.*)° to (.*)°, saturation from (.*), value from ([0-9.]*)", words)
        if not found:
            sys.exit(f"rodsight: expected a window of hues, found `{words}`")
        low, high, saturation, value = map(float, found.groups())
        return low / 2, high / 2, saturation * 255, value * 255

    def check(self, who, index, lines):
        """Who loses the rod is no measure of another's speed: where a limb crosses the middle row there must be a line."""
        found = [at_row(self.size_px[1] / 2, *line) for line in lines if abs(math.cos(line[1])) > 0.5]
        for limb in self.limbs[index]:
            if min((abs(u - limb) for u in found), default=math.inf) > MOST_OFF_PX:
                sys.exit(f"{who}, {EYES[index]} eye: expected a line at {limb:.1f} px, where a limb of the rod is, found {found}")

    def opencv(self, chain, *inputs):
        for clock in [Clock(), Clock()]:  # the first warms up, as the examples do
            for index, arguments in enumerate(zip(*inputs)):
                lines, _ = chain(clock, *arguments)
                self.check(f"OpenCV, {chain.__name__}", index, lines)
        return clock.ms

    def imageproc(self, name, thresholds):
        clock = Clock()
        rows = call(self.build / "examples/imageproc_chain", *thresholds, GREY_VOTES, *self.files[name]).splitlines()
        for index, row in enumerate(rows):
            canny_ms, hough_ms, *lines = row.split()
            clock.add("Canny", float(canny_ms))
            clock.add("Hough", float(hough_ms))
            self.check("imageproc", index, [(float(rho), math.radians(float(deg))) for rho, deg in (line.split(",") for line in lines)])
        return clock.ms

    def solve(self, method):
        images = ["--left", self.pair / "left.png", "--right", self.pair / "right.png", "--rig", self.pair / "rig.toml"]
        where = ["--roi-left", self.regions[0], "--roi-right", self.regions[1], "--pick", self.pick]
        return json.loads(call(self.build / "rodsight", "solve", *images, *where, "--method", method, "--json"))

    def cold(self, method):
        return self.solve(method)["timing_ms"]

    def warm(self, method):
        return json.loads(call(self.build / "examples/solve_warm", self.pair, method, self.pick, *self.regions))["timing_ms"]

    def report(self, times):
        print(f"\n| {self.size_px[0]} × {self.size_px[1]} px an eye | ms a pair, median (fastest–slowest) | ÷ OpenCV's | stages, ms |")
        print("|---|---|---|---|")
        for group in self.groups:
            medians = {name: statistics.median(run["total"] for run in times[name]) for name in group}
            rival, *_ = medians.values()
            for name, median in medians.items():
                totals = [run["total"] for run in times[name]]
                stages = {stage: statistics.median(run[stage] for run in times[name]) for stage in times[name][0] if stage != "total"}
                words = ", ".join(f"{stage} {ms:.2f}" for stage, ms in stages.items() if ms > 0)
                print(f"| {name} | {median:.2f} ({min(totals):.2f}–{max(totals):.2f}) | {median / rival:.2f} | {words} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    parser.add_argument("--build", type=Path, default=target / "release", help="the folder of the command and of examples/")
    options = parser.parse_args()
    for name in ["rodsight", "examples/imageproc_chain", "examples/solve_warm"]:
        if not (options.build / name).is_file():
            sys.exit(f"{options.build / name} is missing: cargo build --release -p rodsight -p rodsight-benches --bins --examples")
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        pair = Path(folder) / "pair"
        call(options.build / "rodsight", "render", ROOT / "scenes/paper.toml", "-o", pair)
        truth = json.loads((pair / "truth.json").read_text())
        size_px = tuple(truth["rig"]["left"][side] for side in ["width_px", "height_px"])
        axes = [truth["rods"][0][eye]["lines"]["axis"] for eye in EYES]
        starts = [at_row(size_px[1] / 2, axis["rho_px"], axis["theta_rad"]) - REGION_PX[0] / 2 for axis in axes]
        room = size_px[0] - REGION_PX[0], size_px[1] - REGION_PX[1]
        corners_px = [(round(min(max(x, 0), room[0])), room[1] // 2) for x in starts]
        jobs = [Job(options.build, pair, truth, corners_px, REGION_PX), Job(options.build, pair, truth, [(0, 0)] * 2, size_px)]
        times = [{name: [] for group in job.groups for name in group} for job in jobs]
        for turn in range(options.runs + 1):
            for job, kept in zip(jobs, times):
                for name, run in [item for group in job.groups for item in group.items()]:
                    ms = run()
                    if turn > 0:  # the first warms up
                        kept[name].append(ms)
    processor = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    imageproc = re.search(r'name = "imageproc"\nversion = "(.*)"', (ROOT / "Cargo.lock").read_text())[1]
    machine = f"{processor[1] if processor else platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"
    ours = call(options.build / "rodsight", "--version").strip()
    versions = f"{ours}, OpenCV {cv2.__version__}, numpy {np.__version__}, imageproc {imageproc}"
    print(f"{machine}, one thread each; {versions};\n{options.runs} runs each in turn. A stage of rodsight's is that of the slower eye.")
    for job, kept in zip(jobs, times):
        job.report(kept)


if __name__ == "__main__":
    main()
