# SPDX-License-Identifier: GPL-3.0-or-later
"""Example scripts: run `wayflie sim` in one terminal, `python -m ground.examples.explore` in
another. For a real drone, set CFLIB_URI."""
