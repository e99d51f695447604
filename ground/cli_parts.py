# SPDX-License-Identifier: GPL-3.0-or-later
"""What the files of the command line share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NoReturn

import typer
from rich.console import Console

EXIT_INTERRUPTED = 130
SIMULATOR_URI = "udp://127.0.0.1:19850"

out = Console(highlight=False)
err = Console(stderr=True, highlight=False, soft_wrap=True)

JsonFile = Annotated[
    Path | None, typer.Option("--json", help="Write figures and checks to this file.")
]

Port = Annotated[
    int | None, typer.Option(min=0, max=65535, help="Of the page; the usual or a free one.")
]
Uri = Annotated[
    str,
    typer.Option(envvar="CFLIB_URI", help="Which Crazyflie; the simulator's if not given."),
]
Record = Annotated[
    Path | None,
    typer.Option(
        "--record",
        metavar="FILE|off",
        help="Record the session into this MCAP file; else into a new one among the recordings.",
    ),
]


def fail(sentence: str) -> NoReturn:
    """End with one clear line."""
    err.print(f"wayflie: {sentence}", markup=False)
    raise typer.Exit(1)
