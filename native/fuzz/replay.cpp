// SPDX-License-Identifier: GPL-3.0-or-later
// rumple_kept FOLDER [STEP]: runs all inputs of a folder, or every STEP-th, on systems without a fuzzer. It
// links with the packaged library, because the fuzzer uses only the C header.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const size_t step = count > 2 ? size_t(std::max(std::atoi(arguments[2]), 1)) : 1;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(arguments[1])) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    size_t run = 0;
    for (size_t i = 0; i < files.size(); i += step, ++run) {
        std::ifstream file(files[i], std::ios::binary);
        const std::vector<char> input{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    }
    std::printf("%zu kept inputs\n", run);
    return run > 0 ? 0 : 1;
}
