# SPDX-License-Identifier: GPL-3.0-or-later
"""The station: what is known of one drone, commands to it, and flights supervised to their end."""
