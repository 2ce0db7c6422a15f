# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame: its input, the evaluator that finds, solves or replays it, and the cache of solved frames."""
