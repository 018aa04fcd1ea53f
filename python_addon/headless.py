"""Options on Blender's command line, after `--`.

    blender -b --addons ajar_render FILE.blend -E AJAR -o //out -F PNG -f 1 -- --ajar-samples 64 --ajar-stats out.json

Each option overrides the corresponding setting of the user interface. Other arguments are ignored. Errors are detected when the add-on is enabled,
before anything is rendered; in background mode Blender then ends with exit code 2.
"""

from __future__ import annotations

import argparse
import functools
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import bpy

from . import core_settings

PREFIX = "--ajar-"
EXIT_BAD_OPTION = 2
EXIT_NO_IMAGE = 1
PREVIEW_SAMPLES, PREVIEW_SECONDS = 32, 2.0

ON_OR_OFF = ("on", "off")


class OptionError(Exception):
    """An error in the command line, with a message for the user."""


@dataclass
class Options:
    """The values of the options; None if an option is not given."""

    integrator: str | None = None
    direct: str | None = None
    direct_samples: int | None = None
    guiding: str | None = None
    vertex_merging: str | None = None
    image: str | None = None
    samples: int | None = None
    time: float | None = None
    error: float | None = None
    seed: int | None = None
    threads: int | None = None
    carry_learning: str | None = None
    denoise: str | None = None
    memory_limit: int | None = None
    stats: Path | None = None
    checkpoint: Path | None = None
    resume: Path | None = None
    dump_scene: Path | None = None


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise OptionError(message)


def _name(valid: Sequence[str]) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in valid:
            raise argparse.ArgumentTypeError(f'has no "{text}"; valid: {", ".join(valid)}')
        return text
    return read


def _number(kind: type, minimum: float, maximum: float) -> Callable[[str], float]:
    wanted = "a whole number" if kind is int else "a number"

    def read(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = None
        # NaN fails both comparisons.
        if value is None or not minimum <= value <= maximum:
            raise argparse.ArgumentTypeError(f'needs {wanted} from {minimum:g} to {maximum:.10g}, not "{text}"')
        return value
    return read


def _setting(name: str) -> Callable[[str], object]:
    """As in the user interface: the same choices, the same range."""
    info = core_settings.SETTINGS[name]
    return _number(int, info.property_minimum, info.property_maximum) if info.type == "int" else _name(core_settings.names(name))


def _file(text: str) -> Path:
    path = Path(text).expanduser().absolute()
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f'cannot write "{text}": there is no folder "{path.parent}"')
    if path.is_dir():
        raise argparse.ArgumentTypeError(f'cannot write "{text}": it is a folder')
    return path


def _existing(text: str) -> Path:
    path = Path(text).expanduser().absolute()
    if not path.is_file():
        raise argparse.ArgumentTypeError(f'cannot read "{text}": there is no such file')
    return path


READERS: dict[str, Callable[[str], object]] = {
    "integrator": _setting("integrator"),
    "direct": _setting("direct"),
    "direct-samples": _setting("direct_samples"),
    "guiding": _setting("guiding"),
    "vertex-merging": _setting("vertex_merging"),
    "image": _setting("image"),
    "samples": _number(int, 1, 2**31 - 1),
    "time": _number(float, 1e-3, 1e9),
    "error": _number(float, 1e-12, 1e6),
    "seed": _number(int, core_settings.SETTINGS["seed"].minimum, core_settings.SETTINGS["seed"].maximum),
    "carry-learning": _name(ON_OR_OFF),
    "denoise": _name(ON_OR_OFF),
    "threads": _number(int, 0, 1024),
    "memory-limit": _setting("memory_limit"),
    "stats": _file,
    "dump-scene": _file,
    "checkpoint": _file,
    "resume": _existing,
}
_MISSING = object()   # the value of an option without a value


@functools.cache
def _parser() -> argparse.ArgumentParser:
    parser = _Parser(add_help=False, allow_abbrev=False, exit_on_error=False)
    for name, reader in READERS.items():
        parser.add_argument(PREFIX + name, type=reader, nargs="?", const=_MISSING, dest=name.replace("-", "_"))
    return parser


def parse(argv: Sequence[str]) -> Options:
    """The options among `argv` (the whole command line). Raises OptionError."""
    arguments = argv[argv.index("--") + 1:] if "--" in argv else []
    try:
        found, others = _parser().parse_known_args([argument for argument in arguments if argument != "--"])
    except argparse.ArgumentError as error:
        raise OptionError(f"{error.argument_name} {error.message}") from None
    for argument in others:
        if argument.startswith(PREFIX):
            valid = ", ".join(PREFIX + known for known in READERS)
            raise OptionError(f'there is no option "{argument.partition("=")[0]}"; valid: {valid}')
    for name, value in vars(found).items():
        if value is _MISSING:
            raise OptionError(f"{PREFIX}{name.replace('_', '-')} needs a value after it")
    return Options(**vars(found))


def current() -> Options:
    """The options of this process. An invalid command line has been refused before."""
    try:
        return parse(sys.argv)
    except OptionError:
        return Options()


def preview() -> Options:
    """Options for previews of materials, worlds and lamps: few samples."""
    return Options(integrator="path", direct="mis", direct_samples=1, samples=PREVIEW_SAMPLES, time=PREVIEW_SECONDS, error=0.0)


def check() -> None:
    """Refuse an invalid command line: print the error and, in background mode, end Blender."""
    try:
        parse(sys.argv)
    except OptionError as error:
        say_error(str(error))
        if bpy.app.background:
            leave(EXIT_BAD_OPTION)


def say_error(message: str) -> None:
    print(f"Ajar: error: {message}", file=sys.stderr, flush=True)


def renders_from_command_line() -> bool:
    """True if Blender renders by its arguments `-f` or `-a`. Blender itself then does not report a failure in its exit code."""
    own = sys.argv[:sys.argv.index("--")] if "--" in sys.argv else sys.argv
    return bpy.app.background and any(argument in ("-f", "-a", "--render-frame", "--render-anim") for argument in own)


def leave(code: int) -> None:
    """End Blender immediately with an exit code, for which its background mode has no other way."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
