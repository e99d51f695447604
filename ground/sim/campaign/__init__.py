# SPDX-License-Identifier: GPL-3.0-or-later
"""Many seeded flights through randomly drawn worlds, judged by the truth."""
