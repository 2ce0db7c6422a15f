// SPDX-License-Identifier: GPL-3.0-or-later
// One triangle over all of the target: a pass runs once for every texel of it.
void main() { gl_Position = vec4(corner, 0.0, 1.0); }
