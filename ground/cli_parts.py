# SPDX-License-Identifier: GPL-3.0-or-later
"""What the files of the command line share: consoles, options, how a command ends."""

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
    "Exit codes: 0 it reached what was asked, 1 it did not, 2 wrong usage, 130 Ctrl-C "
    "(0 where that is how it ends well: `sim`, and `demo` after its flight)."
)
SIMULATOR_URI = "udp://127.0.0.1:19850"

# Headings of the commands in --help.
START, CONNECT, FLY = "Try first", "Connect", "Fly"
FILES, MEASURE = "Maps and recordings", "Measure"

out = Console(highlight=False)
"""What a command tells; on standard error where standard output is for JSON."""
err = Console(stderr=True, highlight=False, soft_wrap=True)


class _Wanted:
    """Where this command's figures shall go; read again where it fails before it has any."""

    report: Path | None = None


def _json_file(file: Path | None) -> Path | None:
    """What --json says: before anything flies it is known that it can be written."""
    _Wanted.report = file
    out.stderr = file == STANDARD_OUTPUT
    if file and file != STANDARD_OUTPUT and not file.absolute().parent.is_dir():
        raise typer.BadParameter(f"there is no folder {file.absolute().parent}")
    return file


def finite(number: float) -> float:
    """A number of metres that is one."""
    if not math.isfinite(number):
        raise typer.BadParameter(f"{number} is no place")
    return number


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
    typer.Option(min=0, max=65535, metavar="PORT", help="Of the page; the usual or a free one."),
]
Profile = Annotated[
    Literal["real", "low", "hard", "perfect"],
    typer.Option(metavar="NAME", help="How odometry drifts: real, low, hard or perfect."),
]
Seed = Annotated[
    int, typer.Option(min=0, metavar="N", help="Same seed, same room, noise and flight.")
]
World = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE",
        help="Name of a world, or a TOML file.",
        autocompletion=lambda: [file.stem for file in _WORLDS.glob("*.toml")],
    ),
]
_WORLDS = Path(__file__).parent / "sim" / "worlds"
Uri = Annotated[
    str,
    typer.Option(
        envvar="CFLIB_URI", metavar="URI", help="Which Crazyflie; the simulator's if not given."
    ),
]
Record = Annotated[
    Path | None,
    typer.Option(
        "--record",
        metavar="FILE|off",
        help="Record the session into this MCAP file; else into a new one among the recordings, "
        "of which the newest 2 GB are kept (the environment's WAYFLIE_KEEP_GB).",
    ),
]


def fail(sentence: str, step: str = "", code: int = EXIT_FAILED) -> NoReturn:
    """End with one clear line, and one that says what to do."""
    err.print(f"wayflie: {sentence}", markup=False)
    if step:
        err.print(f"  next: {step}", markup=False)
    sys.exit(code)


def end(error: GroundError) -> NoReturn:
    """End with what went wrong and the next step, on the terminal and where figures are wanted."""
    if error.step:  # without the core nothing else can be looked up
        step = error.step
    else:
        from ground.nextsteps import next_step

        step = next_step(error)
    if _Wanted.report and not isinstance(error, NotReached):  # which has written its own
        figures = {"reached": False, "sentence": str(error), "next_step": step}
        write_report(_Wanted.report, figures, [])
    fail(str(error), step, EXIT_USAGE if isinstance(error, BadInput) else EXIT_FAILED)


def finish(work: Callable[[], bool]) -> None:
    """Do it. Exit 0 if it reached what was asked, else as `EXITS` says."""
    # Being asked to end is as Ctrl-C: land first. So it is for what a script has put into the
    # background, where shells switch Ctrl-C off.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        reached = work()
    except GroundError as error:
        end(error)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
    if not reached:
        sys.exit(EXIT_FAILED)


def run(work: Coroutine[Any, Any, bool]) -> None:
    """As finish(), for what runs in a loop."""
    finish(lambda: asyncio.run(work))
