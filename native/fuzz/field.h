// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the calls of the Wrinkle Field, of its steps and of its brush.
#pragma once

#include "world.h"

namespace rumple::fuzz {

rumple_wrinkle_field_settings field_settings(Bytes& bytes);
rumple_wrinkle_field_profile field_profile(Bytes& bytes);

}  // namespace rumple::fuzz
