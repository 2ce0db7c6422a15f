# SPDX-License-Identifier: GPL-3.0-or-later
# What the toolchains of Zig have in common. scripts/platforms writes compilers of these names, for one target each, to
# RUMPLE_COMPILERS; its libc++ is linked in.
if(NOT RUMPLE_COMPILERS)
    message(FATAL_ERROR "RUMPLE_COMPILERS is not set: see scripts/platforms")
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES RUMPLE_COMPILERS)
set(CMAKE_C_COMPILER ${RUMPLE_COMPILERS}/clang)
set(CMAKE_CXX_COMPILER ${RUMPLE_COMPILERS}/clang++)
set(CMAKE_AR ${RUMPLE_COMPILERS}/ar)
set(CMAKE_RANLIB ${RUMPLE_COMPILERS}/ranlib)
set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)     # Zig makes none
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH ${RUMPLE_COMPILERS})
