"""Options on Blender's command line, after `--`.

    blender -b --addons ajar_render FILE.blend -E AJAR -o //out -F PNG -f 1 -- --ajar-samples 64 --ajar-stats out.json

Each option overrides the corresponding setting of the user interface; every setting of the core that has a property has an option. Other arguments are
ignored. Errors are detected when the add-on is enabled, before anything is rendered; in background mode Blender then ends with exit code 2.
"""

from __future__ import annotations

import argparse
import functools
import os
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NoReturn

import bpy

from . import core_settings

PREFIX = "--ajar-"
EXIT_BAD_OPTION = 2
EXIT_NO_IMAGE = 1
PREVIEW_SAMPLES, PREVIEW_SECONDS = 32, 2.0
STROKE_SAMPLES = 64   # strokes are flat colours: samples only smooth their edges

_SHORT_NAMES = {"time_limit": "time", "noise_target": "error"}   # options with another name than their property


class OptionError(Exception):
    """An error in the command line, with a message for the user."""


@dataclass
class Options:
    """The values of the options. `settings`: by the names of the properties that they override. The others are None if they are not given."""

    settings: dict[str, Any] = field(default_factory=dict)
    threads: int | None = None
    carry_learning: bool | None = None
    denoise: bool | None = None
    stats: Path | None = None
    checkpoint: Path | None = None
    resume: Path | None = None
    dump_scene: Path | None = None
    dump_only: bool = False


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


def _on_or_off(text: str) -> bool:
    return _name(("on", "off"))(text) == "on"


def _setting(prop: str) -> Callable[[str], object]:
    """As in the user interface: the same choices, the same minimum. The maximum is that of the core, if it has one."""
    info = core_settings.SETTINGS[prop]
    if info.type == "bool":
        return _on_or_off
    if info.type in ("int", "float"):
        maximum = info.property_maximum if info.maximum == core_settings.UNBOUNDED else info.maximum
        return _number(int if info.type == "int" else float, info.property_minimum, maximum)
    return _name(core_settings.names(prop))


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


SETTING_READERS = {_SHORT_NAMES.get(prop, prop).replace("_", "-"): (prop, _setting(prop)) for prop in core_settings.SETTINGS}
READERS: dict[str, Callable[[str], object]] = {name: reader for name, (_, reader) in SETTING_READERS.items()} | {
    "carry-learning": _on_or_off,
    "denoise": _on_or_off,
    "threads": _number(int, 0, 1024),
    "stats": _file,
    "dump-scene": _file,
    "dump-only": _on_or_off,
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
    settings = {prop: vars(found)[name.replace("-", "_")] for name, (prop, _) in SETTING_READERS.items()}
    given = {prop: value for prop, value in settings.items() if value is not None}
    return Options(settings=given, **{of.name: vars(found)[of.name] for of in fields(Options) if of.name != "settings"})


def of_frame(path: Path, frame: int) -> Path:
    """The path with the number of the frame in place of the last run of "#" in its name, as in Blender; the same path without one."""
    return path.with_name(re.sub(r"#+(?=[^#]*$)", lambda run: f"{frame:0{len(run[0])}}", path.name))


def current() -> Options:
    """The options of this process. An invalid command line has been refused before."""
    try:
        return parse(sys.argv)
    except OptionError:
        return Options()


def preview() -> Options:
    """Options for previews of materials, worlds and lamps: few samples."""
    return Options({"integrator": "path", "direct": "mis", "direct_samples": 1, "samples": PREVIEW_SAMPLES, "time_limit": PREVIEW_SECONDS, "noise_target": 0.0})


def strokes() -> Options:
    """Options for the strokes of Freestyle, which Blender passes to the engine as a scene of its own."""
    return Options({"integrator": "path", "image": "uniform", "direct": "mis", "direct_samples": 1, "samples": STROKE_SAMPLES, "time_limit": 0.0,
                    "noise_target": 0.0}, threads=current().threads, carry_learning=False, denoise=False)


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
