# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m ground.sim` is `wayflie sim`."""

import typer

from ground.sim.command import sim

if __name__ == "__main__":
    typer.run(sim)
