"""The folder of a job: what was asked for, the tasks, and what has become of them.

    job.json          what was asked for; never changed after `submit`
    waves/001.tasks   a line for each task of an array: frame, part, first sample, samples
    waves/001.sh      the script of that array, which may be edited before `sbatch` is called again by hand
    waves/001.id      the number that the scheduler gave it
    scenes/           scenes without Blender's file (--dump-only, or written by the first task of a frame)
    partial/0001/     the checkpoint of each task of a frame
    merged/0001.*     the merged checkpoint of a frame, and the list of the parts that are in it
    output/0001.exr   its image
    logs/             what the tasks have printed

All files are written beside their name and renamed. A job has one watcher at a time: the file `lock` names it.
"""

from __future__ import annotations

import json
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

STALE_SECONDS = 300.0


class FarmError(Exception):
    """What the user can do something about, as text."""


def write_atomically(path: Path, text: str) -> None:
    unfinished = path.with_name(f"{path.name}.part-{socket.gethostname()}-{os.getpid()}")
    try:
        with unfinished.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise FarmError(f"{path} cannot be written: {error.strerror}") from None


@dataclass(frozen=True)
class Request:
    """What `submit` was asked for."""

    scene: str
    frames: list[int]
    split: int                      # tasks of each frame in the first wave
    samples: int                    # of each frame in the first wave
    error: float = 0.0              # the noise target; 0: the samples of the first wave are all
    max_samples: int = 0            # of each frame; with a noise target
    seed: int = 0
    attempts: int = 3               # waves in which the same samples are tried
    dump_only: bool = False
    checkpoint_interval: float = 30.0
    grace: int = 60                 # seconds before a time limit at which a task writes its last checkpoint
    poll: float = 5.0
    render: str = "ajar-render"     # programs on the nodes
    blender: str = "blender"
    slurm: list[str] = field(default_factory=list)    # further options of sbatch
    options: list[str] = field(default_factory=list)  # of ajar-render


@dataclass(frozen=True)
class Task:
    """Samples [first, first + samples) of a frame. Its part is its number within the frame; the same samples have the same part."""

    frame: int
    part: int
    first: int
    samples: int

    def line(self) -> str:
        return f"{self.frame:04} {self.part:05} {self.first} {self.samples}"


class Job:
    def __init__(self, folder: Path, request: Request) -> None:
        self.folder, self.request = folder.resolve(), request

    @classmethod
    def create(cls, folder: Path, request: Request) -> Job:
        """A new job. Raises FarmError if the folder already has one with other wishes."""
        for name in ("waves", "scenes", "partial", "merged", "output", "logs"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        text = json.dumps(asdict(request), indent=1) + "\n"
        file = folder / "job.json"
        new = folder / f".job.json.{os.getpid()}.{os.urandom(4).hex()}"
        new.write_text(text, encoding="utf-8")
        try:
            # Two submitters at the same moment: one of them gives its file the name, and the other one reads it whole.
            os.link(new, file)
        except FileExistsError:
            if file.read_text(encoding="utf-8") != text:
                raise FarmError(f"{folder} has another job already (job.json differs). Use another folder, or `ajar-farm watch` for that job.") from None
        finally:
            new.unlink()
        return cls(folder, request)

    @classmethod
    def open(cls, folder: Path) -> Job:
        try:
            return cls(folder, Request(**json.loads((folder / "job.json").read_text(encoding="utf-8"))))
        except (OSError, ValueError, TypeError):
            raise FarmError(f"{folder} is no folder of a job: job.json is missing or damaged.") from None

    def scene_of(self, frame: int) -> Path:
        if self.request.scene.endswith(".ajar"):
            return Path(self.request.scene.replace("####", f"{frame:04}"))
        return self.folder / "scenes" / f"{frame:04}.ajar"

    def partial(self, frame: int, part: int) -> Path:
        return self.folder / "partial" / f"{frame:04}" / f"{part:05}.checkpoint"

    def is_complete(self, task: Task) -> bool:
        """The statistics are the last file that a task writes. Samples are no measure: integrators of chains count few of theirs in pixels."""
        part = self.partial(task.frame, task.part)
        return part.exists() and part.with_suffix(".json").exists()

    def merged(self, frame: int) -> Path:
        return self.folder / "merged" / f"{frame:04}.checkpoint"

    def output(self, frame: int) -> Path:
        return self.folder / "output" / f"{frame:04}.exr"

    def wave(self, number: int, ending: str) -> Path:
        return self.folder / "waves" / f"{number:03}.{ending}"

    def waves(self) -> list[int]:
        return sorted(int(path.stem) for path in (self.folder / "waves").glob("*.tasks"))

    def tasks(self, wave: int) -> list[Task]:
        return [Task(*map(int, line.split())) for line in self.wave(wave, "tasks").read_text(encoding="utf-8").splitlines()]

    @contextmanager
    def locked(self) -> Iterator[None]:
        """The watcher of the job. Raises FarmError if there is another one. A lock that nobody has touched for minutes is that of a dead one."""
        lock = self.folder / "lock"
        owner = f"{socket.gethostname()} {os.getpid()}"
        for _ in range(2):
            try:
                with lock.open("x", encoding="utf-8") as file:
                    file.write(owner)
                break
            except FileExistsError:
                if not _is_stale(lock):
                    raise FarmError(f"{self.folder} is watched already, by process {_text(lock)}. Only one may watch and merge.") from None
                # Of several that find it stale, one can rename it.
                try:
                    os.rename(lock, lock.with_name(f"lock.stale-{os.getpid()}"))
                    lock.with_name(f"lock.stale-{os.getpid()}").unlink()
                except FileNotFoundError:
                    pass
        else:
            raise FarmError(f"{self.folder} is watched already. Only one may watch and merge.")
        try:
            yield
        finally:
            if _text(lock) == owner:
                lock.unlink(missing_ok=True)

    def touch_lock(self) -> None:
        os.utime(self.folder / "lock")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        return "?"


def _is_stale(lock: Path) -> bool:
    try:
        host, _, pid = _text(lock).partition(" ")
        if host == socket.gethostname() and pid.isdigit():
            os.kill(int(pid), 0)
        return time.time() - lock.stat().st_mtime > STALE_SECONDS
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    except FileNotFoundError:
        return True
