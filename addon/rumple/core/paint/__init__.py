# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist paints or draws on a garment: maps, smooth places, rigid patches, fold guides."""
