# SPDX-License-Identifier: GPL-3.0-or-later
"""The relocalisation bench: homes are drawn, and drones put down in them find their place."""

from tests.bench.reloc.families import kidnapped


def test_a_drone_that_is_sure_is_in_its_place() -> None:
    outcomes = kidnapped("homes", 5, 4)
    assert len(outcomes) == 4
    assert any(outcome.sure for outcome in outcomes)
    assert all(outcome.right for outcome in outcomes if outcome.sure)
