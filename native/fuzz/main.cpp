// SPDX-License-Identifier: GPL-3.0-or-later
// A fuzzer of the whole C header. An input is a series of calls, in any order and with any arguments that a
// caller can give. The library must answer or refuse with a message. It must not crash, hang, read memory
// that it does not own, return values that are not finite, or accept a handle of another model. scripts/fuzz
// runs it.
#include "world.h"

using namespace rumple::fuzz;

namespace {

constexpr int kMostOperations = 24;

const std::vector<Operation>* const kGroups[] = {&kMesh,  &kField, &kPaths, &kLayers,
                                                 &kCloth, &kBrush, &kMaps,  &kSurface};

void run_one(const std::vector<Operation>& operations, World& world, Bytes& bytes) {
    operations[size_t(bytes.below(int(operations.size())))](world, bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Bytes bytes(data, size);
    next_time = 0.0;
    World world;
    // Most calls need a base and a model.
    for (int i = 0; i < 3 && world.surfaces.empty(); ++i) kSurface[0](world, bytes);
    const int main_group = bytes.below(std::size(kGroups));
    if (kGroups[main_group] == &kBrush) kField[0](world, bytes);
    (*kGroups[main_group])[0](world, bytes);
    for (int i = 0; i < kMostOperations && !bytes.empty(); ++i) {
        const int other = bytes.byte();
        run_one(*kGroups[other < 192 ? main_group : other % int(std::size(kGroups))], world, bytes);
    }
    return 0;
}
