# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth under every system, what moves it and what holds it."""
