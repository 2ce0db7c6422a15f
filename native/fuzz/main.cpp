// SPDX-License-Identifier: GPL-3.0-or-later
// A fuzzer of the whole C header: an input is a series of calls, in any order and with any arguments that a
// caller can give. The library must answer or refuse with words; it must not crash, hang, read what is not its
// own, give back what is not finite, or take a handle of another model. scripts/fuzz runs it.
#include "world.h"

using namespace rumple::fuzz;

namespace {

constexpr int kMostOperations = 40;

const std::vector<Operation>& group(int number) {
    const std::vector<Operation>* groups[] = {&kSurface, &kMesh, &kField, &kPaths, &kLayers, &kCloth, &kBrush, &kMaps};
    return *groups[number];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Bytes bytes(data, size);
    next_time = 0.0;
    World world;
    kSurface[0](world, bytes);  // without a base there is little to do
    for (int i = 0; i < kMostOperations && !bytes.empty(); ++i) {
        const std::vector<Operation>& operations = group(bytes.below(8));
        operations[size_t(bytes.below(int(operations.size())))](world, bytes);
    }
    return 0;
}
