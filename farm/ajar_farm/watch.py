"""Follows the tasks of a job, merges what they have rendered, and submits further tasks until each frame is done.

A frame is done when its tasks are, or when the merged image has reached the noise target. Its remaining tasks are then cancelled. A task that has ended without all of
its samples (it was cancelled, or its node is gone) is submitted again, up to `attempts` times; then it costs only the samples that it lacks, because its checkpoint is merged.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from . import slurm
from .checkpoints import read_header
from .job import FarmError, Job, Task, write_atomically
from .script import array_script

MERGED_AT_ONCE = 200      # parts on one command line
LARGEST_STEP = 4.0        # a further wave has at most so many times the samples so far
MARGIN = 1.1              # of the samples that the noise target seems to need


def say(text: str) -> None:
    print(time.strftime("%H:%M:%S ") + text, flush=True)


@dataclass
class Frame:
    number: int
    tasks: dict[int, Task] = field(default_factory=dict)    # by part
    attempts: dict[int, int] = field(default_factory=dict)
    complete: set[int] = field(default_factory=set)
    active: set[int] = field(default_factory=set)
    merged_parts: set[int] = field(default_factory=set)
    refused: set[int] = field(default_factory=set)
    relmse: float = -1.0
    samples: float = 0.0
    next_sample: int = 0
    identity: dict | None = None    # what its checkpoints have in common
    done: bool = False


class Watcher:
    def __init__(self, job: Job, send: Callable[[Path, int], str] = slurm.submit) -> None:
        """`send` submits a script with so many tasks and returns the number of the array."""
        self.job, self.send = job, send
        self.frames = {number: Frame(number) for number in job.request.frames}
        self.arrays: dict[int, str] = {}     # by wave
        self.ended: set[int] = set()         # waves
        for wave in job.waves():
            self._know(wave)
        for frame in self.frames.values():
            frame.merged_parts = self._read_parts(frame.number)
            if header := read_header(job.merged(frame.number)):
                frame.relmse, frame.samples = header.relmse, header.samples

    # ---- Waves --------------------------------------------------------------------------------

    def first_wave(self) -> None:
        r = self.job.request
        bounds = [r.samples * k // r.split for k in range(r.split + 1)]
        # All frames get their first part before any gets its second: there is an image of each frame soon.
        self.submit([Task(frame, part, bounds[part], bounds[part + 1] - bounds[part]) for part in range(r.split) for frame in r.frames if bounds[part + 1] > bounds[part]])

    def submit(self, tasks: list[Task]) -> None:
        for at in range(0, len(tasks), slurm.LONGEST_ARRAY):
            some = tasks[at:at + slurm.LONGEST_ARRAY]
            wave = max(self.job.waves(), default=0) + 1
            write_atomically(self.job.wave(wave, "tasks"), "".join(task.line() + "\n" for task in some))
            write_atomically(self.job.wave(wave, "sh"), array_script(self.job, wave))
            self.job.wave(wave, "sh").chmod(0o755)
            write_atomically(self.job.wave(wave, "id"), self.send(self.job.wave(wave, "sh"), len(some)) + "\n")
            self._know(wave)
            say(f"array {self.arrays[wave] or 'not submitted'}: {len(some)} tasks, {self.job.wave(wave, 'sh')}")

    def _know(self, wave: int) -> None:
        try:
            self.arrays[wave] = self.job.wave(wave, "id").read_text(encoding="utf-8").strip()
        except OSError:   # it was written, but not submitted
            self.arrays[wave] = ""
            self.ended.add(wave)
        for task in self.job.tasks(wave):
            frame = self.frames[task.frame]
            frame.tasks[task.part] = task
            frame.attempts[task.part] = frame.attempts.get(task.part, 0) + 1
            frame.next_sample = max(frame.next_sample, task.first + task.samples)

    # ---- Following ----------------------------------------------------------------------------

    def run(self) -> bool:
        """Until all frames are done. Returns False if some have no image, or fewer samples or more noise than was asked for."""
        while not all(frame.done for frame in self.frames.values()):
            self.step()
            if not all(frame.done for frame in self.frames.values()):
                time.sleep(self.job.request.poll)
        return self._report()

    def step(self) -> None:
        self.job.touch_lock()
        if not self._look():
            return
        for frame in self.frames.values():
            if not frame.done:
                self._merge(frame, final=not frame.active)
                self._decide(frame)
        again = [task for frame in self.frames.values() if not frame.done for task in self._missing(frame)]
        if again:
            self.submit(again)

    def _look(self) -> bool:
        """Reads which tasks run and which are complete. Returns False if Slurm does not answer."""
        running: dict[int, set[int]] = {}
        for wave, array in self.arrays.items():
            if wave in self.ended:
                continue
            found = slurm.queued(array)
            if found is None:
                say("Slurm does not answer; trying again")
                return False
            running[wave] = found
            if not found:
                self.ended.add(wave)
        for frame in self.frames.values():
            frame.active = set()
        for wave, indices in running.items():
            tasks = self.job.tasks(wave)
            for index in indices:
                frame = self.frames[tasks[index - 1].frame]
                frame.active.add(tasks[index - 1].part)
        for frame in self.frames.values():
            for part, task in frame.tasks.items():
                if part not in frame.active and self.job.is_complete(task):
                    frame.complete.add(part)
        return True

    def _missing(self, frame: Frame) -> list[Task]:
        """Tasks that have ended without all of their samples and have attempts left, and those of a further wave."""
        r = self.job.request
        lost = [task for part, task in sorted(frame.tasks.items()) if part not in frame.complete and part not in frame.active]
        again = [task for task in lost if frame.attempts[task.part] < r.attempts]
        for task in again:
            say(f"frame {frame.number}: part {task.part} has ended early and is submitted again")
            frame.merged_parts.discard(task.part)
        if again or frame.active or r.error <= 0.0 or frame.relmse < 0.0:
            return again
        # The noise target is not reached. Noise falls with the number of samples.
        factor = min(LARGEST_STEP, MARGIN * frame.relmse / r.error)
        asked = sum(frame.tasks[part].samples for part in frame.merged_parts)
        more = int(asked * max(0.0, factor - 1.0)) + r.split
        if r.max_samples > 0:
            more = min(more, r.max_samples - frame.next_sample)
        if more <= 0:
            return []
        part, first = max(frame.tasks) + 1, frame.next_sample
        bounds = [first + more * k // r.split for k in range(r.split + 1)]
        say(f"frame {frame.number}: noise {frame.relmse:.3g} after {frame.samples:g} samples; {more} more")
        return [Task(frame.number, part + k, bounds[k], bounds[k + 1] - bounds[k]) for k in range(r.split) if bounds[k + 1] > bounds[k]]

    def _decide(self, frame: Frame) -> None:
        r = self.job.request
        if r.error > 0.0 and 0.0 <= frame.relmse <= r.error:
            frame.done = True
            self._cancel(frame)
            say(f"frame {frame.number}: done, noise {frame.relmse:.3g} after {frame.samples:g} samples")
            return
        lost = [part for part in frame.tasks if part not in frame.complete and part not in frame.active]
        hopeless = all(frame.attempts[part] >= r.attempts for part in lost)
        if frame.active or not hopeless:
            return
        exhausted = r.max_samples > 0 and frame.next_sample >= r.max_samples
        if r.error <= 0.0 or exhausted or frame.relmse < 0.0:
            frame.done = True
            without = f", {len(lost)} parts lack samples" if lost else ""
            say(f"frame {frame.number}: done, {frame.samples:g} samples{without}")

    def _cancel(self, frame: Frame) -> None:
        for wave, array in self.arrays.items():
            if wave not in self.ended and frame.active:
                slurm.cancel(array, [index + 1 for index, task in enumerate(self.job.tasks(wave)) if task.frame == frame.number and task.part in frame.active])

    # ---- Merging ------------------------------------------------------------------------------

    def _parts_file(self, frame: int) -> Path:
        return self.job.folder / "merged" / f"{frame:04}.parts"

    def _read_parts(self, frame: int) -> set[int]:
        """The parts in the merged checkpoint. If it is not whole, or not the one of the list, everything is merged again."""
        try:
            stamp, *parts = self._parts_file(frame).read_text(encoding="utf-8").split()
            return set(map(int, parts)) if stamp == _stamp(self.job.merged(frame)) else set()
        except (OSError, ValueError):
            return set()

    def _merge(self, frame: Frame, final: bool) -> None:
        """Adds the checkpoints of complete tasks; at the end also of those that have ended early and will not be tried again."""
        give_up = {part for part in frame.tasks if final and part not in frame.complete and frame.attempts[part] >= self.job.request.attempts}
        ready = sorted(part for part in (frame.complete | give_up) - frame.merged_parts - frame.refused if self.job.partial(frame.number, part).exists())
        ready = [part for part in ready if self._fits(frame, part)]
        for at in range(0, len(ready), MERGED_AT_ONCE):
            self._merge_some(frame, ready[at:at + MERGED_AT_ONCE])

    def _fits(self, frame: Frame, part: int) -> bool:
        """Refuses a checkpoint of another scene or of other settings. Damage to what follows the header is found by ajar-render."""
        header = read_header(self.job.partial(frame.number, part))
        if frame.identity is None:
            frame.identity = self._identity(frame.number)
        if why := header.difference(frame.identity) if header else "":
            say(f"frame {frame.number}: left out: {self.job.partial(frame.number, part)}: {why}")
            self._refuse(frame, part)
            return False
        return True

    def _identity(self, frame: int) -> dict:
        command = [self.job.request.render, str(self.job.scene_of(frame)), "-", "--identity", *self.job.request.options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise FarmError(f"frame {frame}: {done.stderr.strip()}")
        return json.loads(done.stdout)

    def _merge_some(self, frame: Frame, parts: list[int]) -> None:
        merged = self.job.merged(frame.number)
        before = [merged] if frame.merged_parts and merged.exists() else []
        files = [*before, *(self.job.partial(frame.number, part) for part in parts)]
        done = subprocess.run([self.job.request.render, "--merge", "--keep-going", str(self.job.output(frame.number)), str(merged), *map(str, files)],
                              capture_output=True, text=True, check=False)
        left_out = {part for part in parts if f"left out: {self.job.partial(frame.number, part)}:" in done.stderr}
        for line in done.stderr.splitlines():
            say(f"frame {frame.number}: {line}")
        if done.returncode != 0 and len(left_out) < len(parts):
            raise FarmError(f"frame {frame.number} cannot be merged: {done.stderr.strip()}")
        for part in left_out:
            self._refuse(frame, part)
        if done.returncode != 0:
            return
        if before and f"left out: {merged}:" in done.stderr:   # the merged file was damaged: everything is merged again, next time
            frame.merged_parts = set(parts) - left_out
        else:
            frame.merged_parts |= set(parts) - left_out
        write_atomically(self._parts_file(frame.number), " ".join([_stamp(merged), *map(str, sorted(frame.merged_parts))]) + "\n")
        if header := read_header(merged):
            frame.relmse, frame.samples = header.relmse, header.samples

    def _refuse(self, frame: Frame, part: int) -> None:
        """A checkpoint that is damaged or does not fit is moved aside, and its task counts as lost."""
        path = self.job.partial(frame.number, part)
        path.replace(path.with_suffix(".refused"))
        path.with_suffix(".json").unlink(missing_ok=True)
        frame.complete.discard(part)
        if frame.attempts[part] >= self.job.request.attempts:
            frame.refused.add(part)

    def _report(self) -> bool:
        r, good = self.job.request, True
        for frame in self.frames.values():
            enough = frame.samples > 0 and (0.0 <= frame.relmse <= r.error if r.error > 0.0 else frame.complete >= set(frame.tasks))
            good &= enough
            if not enough:
                say(f"frame {frame.number}: {frame.samples:g} samples, noise {frame.relmse:.3g}: less than was asked for")
        say(f"images: {self.job.folder / 'output'}")
        return good


def _stamp(merged: Path) -> str:
    stat = merged.stat()
    return f"{stat.st_size}:{stat.st_mtime_ns}"


def follow(job: Job, first: bool) -> int:
    """Submits the first wave, if `first` and there is none, and watches. Returns the exit code."""
    with job.locked():
        watcher = Watcher(job)
        if first and not job.waves():
            watcher.first_wave()
        if not job.waves():
            raise FarmError(f"{job.folder} has no tasks.")
        try:
            return 0 if watcher.run() else 1
        except KeyboardInterrupt:
            print(f"The tasks go on. `ajar-farm watch {job.folder}` follows them again, `ajar-farm cancel {job.folder}` ends them.", file=sys.stderr)
            return 130
