# SPDX-License-Identifier: GPL-3.0-or-later
"""The page: a Starlette server on 127.0.0.1 and three static files."""
