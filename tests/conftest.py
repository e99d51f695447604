# SPDX-License-Identifier: GPL-3.0-or-later
"""Property tests draw the same examples in every run; `--hypothesis-profile explore` draws more.

Flights of tests are recorded where nobody keeps any.
"""

import os
import tempfile

from hypothesis import HealthCheck, settings

QUIET = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile(
    "repeatable", derandomize=True, deadline=None, max_examples=60, suppress_health_check=QUIET
)
settings.register_profile("explore", deadline=None, max_examples=2000, suppress_health_check=QUIET)
settings.load_profile("repeatable")

FOLDER = tempfile.TemporaryDirectory(prefix="wayflie-tests-")
os.environ["XDG_DATA_HOME"] = FOLDER.name
