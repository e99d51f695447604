# SPDX-License-Identifier: GPL-3.0-or-later
"""The default URI: that of the drone that `wayflie sim` simulates."""

SIMULATOR_PORT = 19850
SIMULATOR_URI = f"udp://127.0.0.1:{SIMULATOR_PORT}"
