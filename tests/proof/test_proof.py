# SPDX-License-Identifier: GPL-3.0-or-later
"""Frama-C/Eva raises no alarm that is not explained; and it would."""

import pytest

from tests.tools import prove
from tests.tools.needed import need


@pytest.mark.parametrize("target", prove.SOURCES)
def test_every_alarm_is_explained(target: str) -> None:
    need("frama-c", "frama-c-base", f"the proof of {target}")
    assert prove.complaints(target) == ""


def test_an_alarm_that_is_not_explained_is_a_complaint(monkeypatch: pytest.MonkeyPatch) -> None:
    need("frama-c", "frama-c-base", "that a proof can fail")
    monkeypatch.setattr(prove, "explained", lambda target: set())
    assert "not explained: ray.c" in prove.complaints("ray")
