# SPDX-License-Identifier: GPL-3.0-or-later
"""Ground station and simulator of Wayflie."""

__version__ = "0.1.0"
