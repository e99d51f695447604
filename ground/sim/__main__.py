# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m ground.sim` is `wayflie sim`."""

from ground.sim.command import simulator

if __name__ == "__main__":
    simulator(prog_name="wayflie sim")
