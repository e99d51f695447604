# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulators on UDP: where they are looked for, and the default URI, that of `wayflie sim`."""

SIMULATOR_PORT = 19850
SIMULATOR_URI = f"udp://127.0.0.1:{SIMULATOR_PORT}"
SCANNED_PORTS = range(SIMULATOR_PORT, SIMULATOR_PORT + 10)
"""As cflib scans them."""
SCAN_PROBE = b"\xff"
"""A datagram that a Crazyflie sends back."""
