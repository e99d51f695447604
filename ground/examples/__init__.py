# SPDX-License-Identifier: GPL-3.0-or-later
"""Scripts to begin with: `wayflie sim` in one terminal, `python -m ground.examples.explore` in
another. CFLIB_URI names a real drone."""
