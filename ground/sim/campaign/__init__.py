# SPDX-License-Identifier: GPL-3.0-or-later
"""Many seeded flights through worlds drawn at random, judged by the truth."""
