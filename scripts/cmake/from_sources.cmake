# SPDX-License-Identifier: GPL-3.0-or-later
# What Debian has only for its own systems, built for the others as static libraries from Debian's sources:
# of OpenSubdiv what refines (Far, Vtr, Sdc), of OpenMesh what knows how a mesh is joined. Headers that
# hold all of a library (GLM, maxflow) are Debian's, alone in a folder: the other headers of RUMPLE_HEADERS are not for
# other systems. RUMPLE_SOURCES is the folder that scripts/platforms or scripts/test_on_mac fills.
file(GLOB osd_folder ${RUMPLE_SOURCES}/opensubdiv-*)
file(GLOB openmesh_folder ${RUMPLE_SOURCES}/openmesh-*)
if(NOT IS_DIRECTORY "${osd_folder}" OR NOT IS_DIRECTORY "${openmesh_folder}")
    message(FATAL_ERROR "There are no sources in ${RUMPLE_SOURCES}: see scripts/platforms")
endif()

set(headers ${CMAKE_BINARY_DIR}/headers)
foreach(folder glm maxflow-3.0)
    file(MAKE_DIRECTORY ${headers})
    file(CREATE_LINK ${RUMPLE_HEADERS}/${folder} ${headers}/${folder} SYMBOLIC)
endforeach()
set(GLM_INCLUDE_DIR ${headers})
set(MAXFLOW_INCLUDE_DIR ${headers}/maxflow-3.0)

add_library(rumple_dependency_flags INTERFACE)
target_compile_options(rumple_dependency_flags INTERFACE -w -ffp-contract=off)
target_compile_definitions(rumple_dependency_flags INTERFACE _USE_MATH_DEFINES)     # M_PI

file(GLOB osd_sources ${osd_folder}/opensubdiv/far/*.cpp ${osd_folder}/opensubdiv/vtr/*.cpp
    ${osd_folder}/opensubdiv/sdc/*.cpp)
add_library(osdCPU STATIC ${osd_sources} ${osd_folder}/opensubdiv/version.cpp)
target_include_directories(osdCPU SYSTEM PUBLIC ${osd_folder})
target_link_libraries(osdCPU PRIVATE rumple_dependency_flags)
# It has vectors of types that are not yet complete: in C++20 libc++ looks inside of them.
set_target_properties(osdCPU PROPERTIES CXX_STANDARD 17)
target_compile_definitions(osdCPU INTERFACE _USE_MATH_DEFINES)

set(openmesh_sources ${openmesh_folder}/src)
add_library(OpenMeshCore STATIC
    ${openmesh_sources}/OpenMesh/Core/Mesh/ArrayKernel.cc
    ${openmesh_sources}/OpenMesh/Core/Mesh/BaseKernel.cc
    ${openmesh_sources}/OpenMesh/Core/Mesh/PolyConnectivity.cc
    ${openmesh_sources}/OpenMesh/Core/System/omstream.cc
    ${openmesh_sources}/OpenMesh/Core/Utils/BaseProperty.cc)
target_include_directories(OpenMeshCore SYSTEM PUBLIC ${openmesh_sources})
target_compile_definitions(OpenMeshCore PUBLIC OM_STATIC_BUILD)
target_link_libraries(OpenMeshCore PRIVATE rumple_dependency_flags)
set(OPENSUBDIV_CPU osdCPU)
set(OPENMESH_CORE OpenMeshCore)
