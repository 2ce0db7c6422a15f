// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays as images, which a compute shader reads and writes; see texels.glsl.
#define READ(image, i) imageLoad(image, ivec2((i) % imageSize(image).x, (i) / imageSize(image).x))
#define WRITE(image, i, value) imageStore(image, ivec2((i) % imageSize(image).x, (i) / imageSize(image).x), value)
