# SPDX-License-Identifier: GPL-3.0-or-later
# What the toolchains of macOS have in common. Zig compiles; the library is linked by LLVM's linker, because that of Zig
# 0.11 exports what is hidden, and what it exports of its C++ would stand in the place of Blender's.
# scripts/platforms writes Zig's static libraries to RUMPLE_COMPILERS/lib, and what says which symbols macOS 11 has.
set(CMAKE_SYSTEM_NAME Darwin)
include(${CMAKE_CURRENT_LIST_DIR}/zig.cmake)
set(CMAKE_INSTALL_NAME_TOOL true)
set(CMAKE_OSX_SYSROOT "")
set(CMAKE_OSX_DEPLOYMENT_TARGET "")
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
set(CMAKE_USER_MAKE_RULES_OVERRIDE_CXX ${CMAKE_CURRENT_LIST_DIR}/macos_linker.cmake)
