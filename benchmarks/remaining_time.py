#!/usr/bin/python3
"""Measures the accuracy of the remaining time that a session reports:

    PYTHONPATH=build/release/python benchmarks/remaining_time.py FOLDER [SCENE ...] [--targets 1e-2 4e-3] [--out results.json]
    benchmarks/remaining_time.py --show results.json ...

FOLDER has scenes of `--ajar-dump-scene`. Each is rendered to each noise target, with uniform and adaptive sampling. The result is the remaining time
that the session reports at 10, 25, 50 and 75 % of the render, divided by the true remaining time. The render starts when the scene has been built,
and includes the choice of a technique.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from pathlib import Path

PARTS = (0.10, 0.25, 0.50, 0.75)
ENDLESS = 1 << 24
POLL_SECONDS = 0.005


def render(path: Path, width: int, integrator: str, image: str, target: float, samples: int, longest: float, seed: int) -> dict:
    """The reports of the session during one render. `told` has pairs of seconds since the scene was built and remaining seconds."""
    import ajar   # the build in PYTHONPATH

    description = ajar.load_description(str(path))
    settings = description.settings
    settings.height = max(1, round(settings.height * width / settings.width))
    settings.width, settings.region = width, [0, 0, width, settings.height]
    settings.integrator, settings.image, settings.seed = integrator, image, seed
    settings.samples, settings.seconds, settings.target_error = samples, 0.0, target
    session = ajar.Session()
    session.start(description)
    told: list[tuple[float, float]] = []   # seconds since the start, reported remaining seconds
    started: float | None = None
    last = -1
    while True:
        ended = session.wait(POLL_SECONDS)
        now, progress = time.monotonic(), session.progress()
        built = progress.phase != ajar.Progress.Phase.Building or progress.step == "Choosing a technique"
        if started is None and built:
            started = now
        if ended:
            break
        if started is not None and progress.iteration > 0 and progress.iteration != last:
            last = progress.iteration
            told.append((now - started, progress.remaining_seconds))
        if started is not None and now - started > longest:
            session.cancel()
            session.wait(60.0)
            break
    error = session.take_error()
    if error:
        raise RuntimeError(f"{path.name}: {error}")
    if started is None:
        raise RuntimeError(f"{path.name}: the render ended before the scene was built")
    is_whole = session.progress().phase == ajar.Progress.Phase.Done
    history = json.loads(session.statistics_json())
    return {"scene": path.stem, "integrator": history["integrator"], "asked": integrator, "image": image, "target": target, "samples": samples, "is_whole": is_whole,
            "seconds": now - started, "pilot_seconds": history["pilot_seconds"], "render_seconds": history["render_seconds"], "told": told, "estimated_error": history["estimated_error"]}


def ratios(run: dict) -> list[float | None]:
    """Reported divided by true time at each part of the render; None: no report yet."""
    found = []
    for part in PARTS:
        at = part * run["seconds"]
        latest = [remaining for seconds, remaining in run["told"] if seconds <= at]
        # The displayed time counts down from the last report.
        since = [seconds for seconds, _ in run["told"] if seconds <= at]
        found.append((latest[-1] - (at - since[-1])) / (run["seconds"] - at) if latest and latest[-1] >= 0.0 else None)
    return found


def ratios_in_samples(run: dict, exponent: float) -> list[float | None]:
    """The same for samples instead of seconds, if the error falls with this exponent. It does not depend on the load of the machine."""
    found = []
    end = run["estimated_error"][-1][1]
    for part in PARTS:
        latest = next((point for point in reversed(run["estimated_error"]) if point[1] <= part * end), None)
        found.append(None if latest is None else max(0.0, (latest[2] / run["target"]) ** (1.0 / exponent) - 1.0) * latest[1] / (end - latest[1]))
    return found


def table(runs: list[dict], exponent: float = 0.0) -> str:
    lines = ["| scene | technique | sampling | end | seconds | " + " | ".join(f"{100 * part:.0f} %" for part in PARTS) + " |", "|---|---|---|---|---|" + "---|" * len(PARTS)]
    columns: list[list[float]] = [[] for _ in PARTS]
    for run in runs:
        end = f"{100.0 * run['target'] ** 0.5:.2g} %" if run["target"] > 0.0 else f"{run['samples']} samples"
        cells = ratios_in_samples(run, exponent) if exponent > 0.0 else ratios(run)
        for column, cell in zip(columns, cells):
            if cell is not None:
                column.append(cell)
        lines.append(f"| {run['scene']} | {run['integrator']} | {run['image']} | {end} | {run['seconds']:.1f} | " + " | ".join("–" if cell is None else f"{cell:.2f}" for cell in cells) + " |")
    lines.append("| **median** | | | | | " + " | ".join(f"**{statistics.median(column):.2f}**" if column else "–" for column in columns) + " |")
    lines.append("| **within 20 %** | | | | | " + " | ".join(f"**{sum(abs(c - 1) <= 0.2 for c in column)} of {len(column)}**" for column in columns) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--integrators", nargs="+", default=["path"])
    parser.add_argument("--images", nargs="+", default=["uniform", "pmc_ip"])
    parser.add_argument("--targets", nargs="+", type=float, default=[1e-2, 4e-3, 2e-3], help="relative mean squared errors at which a render ends")
    parser.add_argument("--samples", type=int, default=0, help="number of samples instead of a noise target")
    parser.add_argument("--longest", type=float, default=60.0, help="seconds after which a render is cancelled")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--show", nargs="+", type=Path, help="print the table of existing results")
    parser.add_argument("--exponent", type=float, default=0.0, help="with --show: remaining samples, for an error that falls with this exponent")
    options = parser.parse_args()
    if options.show:
        runs = [run for path in options.show for run in json.loads(path.read_text())]
        print(table([run for run in runs if run["is_whole"]], options.exponent))
        return
    if options.folder is None:
        parser.error("name the folder with the scenes")
    runs = []
    for path in sorted(options.folder.glob("*.ajar")):
        if options.scenes and path.stem not in options.scenes:
            continue
        for integrator in options.integrators:
            for image in options.images:
                ends = [(0.0, options.samples)] if options.samples else [(target, ENDLESS) for target in sorted(options.targets, reverse=True)]
                for target, samples in ends:
                    run = render(path, options.width, integrator, image, target, samples, options.longest, options.seed)
                    print(path.stem, integrator, image, target, f"{run['seconds']:.1f} s", ["–" if r is None else f"{r:.2f}" for r in ratios(run)] if run["is_whole"] else "given up", flush=True)
                    runs.append(run)
                    if options.out is not None:
                        options.out.write_text(json.dumps(runs))
                    if not run["is_whole"]:
                        break   # a lower noise takes longer
    print(table([run for run in runs if run["is_whole"]]))


if __name__ == "__main__":
    main()
