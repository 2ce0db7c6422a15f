// SPDX-License-Identifier: GPL-3.0-or-later
// The base cloth: the coarse mesh itself becomes cloth around its animation, so that it hangs, pulls taut and
// rests on the body. Mueller and Chentanez 2010, section 4.3: a simulated base whose edges hardly resist
// compression. Here: the equilibrium of each pose, without inertia (Hang), by Newton's method with conjugate
// gradients; swing.h has inertia. docs/base_cloth.md has the energy.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "base/lanes.h"
#include "surface/cloth/clearance.h"
#include "surface/cloth/free_hems.h"
#include "surface/cloth/hem_room.h"
#include "surface/cloth/overlaps.h"
#include "surface/mesh/topology.h"

namespace rumple::base_cloth {

// Stiffness is per mass of cloth: membrane stiffness (N/m) over mass per area (kg/m^2), in object units^2 /
// s^2.
struct Settings {
    float stretch = 2000.0f;         // stiffness of edges that are longer than at rest, > 0
    float strain_limit = 0.02f;      // beyond this strain, stretch is kBeyondLimit times as stiff, >= 0
    float shear = 500.0f;            // stiffness of quad diagonals that are longer than at rest, >= 0
    float compression = 15.0f;       // k1: stiffness of edges shorter than at rest, >= 0
    float compression_limit = 0.7f;  // c_l: length / rest length below which k2 applies, 0..1
    float folded = 30.0f;            // k2: stiffness of edges shorter than c_l, >= 0
    float smoothing = 60.0f;    // resistance of edges against turning from their animated direction, >= 0
    float tube_radius = 0.07f;  // object units, > 0: around a tube of radius R these three count by the share
                                // (tube_radius / R)^4, at most 1
    float flat_share = 1.0f;    // the least share, along tubes and of flat cloth, 0..1
    float hem_share = 0.1f;     // share of smoothing at a hem that nothing holds, 0..1
    float slack = 1.0f;         // length of the cloth / length of the modelled garment, > 0
    Vec3 hang{0.0f};            // object space, length 0..1: in this direction there is no slack
    float follow = 400.0f;      // pull towards the animation where nothing is pinned, 1/s^2, > 0
    float room = 0.03f;         // largest distance of a vertex from its animated place, object units, >= 0
    float slide_room = 0.0f;    // the same along the surface, if larger than room; object units, >= 0
    float friction = 0.0f;      // coefficient of Coulomb friction on the bodies under it, >= 0
    Vec3 gravity{0.0f, 0.0f, -9.81f};  // object space, object units / s^2, finite
    ClearanceSettings clearance{};
    int steps = 12;               // largest number of Newton steps from a given state, >= 0
    int start_steps = 30;         // from the animation, >= 0
    int most_cg_iterations = 30;  // of conjugate gradients (CG), in a Newton step, >= 0
};

// Throws InvalidInput naming the first setting out of its range.
void check(const Settings& settings);

// The largest painted factor on room, for cloth that hangs free of the body.
inline constexpr float kMostRoomFactor = 1e3f;

// Painted factors per display vertex of the base. Empty: follow is 0, room is 1 everywhere.
struct Paint {
    std::vector<float> follow;  // 0..1; 1: pinned to the animation
    std::vector<float> room;    // 0..kMostRoomFactor, factor on room; on slide_room at most 1
};

// Built once at rest, then immutable.
struct Model {
    Surface surface;
    // Springs: polygon sides, and the diagonals of quads.
    struct Spring {
        Index a, b;
        float rest;
        float weight;  // its share of the membrane: its area / rest^2
        bool diagonal;
        float curvature;  // along it, of the smoothed surface at rest: 1 / R around a tube, 1 / object units
    };
    // In the order of their first ends, which come before the second ones.
    std::vector<Spring> springs;
    std::vector<Index> order;         // vertices in breadth-first order, from an end of each part
    std::vector<Index> spring_start;  // per place in the order, and the end: the first spring from there
    // The same springs in their order, in groups of four. The last group is filled with springs without
    // weight, whose vertex is one past the last.
    struct SpringFour {
        std::array<Index, kLanes> a, b;
        Lanes rest{}, weight{};
        LaneMask diagonal{};
    };
    std::vector<SpringFour> spring_fours;
    // Sweeps over the vertices have the same result as in `order`. Each vertex comes after its earlier
    // neighbours. Vertices of the same depth do not depend on each other, and are adjacent, so that a
    // processor computes several at a time.
    struct Sweep {
        // Springs of a vertex. If there are fewer than four, the others are one past the last spring and the
        // last vertex.
        struct Four {
            std::array<Index, kLanes> other, spring;
        };
        std::vector<Index> vertex;
        std::vector<Index> earlier_start, later_start;  // per place, and the end: the first four
        std::vector<Four> earlier;  // to vertices that are earlier in `order`, in this order
        std::vector<Four> later;    // to later ones
    };
    Sweep sweep;
    std::vector<float> area;      // per vertex, object units^2
    std::vector<Index> frame_to;  // per vertex: the neighbour that its tangent points to, or kNone
    SparseRows limit;             // limit position <- vertices
    NearTriangles near;
    std::vector<Index> triangle_of;  // per vertex: one of its triangles, or kNone (loose)
    ClearanceModel clearance;
    std::vector<Overlap> overlaps;
    Hems hems;
    std::vector<NearHem> near_hems;  // per vertex
    std::vector<HemOverlap> hem_overlaps;
    std::vector<bool> tucked;     // per vertex: whether it is on a border under another part
    std::vector<float> hem_room;  // room_over_parts() at rest
};
std::shared_ptr<const Model> build(Surface surface);

// The motion of cloth with inertia when its frame was solved (swing.h). Per welded vertex, object space of
// that frame.
struct Motion {
    std::vector<Vec3> position;         // object units
    std::vector<Vec3> velocity;         // object units / s, without the locomotion that causes no inertia
    std::vector<Vec3> animated;         // object units
    std::vector<Vec3> animated_before;  // in the frame before that
    float seconds = 0.0f;               // between these two
    float fastest = std::numeric_limits<float>::max();  // speed in the frame, object units / s; unknown: most
    Vec3 gravity{0.0f};      // that acted, object units / s^2; without inertia in the frame of the rest shape
    Vec3 wind{0.0f};         // that blew, object units / s
    std::vector<Vec3> air;   // that blew beside it, or none
    std::vector<Vec3> push;  // acceleration that acted beside gravity, or none

