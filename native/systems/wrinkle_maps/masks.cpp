// SPDX-License-Identifier: GPL-3.0-or-later
// Sections 5.2 and 5.3: where each map is visible, and how the maps are blended.
#include <algorithm>
#include <array>

#include "base/errors.h"
#include "base/expect.h"
#include "base/lanes.h"
#include "systems/wrinkle_maps/wrinkle_maps.h"

namespace rumple::wrinkle_maps {
namespace {

// Sums of weight * influence over a vertex's bones. Poses are processed in groups of four, so that the
// compiler can vectorise the loop.
template <Index kFours>
void sum_influences(const Model& model, const std::vector<float>& influence, Index v, float* sums) {
    constexpr Index kWidth = kFours * kLanes;
    std::array<float, kWidth> sum{};
    for (Index e = model.weights.start[v]; e < model.weights.start[v + 1]; ++e) {
        const float weight = model.weights.weight[e];
        const float* row = &influence[size_t(model.weights.index[e]) * kWidth];
        for (Index k = 0; k < kWidth; ++k) sum[k] += weight * row[k];
    }
    std::copy(sum.begin(), sum.end(), sums);
}

// factor(v, k): a factor on the sum.
template <Index kFours, typename Factor>
void fill_masks(const Model& model, const std::vector<float>& influence, const Factor& factor,
                std::vector<float>& out) {
    const Index vertices = model.vertices();
    std::array<float, kFours * kLanes> sum;
    for (Index v = 0; v < vertices; ++v) {
        sum_influences<kFours>(model, influence, v, sum.data());
        for (Index k = 0; k < model.poses(); ++k) {
            out[size_t(k) * vertices + v] = std::min(factor(v, k) * sum[k], 1.0f);
        }
    }
}

template <typename Factor>
void fill_masks(const Model& model, const std::vector<float>& influence, const Factor& factor,
                std::vector<float>& out) {
    static_assert(kMostPoses == 4 * kLanes);
    switch ((model.poses() + kLanes - 1) / kLanes) {
        case 1:
            return fill_masks<1>(model, influence, factor, out);
        case 2:
            return fill_masks<2>(model, influence, factor, out);
        case 3:
            return fill_masks<3>(model, influence, factor, out);
        case 4:
            return fill_masks<4>(model, influence, factor, out);
    }
}

// b x o influences times strengths, with rows padded to a multiple of four.
std::vector<float> padded(const Model& model, const Settings& settings, const Influences& influences) {
    const Index poses = model.poses(), width = (poses + kLanes - 1) / kLanes * kLanes;
    std::vector<float> rows(size_t(model.bones()) * width, 0.0f);
    for (Index i = 0; i < model.bones(); ++i) {
        for (Index k = 0; k < poses; ++k) {
            const float strength = settings.strength.empty() ? 1.0f : settings.strength[k];
            rows[size_t(i) * width + k] = strength * influences.pose[size_t(i) * poses + k];
        }
    }
    return rows;
}

}  // namespace

void check(const Settings& settings, Index poses) {
    expect_within("gain", settings.gain, 0.1f, 100.0f);
    if (settings.strength.empty()) return;
    expect_count("strength", settings.strength.size(), size_t(poses), "values");
    for (size_t k = 0; k < settings.strength.size(); ++k) {
        expect_within("strength " + std::to_string(k), settings.strength[k], 0.0, 1.0);
    }
}

std::vector<float> presence(const Model& model, const Influences& influences) {
    const Index poses = model.poses();
    std::vector<float> out(poses, 0.0f);
    for (Index k = 0; k < poses; ++k) {
        double sum = 0.0;
        int active = 0;
        for (Index i = 0; i < model.bones(); ++i) {
            sum += influences.pose[i * poses + k];
            active += model.active[i * poses + k];
        }
        out[k] = static_cast<float>(sum / active);  // active > 0: see build()
    }
    return out;
}

std::vector<float> masks(const Model& model, const Settings& settings, const Influences& influences) {
    check(settings, model.poses());
    expect_count("influences", influences.pose.size(), model.moves.size(), "values");
    std::vector<float> out(size_t(model.poses()) * model.vertices());
    const std::vector<float> rows = padded(model, settings, influences);
    if (settings.gain == 1.0f && !model.overlaps) {
        fill_masks(
            model, rows, [](Index, Index) { return 1.0f; }, out);
        return out;
    }
    // The mean influence of the active bones around the vertex, times gained() of their total weight.
    fill_masks(
        model, rows,
        [&](Index v, Index k) {
            const float reach = model.reach[size_t(v) * model.poses() + k];
            return reach > 0.0f ? gained(std::min(reach, 1.0f), settings.gain) / reach : 0.0f;
        },
        out);
    return out;
}

Vec3 blend(Maps maps, const Vec3& neutral, std::span<const Vec3> wrinkles, std::span<const float> masks) {
    Vec3 sum(0.0f);
    float total = 0.0f;
    for (size_t k = 0; k < wrinkles.size(); ++k) {
        sum += masks[k] * wrinkles[k];
        total += masks[k];
    }
    return maps == Maps::kWhole ? formulas::blend_whole(sum, total, neutral)
                                : formulas::blend_wrinkles(sum, total, neutral);
}

}  // namespace rumple::wrinkle_maps
