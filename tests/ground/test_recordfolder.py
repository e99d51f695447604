# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings without a given name are kept up to a limit; the others stay."""

import asyncio
import io
import os
from collections.abc import Iterable
from pathlib import Path

import pytest
from rich.console import Console

from ground.errors import BadInput
from ground.record.folder import LIMIT, new_recording, prune, recordings_folder
from ground.record.recorder import RecordedLink, where_told
from ground.record.writer import RecordFile
from ground.station.station import station_on
from tests.ground.fakelink import FakeLink

MB = 1_000_000


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setenv(LIMIT, "0.1")
    folder = recordings_folder()
    folder.mkdir(parents=True)
    return folder


def lay(folder: Path, day: int, size_mb: int, name: str = "") -> Path:
    """Make a recording of that day."""
    path = folder / (name or f"2026-01-{day:02}_12-00-00.mcap")
    with path.open("wb") as file:
        file.truncate(size_mb * MB)
    os.utime(path, (day, day))
    return path


def there(paths: Iterable[Path]) -> list[bool]:
    return [path.exists() for path in paths]


def test_the_oldest_go_until_the_rest_is_within_the_limit(folder: Path) -> None:
    files = [lay(folder, day, 30) for day in (1, 2, 3, 4, 5)]
    deleted = prune()
    assert there(files) == [False, False, True, True, True]
    assert deleted is not None
    assert (deleted.files, deleted.size_bytes) == (2, 60 * MB)
    assert str(deleted).startswith("deleted the 2 oldest recordings, 60 MB: the newest 0.1 GB")
    assert prune() is None


def test_the_newest_stays_however_large(folder: Path) -> None:
    old, new = lay(folder, 1, 1), lay(folder, 2, 500)
    prune()
    assert there((old, new)) == [False, True]


def test_what_somebody_named_stays_and_does_not_count(folder: Path) -> None:
    named = lay(folder, 1, 900, "first-flight.mcap")
    files = [lay(folder, day, 40) for day in (2, 3)]
    assert prune() is None
    assert there([named, *files]) == [True] * 3


def test_one_that_is_being_written_stays(folder: Path) -> None:
    running = RecordFile(folder / "2026-01-01_12-00-00.mcap", {})
    path = folder / "2026-01-01_12-00-00.mcap"
    os.utime(path, (1, 1))
    new = [lay(folder, day, 120) for day in (2, 3)]
    prune()
    assert there([path, *new]) == [True, False, True]
    running.close()
    os.utime(path, (1, 1))
    prune()
    assert there([path, *new]) == [False, False, True]


@pytest.mark.parametrize(("limit", "left"), [("inf", 3), ("", 3), ("0", 1)])
def test_the_limit_is_set_by_the_environment(
    folder: Path, monkeypatch: pytest.MonkeyPatch, limit: str, left: int
) -> None:
    monkeypatch.setenv(LIMIT, limit)
    files = [lay(folder, day, 300) for day in (1, 2, 3)]
    prune()
    assert sum(there(files)) == left


@pytest.mark.parametrize("limit", ["much", "-1", "nan"])
def test_a_limit_that_is_none_is_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    monkeypatch.setenv(LIMIT, limit)
    with pytest.raises(BadInput, match=LIMIT):
        prune()


def test_a_session_says_what_was_deleted_for_it(folder: Path) -> None:
    files = [lay(folder, day, 90) for day in (1, 2)]

    async def session(where: Path | None) -> str:
        link = RecordedLink(FakeLink(), where)
        console = Console(width=200, record=True, file=io.StringIO())
        async with station_on(link), where_told(link, console):
            pass
        return console.export_text()

    told = asyncio.run(session(folder / "mine.mcap"))
    assert "deleted" not in told
    assert there(files) == [True, True]
    told = asyncio.run(session(None))
    assert told.splitlines()[0].startswith("deleted the oldest recording, 90 MB")
    assert there(files) == [False, True]
    assert new_recording().parent == folder
    assert len([path for path in folder.glob("20*.mcap") if path not in files]) == 1
