#!/usr/bin/python3
"""Measures the flicker of an animation with and without data that earlier frames have learned (docs/benchmarks/animation.md):

    PYTHONPATH=build/release/python benchmarks/flicker.py SCENE.ajar --integrator path --set guiding=on --samples 16 [--move 0.02]

SCENE.ajar comes from --ajar-dump-scene. The camera is at rest, or moves to its right by --move metres per frame. Every frame has its own seed. Two
independent sequences are each rendered cold (every frame alone) and warm (each frame with the learned data of the previous ones), in turn frame by
frame, with one thread. The first frame is omitted, since it has no previous one.

The error of a frame is (A_t - B_t)^2 / 2 of the two sequences. The flicker is ((A_t+1 - A_t) - (B_t+1 - B_t))^2 / 4, the change between frames that
is not in the scene. It equals the error if the errors of successive frames are independent, and is 0 if the noise does not change. Both are relative,
divided by R^2 + 0.01, where R is the blurred mean of all four images of a frame, with and without the worst 0.1 % of pixels. T is user CPU time from
the first sample, including pilots. The gain is the ratio of 1 / (T flicker). The ratio of means is that of all warm images to all cold ones.
"""

from __future__ import annotations

import argparse
import json
import os

import numpy as np
from in_process import finish

import ajar

BLUR = 2   # in pixels to each side


def render(options: argparse.Namespace, frame: int, seed: int, learned: ajar.Learned | None) -> tuple[np.ndarray, float, ajar.Learned, list[dict]]:
    """Image, user CPU seconds of its samples, learned data for the next frame, and the plan."""
    description = ajar.load_description(options.scene)
    settings, camera = description.settings, description.camera
    settings.height = max(1, round(settings.height * options.width / settings.width))
    settings.width, height = options.width, settings.height
    settings.region = [0, 0, options.width, height]
    settings.integrator, settings.samples, settings.seconds, settings.target_error = options.integrator, options.samples, 0.0, 0.0
    settings.seed, settings.threads, settings.passes = seed, 1, ["Combined"]
    for assignment in options.set:
        name, _, value = assignment.partition("=")
        setattr(settings, name, type(getattr(settings, name))(value))
    matrix = list(camera.world_from_camera)
    for axis in range(3):
        matrix[4 * axis + 3] += matrix[4 * axis] * options.move * frame
    camera.world_from_camera = matrix
    session = ajar.Session()
    session.begin_with(learned)
    session.start(description)
    seconds = finish(session)
    image = np.asarray(session.snapshot("Combined")).reshape(height, options.width, 4)[..., :3].astype(np.float64)
    return image, seconds, session.learned(), json.loads(session.statistics_json())["plan"]


def blurred(image: np.ndarray) -> np.ndarray:
    padded = np.pad(image, ((BLUR, BLUR), (BLUR, BLUR), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (2 * BLUR + 1, 2 * BLUR + 1), axis=(0, 1))
    return windows.mean(axis=(-2, -1))


def means(squared: np.ndarray) -> tuple[float, float]:
    """Means over frames x pixels: of all, and without the worst 0.1 %."""
    values = np.sort(squared, axis=None)
    return float(values.mean()), float(values[: int(values.size * 0.999)].mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="any of the render settings")
    parser.add_argument("--width", type=int, default=96)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--move", type=float, default=0.0, help="metres a frame")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()

    images: dict[str, list[list[np.ndarray]]] = {kind: [[], []] for kind in ("cold", "warm")}   # [sequence][frame]
    seconds = {"cold": 0.0, "warm": 0.0}
    learned: list[ajar.Learned | None] = [None, None]
    for frame in range(options.frames):
        for sequence in range(2):
            seed = options.seed * 100000 + sequence * 1000 + frame
            for kind in ("cold", "warm")[:: 1 if frame % 2 else -1]:
                image, spent, after, plan = render(options, frame, seed, learned[sequence] if kind == "warm" else None)
                images[kind][sequence].append(image)
                if frame > 0:
                    seconds[kind] += spent
                if kind == "warm":
                    learned[sequence] = after
                    if sequence == 0 and frame == options.frames - 1:
                        for step in plan:
                            if step["step"].startswith("learned"):
                                print(f"  {step['step']}: {'used' if step['used'] else 'not used'}, {step['reason']}")

    pictures = {kind: np.array(both)[:, 1:] for kind, both in images.items()}   # sequence, frame, y, x, channel
    truth = [blurred(frame) for frame in (pictures["cold"] + pictures["warm"]).mean(axis=0) / 2]
    if options.move == 0.0:
        truth = [np.mean(truth, axis=0)] * len(truth)
    scale = np.array([reference**2 + 0.01 for reference in truth])
    result = {}
    for kind, (a, b) in pictures.items():
        error = ((a - b) ** 2 / 2 / scale).mean(axis=-1)
        change = (np.diff(a, axis=0) - np.diff(b, axis=0)) ** 2 / 4 / scale[1:]
        result[kind] = means(error), means(change.mean(axis=-1)), seconds[kind]
    name = f"{os.path.basename(options.scene)} {options.integrator} {' '.join(options.set)} {options.samples} samples, move {options.move}, seed {options.seed}"
    for kind, ((error, error_trimmed), (flicker, flicker_trimmed), spent) in result.items():
        print(f"{name}: {kind} T={spent:.2f} error={error:.4g} ({error_trimmed:.4g}) flicker={flicker:.4g} ({flicker_trimmed:.4g})")
    gains = [result["cold"][1][i] * result["cold"][2] / (result["warm"][1][i] * result["warm"][2]) for i in range(2)]
    print(f"{name}: gain={gains[0]:.3f} trimmed={gains[1]:.3f} ratio of means={pictures['warm'].mean() / pictures['cold'].mean():.4f}", flush=True)


if __name__ == "__main__":
    main()
