# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first click finds of an object, and what it sets and paints for that. It can be changed afterwards."""
