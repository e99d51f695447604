# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m ground` is the command `wayflie`."""

from ground.cli import main

if __name__ == "__main__":
    main()
