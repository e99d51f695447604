# SPDX-License-Identifier: GPL-3.0-or-later
"""`make prove` reports an alarm of Frama-C/Eva that nobody has explained; CI runs it on all."""

import pytest

from tests.tools import prove
from tests.tools.needed import need


def test_an_alarm_that_is_not_explained_is_a_complaint(monkeypatch: pytest.MonkeyPatch) -> None:
    need("frama-c", "frama-c-base", "that a proof can fail")
    monkeypatch.setattr(prove, "explained", lambda target: set())
    assert "not explained: ray.c" in prove.complaints("ray")
