"""The command line of ajar-farm."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from . import slurm
from .checkpoints import read_header
from .job import FarmError, Job, Request
from .watch import Watcher, follow, say


def frames_of(text: str) -> list[int]:
    """"1-250", "1,5,9", "1-10:3"."""
    frames: list[int] = []
    for part in text.split(","):
        bounds, _, step = part.partition(":")
        first, _, last = bounds.partition("-")
        try:
            found = range(int(first), int(last or first) + 1, int(step or 1))
        except ValueError:
            raise argparse.ArgumentTypeError(f'"{text}" is no list of frames such as 1-250 or 1,5,9') from None
        frames += found
    if not frames or min(frames) < 0:
        raise argparse.ArgumentTypeError(f'"{text}" contains no frame')
    return sorted(set(frames))


def _number(kind: type, minimum: float):
    def read(text: str):
        try:
            value = kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f'"{text}" is no number') from None
        if not value >= minimum:
            raise argparse.ArgumentTypeError(f"{text} is less than {minimum:g}")
        return value
    return read


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(prog="ajar-farm", description="Renders frames on a Slurm cluster. See docs/manual/farm.md.")
    commands = top.add_subparsers(dest="command", required=True)
    submit = commands.add_parser("submit", help="write the array script, submit it, watch, merge",
                                 description="Options after -- go to ajar-render, for example -- --integrator bdpt.")
    submit.add_argument("scene", help="FILE.blend, or FILE.ajar; #### in the name of the latter is the number of the frame")
    submit.add_argument("--frames", type=frames_of, default=[1], help="such as 1-250 or 1,5,9")
    submit.add_argument("--split", type=_number(int, 1), default=4, help="tasks of each frame")
    submit.add_argument("--samples", type=_number(int, 1), default=256, help="samples per pixel of each frame in the first array")
    submit.add_argument("--error", type=_number(float, 0.0), default=0.0, help="noise target of the merged image (relative mean squared error): further tasks until it is met")
    submit.add_argument("--max-samples", type=_number(int, 0), default=0, help="with --error: most samples per pixel; 0: no limit")
    submit.add_argument("--seed", type=_number(int, 0), default=0)
    submit.add_argument("--job", type=Path, help="the folder of the job, seen by all machines; default: ajar-jobs/NAME beside the scene")
    submit.add_argument("--dump-only", action="store_true", help="write .ajar scenes here, so that nodes need no Blender")
    submit.add_argument("--attempts", type=_number(int, 1), default=3, help="how often a task is submitted that ends without its samples")
    submit.add_argument("--checkpoint-interval", type=_number(float, 0.0), default=30.0, help="seconds")
    submit.add_argument("--grace", type=_number(int, 0), default=60, help="seconds before a time limit at which a task writes its last checkpoint")
    submit.add_argument("--poll", type=_number(float, 0.05), default=5.0, help="seconds between two looks at the queue")
    submit.add_argument("--render", default="ajar-render", help="the program, here and on the nodes")
    submit.add_argument("--blender", default="blender", help="the program, here (--dump-only) or on the nodes")
    submit.add_argument("--slurm", action="append", default=[], metavar="OPTION", help="a further option of sbatch, such as --slurm=--time=01:00:00; may be repeated")
    submit.add_argument("--script-only", action="store_true", help="write the folder and the script, and submit nothing")
    submit.add_argument("--no-watch", action="store_true", help="submit and return")
    for name, text in (("watch", "watch and merge a job again"), ("status", "what a job has rendered"), ("cancel", "end the tasks of a job; what they have rendered stays")):
        commands.add_parser(name, help=text).add_argument("job", type=Path)
    return top


def dump(job: Job) -> None:
    """Writes the scenes of all frames with one process of Blender."""
    missing = [frame for frame in job.request.frames if not job.scene_of(frame).exists()]
    if not missing:
        return
    say(f"writing {len(missing)} scenes")
    with tempfile.TemporaryDirectory(prefix="ajar-farm-") as folder:
        command = [job.request.blender, "-b", job.request.scene, "--addons", "ajar_render", "-E", "AJAR", "-o", f"{folder}/", "-F", "PNG", "-f", ",".join(map(str, missing)),
                   "--", "--ajar-dump-scene", str(job.folder / "scenes" / "####.ajar"), "--ajar-dump-only", "on"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            raise FarmError(f"{job.request.blender} is not installed here; --blender names the program.") from None
    without = [frame for frame in missing if not job.scene_of(frame).exists()]
    if without:
        raise FarmError(f"Blender has not written the scenes of frames {without}:\n{(done.stdout + done.stderr)[-2000:]}")


def submit(given: argparse.Namespace, options: list[str]) -> int:
    scene = Path(given.scene).resolve()
    if scene.suffix not in (".blend", ".ajar"):
        raise FarmError(f"{scene} is neither .blend nor .ajar.")
    if scene.suffix == ".ajar" and "####" not in scene.name and len(given.frames) > 1:
        raise FarmError(f"{scene} is one frame. #### in the name stands for the number of the frame.")
    folder = given.job or scene.parent / "ajar-jobs" / scene.stem.replace("#", "")
    for frame in given.frames:
        path = Path(str(scene).replace("####", f"{frame:04}")) if scene.suffix == ".ajar" else scene
        if not path.is_file():
            raise FarmError(f"There is no scene {path}.")
    job = Job.create(folder, Request(scene=str(scene), frames=given.frames, split=given.split, samples=given.samples, error=given.error, max_samples=given.max_samples,
                                     seed=given.seed, attempts=given.attempts, dump_only=given.dump_only, checkpoint_interval=given.checkpoint_interval, grace=given.grace,
                                     poll=given.poll, render=given.render, blender=given.blender, slurm=given.slurm, options=options))
    if scene.suffix == ".blend" and given.dump_only:
        dump(job)
    if given.script_only or given.no_watch:
        with job.locked():
            watcher = Watcher(job, (lambda script, tasks: "") if given.script_only else slurm.submit)
            if not job.waves():
                watcher.first_wave()
        return 0
    return follow(job, first=True)


def status(job: Job) -> int:
    for frame in job.request.frames:
        header = read_header(job.merged(frame))
        parts = sorted((job.folder / "partial" / f"{frame:04}").glob("*.checkpoint"))
        running = sum(found.samples for part in parts if (found := read_header(part)))
        merged = f"{header.samples:g} merged samples, noise {header.relmse:.3g}" if header else "nothing is merged"
        print(f"frame {frame}: {merged}; {running:g} samples in {len(parts)} parts")
    return 0


def cancel(job: Job) -> int:
    for wave in job.waves():
        array = job.wave(wave, "id")
        if array.exists():
            tasks = slurm.queued(array.read_text(encoding="utf-8").strip()) or set()
            slurm.cancel(array.read_text(encoding="utf-8").strip(), sorted(tasks))
            say(f"array {array.read_text(encoding='utf-8').strip()}: {len(tasks)} tasks cancelled")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    options = given[given.index("--") + 1:] if "--" in given else []
    parsed = parser().parse_args(given[:given.index("--")] if "--" in given else given)
    try:
        if parsed.command == "submit":
            return submit(parsed, options)
        job = Job.open(parsed.job)
        if parsed.command == "watch":
            return follow(job, first=False)
        return status(job) if parsed.command == "status" else cancel(job)
    except FarmError as error:
        print(f"ajar-farm: {error}", file=sys.stderr)
        return 2
