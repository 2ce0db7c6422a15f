// SPDX-License-Identifier: GPL-3.0-or-later
// Conversion of settings between C and C++. A function pair_fields(c, native, pair) lists every field once.
// The given `pair` determines the direction of the copy.
#pragma once

#include "api/call.h"

namespace rumple::api {

struct ToNative {
    template <typename T, typename U>
    void operator()(const T& c, U& native) const {
        native = c;
    }
    void operator()(const float (&c)[3], Vec3& native) const { native = {c[0], c[1], c[2]}; }
    template <typename Choice>
    void choose(const char* name, const int32_t& c, Choice& native, Choice last) const {
        native = choice(c, last, name);
    }
};

struct ToC {
    template <typename T, typename U>
    void operator()(T& c, const U& native) const {
        c = native;
    }
    void operator()(float (&c)[3], const Vec3& native) const {
        for (int k = 0; k < 3; ++k) c[k] = native[k];
    }
    template <typename Choice>
    void choose(const char*, int32_t& c, const Choice& native, Choice) const {
        c = static_cast<int32_t>(native);
    }
};

// From C. name: of the argument.
template <typename Native, typename C>
Native native_of(const C* settings, const char* name) {
    C c = given(settings, name);
    Native native;
    pair_fields(c, native, ToNative{});
    return native;
}

// The defaults, which are defined in C++.
template <typename C, typename Native>
C default_of(Native native = {}) {
    C c{};
    pair_fields(c, native, ToC{});
    return c;
}

}  // namespace rumple::api
