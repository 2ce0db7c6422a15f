// SPDX-License-Identifier: GPL-3.0-or-later
// Helpers for every function of the C library: catch exceptions, check arguments.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/array.h"
#include "base/errors.h"
#include "rumple.h"

namespace rumple::api {

// Turns the current exception into a status, and sets this thread's error message. It allocates nothing.
rumple_status keep_exception() noexcept;

// Runs the work of a call. No exception leaves it.
template <typename Work>
rumple_status guarded(Work&& work) noexcept {
    try {
        work();
        return RUMPLE_OK;
    } catch (...) {
        return keep_exception();
    }
}

// A pointer argument that must not be NULL.
template <typename T>
T& given(T* pointer, const char* name) {
    if (!pointer) throw InvalidInput(std::string(name) + ": expected a pointer, got NULL");
    return *pointer;
}

// A call that makes a handle. make: returns the new object.
template <typename Handle, typename Make>
rumple_status made(Handle** out, const char* name, Make&& make) noexcept {
    return guarded([&] {
        Handle*& place = given(out, name);
        place = make();
    });
}

// `count` rows of the caller's array.
template <typename Row, typename Scalar>
std::span<const Row> rows(const Scalar* data, size_t count, const char* name) {
    static_assert(std::is_trivially_copyable_v<Row> && sizeof(Row) % sizeof(Scalar) == 0);
    if (count > size_t(std::numeric_limits<Index>::max())) {
        throw InvalidInput(std::string(name) + ": expected at most " +
                           std::to_string(std::numeric_limits<Index>::max()) + " rows, got " +
                           std::to_string(count));
    }
    if (!data && count > 0)
        throw InvalidInput(std::string(name) + ": expected " + std::to_string(count) + " rows, got NULL");
    return {reinterpret_cast<const Row*>(data), count};
}
template <typename Scalar>
std::span<const Scalar> values(const Scalar* data, size_t count, const char* name) {
    return rows<Scalar>(data, count, name);
}
inline std::span<const Vec3> vectors(const float* data, size_t count, const char* name) {
    return rows<Vec3>(data, count, name);
}

template <typename T>
std::vector<T> copied(std::span<const T> from) {
    return {from.begin(), from.end()};
}

void expect_rows(const char* name, size_t count, size_t expected);
// ... or none.
void expect_rows_or_none(const char* name, size_t count, size_t expected);
// Checks places on a mesh with this number of triangles. Weights of corners 1 and 2 may be a little outside
// of the triangle. Far outside, interpolated values would not be finite.
void expect_places(std::span<const Index> triangles, std::span<const Vec2> barycentric, size_t count);

// An output array of the caller, with exactly `expected` rows.
template <typename Row, typename Scalar>
std::span<Row> output(Scalar* data, size_t count, size_t expected, const char* name) {
    expect_rows(name, count, expected);
    rows<Row>(static_cast<const Scalar*>(data), count, name);
    return {reinterpret_cast<Row*>(data), count};
}

template <typename T>
void write(const std::vector<T>& from, std::span<T> to) {
    std::copy(from.begin(), from.end(), to.begin());
}

// The plain numbers of an array inside a handle, for a view.
template <typename Scalar, typename Row>
const Scalar* flat(const std::vector<Row>& of) {
    static_assert(std::is_trivially_copyable_v<Row> && sizeof(Row) % sizeof(Scalar) == 0);
    return reinterpret_cast<const Scalar*>(of.data());
}

template <typename T>
int32_t count(const std::vector<T>& of) {
    return static_cast<int32_t>(of.size());
}

// A choice that was given as a number. last: the last valid one.
template <typename Choice>
Choice choice(int32_t number, Choice last, const char* name) {
    if (number < 0 || number > static_cast<int32_t>(last)) {
        throw InvalidInput(std::string(name) + ": expected 0 to " +
                           std::to_string(static_cast<int32_t>(last)) + ", got " + std::to_string(number));
    }
    return static_cast<Choice>(number);
}

// An object that was made for a model, or none. A handle of another model is refused, even if both models are
// equal.
template <typename Handle, typename Model>
const Handle* of_model(const Handle* handle, const Model& model, const char* name) {
    if (handle && handle->model.get() != model.model.get())
        throw InvalidInput(std::string(name) + ": it was made for another model");
    return handle;
}
template <typename Handle, typename Model>
const Handle& given_of_model(const Handle* handle, const Model& model, const char* name) {
    return *of_model(&given(handle, name), model, name);
}

}  // namespace rumple::api
