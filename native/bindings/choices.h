// SPDX-License-Identifier: GPL-3.0-or-later
// Choices by name, as Python and the artist's settings spell them.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>

#include "base/errors.h"
#include "surface/attachments.h"
#include "surface/shown_mesh.h"

namespace rumple::bindings {

template <typename Value>
Value chosen(const std::string& name, const char* argument,
             std::initializer_list<std::pair<const char*, Value>> from) {
    std::string known;
    for (const auto& [key, value] : from) {
        if (name == key) return value;
        known += std::string(known.empty() ? "" : ", ") + key;
    }
    throw InvalidInput(std::string(argument) + ": expected one of " + known + ", got " + name);
}

FineSource fine_source(const std::string& source, Index level, Index segments, float longest_edge,
                       Index most_vertices);

AttachmentKind attachment_kind(const std::string& name);

}  // namespace rumple::bindings
