# SPDX-License-Identifier: GPL-3.0-or-later
# Read by CMake after its own rules. Signed ad hoc: Apple's processors run nothing that has no signature.
set(CMAKE_CXX_CREATE_SHARED_LIBRARY
    "clang++ -target ${CMAKE_SYSTEM_PROCESSOR}-apple-macos11.0 -fuse-ld=lld -nostdlib -dynamiclib <LINK_FLAGS> -o <TARGET> \
-Wl,-syslibroot,${RUMPLE_COMPILERS} -Wl,-dead_strip -Wl,-S -Wl,-adhoc_codesign -install_name @rpath/<TARGET_SONAME> \
<OBJECTS> <LINK_LIBRARIES> ${RUMPLE_COMPILERS}/lib/libc++.a ${RUMPLE_COMPILERS}/lib/libc++abi.a -lSystem")
