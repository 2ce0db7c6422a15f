// SPDX-License-Identifier: GPL-3.0-or-later
// Rigs with reference poses, made of random bones.
#pragma once

#include <random>
#include <string>

#include "systems/wrinkle_maps/wrinkle_maps.h"

namespace rumple::tests {

using wrinkle_maps::Bone;
using wrinkle_maps::Rig;
using wrinkle_maps::Tracked;

class RandomRig {
  public:
    explicit RandomRig(unsigned seed) : random_(seed) {}

    float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
    Vec3 point(float size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
    Bone bone(float size) { return {point(size), point(size)}; }

    // A head of 0.1 m: in every pose about half of the bones move, by a centimetre.
    Rig rig(Index bones, Index poses) {
        Rig rig;
        for (Index i = 0; i < bones; ++i) {
            rig.names.push_back("bone" + std::to_string(i));
            rig.tracked.push_back(static_cast<Tracked>(i % 3));
            rig.group.push_back(kNone);
            rig.neutral.push_back(bone(0.1f));
        }
        for (Index k = 0; k < poses; ++k) {
            rig.poses.push_back({"pose" + std::to_string(k), rig.neutral});
            for (Index i = 0; i < bones; ++i) {
                if (i != k % bones && number(0, 1) < 0.5f) continue;
                rig.poses[k].bones[i].head += point(0.01f);
                rig.poses[k].bones[i].tail += point(0.01f);
            }
        }
        return rig;
    }

    std::vector<Bone> moved(std::vector<Bone> bones, float size) {
        for (Bone& bone : bones) bone = {bone.head + point(size), bone.tail + point(size)};
        return bones;
    }

    // Up to four bones a vertex, one in five of them not in the rig. Rows sum to 1.
    SparseRows weights(Index vertices, Index bones) {
        SparseRows rows;
        for (Index v = 0; v < vertices; ++v) {
            const Index first = pick(bones);
            float left = 1.0f;
            for (Index e = 0; e < 3; ++e) {
                const float weight = left * number(0.2f, 0.8f);
                rows.add(pick(5) == 0 ? kNone : (first + e) % bones, weight);
                left -= weight;
            }
            rows.add((first + 3) % bones, left);
            rows.end_row();
        }
        return rows;
    }

    Index pick(Index count) { return std::uniform_int_distribution<Index>(0, count - 1)(random_); }

  private:
    std::mt19937 random_;
};

// Every vertex has one bone: vertex v has bone v.
inline SparseRows one_bone_each(Index bones) {
    SparseRows rows;
    for (Index i = 0; i < bones; ++i) {
        rows.add(i, 1.0f);
        rows.end_row();
    }
    return rows;
}

}  // namespace rumple::tests
