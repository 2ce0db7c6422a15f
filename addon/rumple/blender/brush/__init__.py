# SPDX-License-Identifier: GPL-3.0-or-later
"""The brush for rest-pose wrinkles."""
