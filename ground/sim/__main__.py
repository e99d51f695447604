# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `wayflie sim` as `python -m ground.sim`."""

from ground.cli.sim import simulator

if __name__ == "__main__":
    simulator(prog_name="wayflie sim")
