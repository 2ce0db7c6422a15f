# SPDX-License-Identifier: GPL-3.0-or-later
"""Files: baked clips and their locks, solved frames and checkpoints, exports for other programs."""
