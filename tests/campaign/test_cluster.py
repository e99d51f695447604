# SPDX-License-Identifier: GPL-3.0-or-later
"""The same missions on a cluster: two workers of dask.distributed on this machine."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from distributed import LocalCluster
from typer.testing import CliRunner

from ground.cli.app import app
from ground.errors import GroundError
from ground.sim.campaign.flights import Mission, row_of
from ground.sim.campaign.rows import Row
from ground.sim.campaign.runner import cluster, fly_all

MISSIONS = [Mission("goto", 8, number) for number in range(3)]


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    anywhere = "127.0.0.1:0"
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=anywhere) as workers:
        yield workers.scheduler_address


def without_wall(rows: list[Row]) -> list[Row]:
    return sorted((replace(row, wall_s=0.0) for row in rows), key=lambda row: row.number)


def test_a_cluster_flies_as_this_process_does(address: str) -> None:
    with cluster(address) as executor:
        rows = fly_all(MISSIONS, executor, None, lambda row: None)
    assert without_wall(rows) == without_wall([row_of(mission) for mission in MISSIONS])


def test_the_command_takes_its_address(address: str) -> None:
    arguments = ["campaign", "--seed", "8", "--missions", "1", "--dask", address]
    assert "missions" in CliRunner().invoke(app, arguments).output


def test_without_a_scheduler_it_says_so() -> None:
    with pytest.raises(GroundError, match="no scheduler"), cluster("tcp://127.0.0.1:9"):
        pass
