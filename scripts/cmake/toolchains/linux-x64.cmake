# SPDX-License-Identifier: GPL-3.0-or-later
# Linux on x86-64 back to glibc 2.28, by Zig.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
set(CMAKE_SHARED_LINKER_FLAGS_INIT -s)
