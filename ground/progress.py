# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress shown in a terminal while something takes long; nothing if output is piped."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

EVERY_S = 0.25


@contextlib.contextmanager
def waiting(console: Console, words: str) -> Iterator[None]:
    """Show a spinner for work of unknown length."""
    with console.status(words) if console.is_terminal else contextlib.nullcontext():
        yield


def bar(console: Console) -> Progress:
    """Make a progress bar for work of known length."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


@contextlib.asynccontextmanager
async def share_shown(
    console: Console, words: str, share: Callable[[], float]
) -> AsyncIterator[None]:
    """Show a bar that follows a share from 0 to 1."""
    with bar(console) as progress:
        task = progress.add_task(words, total=1.0)
        async with _again(lambda: progress.update(task, completed=share())):
            yield


@contextlib.asynccontextmanager
async def line_shown(console: Console, words: Callable[[], str]) -> AsyncIterator[None]:
    """Show one line below all others with the present status."""
    if not console.is_terminal:
        yield
        return
    with console.status(words()) as status:
        async with _again(lambda: status.update(words())):
            yield


@contextlib.asynccontextmanager
async def _again(show: Callable[[], None]) -> AsyncIterator[None]:
    async def work() -> None:
        while True:
            show()
            await asyncio.sleep(EVERY_S)

    task = asyncio.create_task(work())
    try:
        yield
    finally:
        task.cancel()
