// SPDX-License-Identifier: GPL-3.0-or-later
void main() { out_depth = gl_FragCoord.z; }
