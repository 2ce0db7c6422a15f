// SPDX-License-Identifier: GPL-3.0-or-later
// Bad input: what is refused, and with which words.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <limits>
#include <string>

#include "base/errors.h"

namespace rumple::tests {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The message of the refusal, or "not refused".
inline std::string refusal(const std::function<void()>& call) {
    try {
        call();
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "not refused";
}

inline void expect_refused(const std::function<void()>& call, std::initializer_list<std::string> parts) {
    const std::string message = refusal(call);
    for (const std::string& part : parts) {
        EXPECT_NE(message.find(part), std::string::npos)
            << "'" << message << "' does not say '" << part << "'";
    }
}

}  // namespace rumple::tests