    size_t values() const {
        return position.size() + velocity.size() + animated.size() + animated_before.size() + air.size() +
               push.size();
    }
};

// The values that the next frame starts from.
struct State {
    std::vector<Vec3> offset;   // per welded vertex, in the animated vertex's tangent frame; not with inertia
    std::vector<float> length;  // of every spring in the pose that was solved
    std::vector<float> clearance;     // likewise
    std::vector<float> ahead_height;  // likewise
    float moved = 0.0f;               // as in the report, object units; 0 if the solve did not improve it
    std::vector<Index> body_hint;     // only makes the next frame faster
    std::vector<Index> contact_hint;
    Motion motion;  // only with inertia

    size_t bytes() const {
        return (offset.size() + motion.values()) * sizeof(Vec3) +
               (length.size() + clearance.size() + ahead_height.size()) * sizeof(float) +
               (body_hint.size() + contact_hint.size()) * sizeof(Index);
    }
};

struct Report {
    int steps = 0;          // 0: the cloth was asleep, nothing was solved
    int cg_iterations = 0;  // of all steps
    float moved = 0.0f;     // largest movement of a vertex in the last full step, object units
    float offset_mean = 0.0f;
    float offset_max = 0.0f;
    float taut = 0.0f;        // share of the springs that are longer than at rest
    float touching = 0.0f;    // share of the vertices that rest on the inner surface
    float body_known = 0.0f;  // share of the vertices that have a body under them
};

struct Result {
    std::vector<Vec3> positions;  // per display vertex, object space
    std::vector<float> gap;       // per display vertex: height above the inner surface, object units, >= 0
    // Per display vertex: a triangle of a body near it, or kNone; empty without bodies
    std::vector<Index> body_hint;
    State state;
    Report report;
};

// Solves one frame. positions: animated, per display vertex, object space. bodies: or none. state: of the
// frame before, or none. Throws InvalidInput. Deterministic. Cost: about 0.03 us per vertex and CG iteration,
// and 1 us per vertex and step for contact.
Result solve(const Model& model, const Settings& settings, const Paint& paint,
             std::span<const Vec3> positions, const PosedCollider* bodies, const State* state);

}  // namespace rumple::base_cloth
