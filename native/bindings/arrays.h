// SPDX-License-Identifier: GPL-3.0-or-later
// The one door for arrays: float32 or int32, C-contiguous, checked, never
// silently copied on the way in; owned by NumPy on the way out.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "base/array.h"
#include "base/errors.h"

namespace rumple::bindings {

namespace py = pybind11;

// What came, in words, for an error message.
inline std::string describe(const py::array& array) {
    std::string shape = "(";
    for (py::ssize_t d = 0; d < array.ndim(); ++d) shape += (d ? ", " : "") + std::to_string(array.shape(d));
    return std::string(py::str(array.dtype())) + " " + shape + ")";
}

// A view of an array of shape (n,) for columns == 0, else (n, columns). Throws
// InvalidInput that names the argument, what was expected and what came.
template <typename Scalar>
std::span<const Scalar> scalars(const py::array& array, const char* name, py::ssize_t columns) {
    const bool shape_fits = columns == 0 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns;
    const bool type_fits = py::isinstance<py::array_t<Scalar>>(array);
    if (!shape_fits || !type_fits || !(array.flags() & py::array::c_style)) {
        const std::string wanted = columns == 0 ? "(n,)" : "(n, " + std::to_string(columns) + ")";
        throw InvalidInput(std::string(name) + ": expected a C-contiguous " +
                           std::string(py::str(py::dtype::of<Scalar>())) + " array of shape " + wanted +
                           ", got " + describe(array));
    }
    return {static_cast<const Scalar*>(array.data()), static_cast<size_t>(array.size())};
}

static_assert(sizeof(Vec2) == 2 * sizeof(float) && sizeof(Vec3) == 3 * sizeof(float));
static_assert(sizeof(Index) == 4);

inline std::span<const Vec3> vectors(const py::array& array, const char* name) {
    const std::span<const float> flat = scalars<float>(array, name, 3);
    return {reinterpret_cast<const Vec3*>(flat.data()), flat.size() / 3};
}

inline std::span<const Vec2> vectors2(const py::array& array, const char* name) {
    const std::span<const float> flat = scalars<float>(array, name, 2);
    return {reinterpret_cast<const Vec2*>(flat.data()), flat.size() / 2};
}

// A new (count, columns) array (or (count,) for columns == 0) with a copy of plain values.
template <typename Scalar, typename T>
py::array_t<Scalar> to_numpy(const std::vector<T>& values, py::ssize_t columns) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size() * sizeof(T) / sizeof(Scalar))};
    if (columns > 0) shape = {shape[0] / columns, columns};
    py::array_t<Scalar> out(shape);
    if (!values.empty()) std::memcpy(out.mutable_data(), values.data(), values.size() * sizeof(T));
    return out;
}

inline py::array_t<float> to_numpy(const std::vector<Vec3>& values) {
    return to_numpy<float>(values, 3);
}

}  // namespace rumple::bindings
