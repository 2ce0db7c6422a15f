// SPDX-License-Identifier: GPL-3.0-or-later
// What public functions throw where their arguments are wrong. What is inside asserts.
#pragma once

#include <stdexcept>
#include <string>

namespace rumple {

// An argument that breaks its promise (shape, range, not finite). The message
// names the argument, what was expected, what came, and the first bad index.
// Python sees ValueError.
struct InvalidInput : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

// A mesh that no surface can be built from. The message names the first bad
// element. Python sees ValueError.
struct TopologyError : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

}  // namespace rumple
