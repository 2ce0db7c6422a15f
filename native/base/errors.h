// SPDX-License-Identifier: GPL-3.0-or-later
// The exceptions that public functions throw for wrong arguments. Internal functions use assertions.
#pragma once

#include <stdexcept>
#include <string>

namespace rumple {

// An argument that breaks its contract (shape, range, not finite). The message names the argument, the
// expected and the actual value, and the first bad index. Python receives ValueError.
struct InvalidInput : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

// A mesh from which no surface can be built. The message names the first bad element. Python receives
// ValueError.
struct TopologyError : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

}  // namespace rumple
