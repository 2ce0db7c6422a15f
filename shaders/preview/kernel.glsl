// SPDX-License-Identifier: GPL-3.0-or-later
// Compute shaders over arrays: work(i) of the stage before this text runs once for every element.
void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i < count) work(first + i);
}
