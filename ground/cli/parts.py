# SPDX-License-Identifier: GPL-3.0-or-later
"""Common parts of the command line: consoles, options, exit codes, how a command ends."""

from __future__ import annotations

import asyncio
import math
import signal
import sys
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer
from rich.console import Console

from ground.checks import STANDARD_OUTPUT, write_report
from ground.errors import BadInput, GroundError, NotReached

EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130
EXITS = (
    "Exit codes: 0 done, 1 not done, 2 wrong usage, 130 Ctrl-C "
    "(0 where Ctrl-C is the normal end: `sim`, and `demo` after its flight)."
)

# Headings of the commands in --help.
START, CONNECT, FLY = "Try first", "Connect", "Fly"
FILES, MEASURE = "Maps and recordings", "Measure"

out = Console(highlight=False)
"""For messages; goes to standard error if standard output is for JSON."""
err = Console(stderr=True, highlight=False, soft_wrap=True)


class _Wanted:
    """The file of --json, for a command that fails before it has written its report."""

    report: Path | None = None


def _json_file(file: Path | None) -> Path | None:
    _Wanted.report = file
    out.stderr = file == STANDARD_OUTPUT
    return in_folder(file)


def in_folder(file: Path | None) -> Path | None:
    """Option callback: check that a file's folder exists before anything flies."""
    if file and not file.absolute().parent.is_dir():
        raise typer.BadParameter(f"there is no folder {file.absolute().parent}")
    return file


def finite(number: float) -> float:
    """Option callback: refuse a number of metres that is not finite."""
    if not math.isfinite(number):
        raise typer.BadParameter(f"{number} is not a finite number")
    return number


def numbers(text: str, form: str, *counts: int) -> list[float]:
    """Parse comma-separated finite numbers; their number must be in `counts`, `form` names them."""
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) not in counts or not all(map(math.isfinite, found)):
        raise typer.BadParameter(f"{text!r} is not {form}")
    return found


JsonFile = Annotated[
    Path | None,
    typer.Option(
        "--json",
        metavar="FILE|-",
        allow_dash=True,
        dir_okay=False,
        writable=True,
        callback=_json_file,
        help="Write figures and checks as JSON; - is standard output.",
    ),
]
Port = Annotated[
    int | None,
    typer.Option(
        min=0,
        max=65535,
        metavar="PORT",
        help="Port of the page; if not given, the usual one or a free one.",
    ),
]
Profile = Annotated[
    Literal["real", "low", "hard", "perfect"],
    typer.Option(metavar="NAME", help="How much odometry drifts: real, low, hard or perfect."),
]
Seed = Annotated[
    int,
    typer.Option(min=0, metavar="N", help="The same seed gives the same room, noise and flight."),
]
World = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE",
        help="Name of a world, or a TOML file.",
        autocompletion=lambda: [file.stem for file in _WORLDS.glob("*.toml")],
    ),
]
_WORLDS = Path(__file__).parents[1] / "sim" / "worlds"
Uri = Annotated[
    str,
    typer.Option(
        envvar="CFLIB_URI", metavar="URI", help="The Crazyflie; if not given, the simulator."
    ),
]
Record = Annotated[
    Path | None,
    typer.Option(
        "--record",
        metavar="FILE|off",
        callback=in_folder,
        help="MCAP file to record into; if not given, a new one in your folder of recordings, of "
        "which the newest 2 GB are kept (the environment variable WAYFLIE_KEEP_GB).",
    ),
]


def fail(sentence: str, step: str = "", code: int = EXIT_FAILED) -> NoReturn:
    """End with a line that says what is wrong, and one that says what to do."""
    err.print(f"wayflie: {sentence}", markup=False)
    if step:
        err.print(f"  next: {step}", markup=False)
    sys.exit(code)


def end(error: GroundError) -> NoReturn:
    """End with an error and its next step, on the terminal and in the report if one is wanted."""
    if error.step:  # nextsteps imports the core, which may be the very thing that is missing
        step = error.step
    else:
        from ground.nextsteps import next_step

        step = next_step(error)
    if _Wanted.report and not isinstance(error, NotReached):  # whose command has written one
        figures = {"reached": False, "sentence": str(error), "next_step": step}
        write_report(_Wanted.report, figures, [])
    fail(str(error), step, EXIT_USAGE if isinstance(error, BadInput) else EXIT_FAILED)


def finish(work: Callable[[], bool]) -> None:
    """Run a command: exit 0 if it did what was asked, else as `EXITS` says."""
    # A termination signal acts like Ctrl-C: land first. Ctrl-C is enabled even for commands that a
    # script starts in the background, where shells disable it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        reached = work()
    except GroundError as error:
        end(error)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
    except OSError as error:
        if error.filename is None:
            raise
        fail(f"{error.filename}: {error.strerror}")
    if not reached:
        sys.exit(EXIT_FAILED)


def run(work: Coroutine[Any, Any, bool]) -> None:
    """Run a coroutine as finish() does."""
    finish(lambda: asyncio.run(work))
