# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the command `wayflie` as `python -m ground`."""

from ground.cli.app import main

if __name__ == "__main__":
    main()
