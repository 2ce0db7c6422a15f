// SPDX-License-Identifier: GPL-3.0-or-later
// A vector whose new elements have no values yet. For large data that a team writes as a whole before it is
// read: to clear it first would take one thread about as long as writing it takes all.
#pragma once

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace rumple {

template <typename T>
struct UnsetAllocator : std::allocator<T> {
    static_assert(std::is_trivially_copyable_v<T>);
    template <typename U>
    struct rebind {
        using other = UnsetAllocator<U>;
    };

    UnsetAllocator() = default;
    template <typename U>
    UnsetAllocator(const UnsetAllocator<U>&) {}

    void construct(T*) {}
    template <typename... From>
    void construct(T* place, From&&... from) {
        std::construct_at(place, std::forward<From>(from)...);
    }
};

template <typename T>
using UnsetVector = std::vector<T, UnsetAllocator<T>>;

}  // namespace rumple
