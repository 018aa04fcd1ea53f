"""The program ajar-farm with a Slurm that is none."""
from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("AJAR_BUILD", ROOT / "build" / "release"))
NODE_FAILS = 99  # the number of a "signal" after which a task is queued again (fake_slurm.py)
sys.path.insert(0, str(BUILD / "python"))
sys.path.insert(0, str(ROOT / "farm"))


class Farm:
    def __init__(self, folder: Path) -> None:
        self.folder, self.state, self.job = folder, folder / "slurm", folder / "job"
        self.state.mkdir()
        programs = folder / "programs"
        programs.mkdir()
        for name in ("sbatch", "squeue", "scancel"):
            (programs / name).symlink_to(Path(__file__).with_name("fake_slurm.py"))
        self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "FAKE_SLURM": str(self.state)}

    def start(self, *arguments: object) -> subprocess.Popen:
        return subprocess.Popen([sys.executable, str(ROOT / "farm" / "ajar-farm"), *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=self.environment)

    def run(self, *arguments: object) -> subprocess.CompletedProcess:
        return subprocess.run([sys.executable, str(ROOT / "farm" / "ajar-farm"), *map(str, arguments)], capture_output=True, text=True, check=False, env=self.environment, timeout=300)

    def arguments(self, scene: Path, *more: object) -> list[object]:
        options = more[more.index("--") + 1:] if "--" in more else ()
        more = more[:more.index("--")] if "--" in more else more
        return ["submit", scene, "--job", self.job, "--render", BUILD / "ajar-render", "--poll", 0.1, "--checkpoint-interval", 0.05, "--seed", 3, *more,
                "--", "--integrator", "path", *options]

    def submit(self, scene: Path, *more: object) -> subprocess.CompletedProcess:
        return self.run(*self.arguments(scene, *more))

    def kill_at_first_checkpoint(self, signals: dict[int, int]) -> None:
        """The task of each part gets the signal when its first checkpoint exists."""
        checkpoints = self.job / "partial" / "0001"
        (self.state / "orders").write_text("".join(f"{part + 1} {number} {checkpoints}/{part:05}.checkpoint\n" for part, number in signals.items()))

    def runs(self) -> list[str]:
        return (self.state / "runs").read_text().splitlines()
