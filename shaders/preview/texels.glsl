// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays as textures: element i is in texel (i mod width, i / width). Indices are floats, which are exact up to 2^24.
#define TEXEL(array, i) texelFetch(array, ivec2((i) % textureSize(array, 0).x, (i) / textureSize(array, 0).x), 0)
// The element that a pass writes. Its target is as wide as `array`.
#define THIS_TEXEL(array) (int(gl_FragCoord.x) + int(gl_FragCoord.y) * textureSize(array, 0).x)
