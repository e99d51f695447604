# SPDX-License-Identifier: GPL-3.0-or-later
"""Flies the missions of a campaign on any executor, and keeps each row as soon as it is there."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from typing import Any, Final

from ground.errors import GroundError
from ground.sim.campaign.flights import Mission, row_of
from ground.sim.campaign.rows import BadRows, Row, RowFile

_CONNECT_S: Final = 10
_AHEAD: Final = 64
"""Missions submitted at a time: enough that one waits for every worker."""


def processes(workers: int) -> Executor:
    """Processes on this machine, which ignore Ctrl-C: the parent process handles it."""
    spawn = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, spawn, initializer=_leave_interrupts)


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """A dask.distributed cluster, whose workers have Wayflie installed."""
    try:
        from distributed import Client
    except ImportError as error:
        raise GroundError(
            f"--dask needs dask.distributed ({error})", "pip install 'wayflie[bench]'"
        ) from error
    connect: Any = Client
    try:
        client = connect(address, timeout=_CONNECT_S)
    except OSError as error:
        raise GroundError(f"no scheduler answers at {address}") from error
    with client, client.get_executor(pure=False) as executor:
        yield executor


def left_to_fly(missions: Sequence[Mission], done: Sequence[Row]) -> list[Mission]:
    """The missions without a row; a row that belongs to none of them is an error."""
    numbers = {(m.kind, m.seed, m.number, m.conditions): m for m in missions}
    for row in done:
        if numbers.pop((row.kind, row.seed, row.number, row.conditions), None) is None:
            raise BadRows(
                f"mission {row.number} of kind {row.kind}, seed {row.seed}, {row.conditions}, is "
                "there already and belongs to another campaign, or is there twice"
            )
    return list(numbers.values())


def fly_all(
    missions: Iterable[Mission],
    executor: Executor,
    file: RowFile | None,
    tell: Callable[[Row], None],
) -> list[Row]:
    """Fly missions in any order; each row is written and reported as soon as it is there.

    An interruption cancels missions that wait; those in flight end, but their rows are lost.
    """
    rows: list[Row] = []
    waiting = iter(missions)
    flying: set[Future[Row]] = set()
    try:
        while True:
            flying |= {executor.submit(row_of, m) for m in islice(waiting, _AHEAD - len(flying))}
            if not flying:
                return rows
            ended, flying = wait(flying, return_when=FIRST_COMPLETED)
            for future in ended:
                row = future.result()
                if file is not None:
                    file.append(row)
                rows.append(row)
                tell(row)
    except BaseException:
        for future in flying:
            future.cancel()
        raise


def _leave_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
