// SPDX-License-Identifier: GPL-3.0-or-later
#include "systems/wrinkle_mesh/layers.h"

#include <algorithm>
#include <string>

#include "base/errors.h"
#include "base/expect.h"
#include "base/parallel.h"
#include "base/solve_team.h"
#include "base/stop.h"
#include "surface/mesh/positions.h"
#include "systems/wrinkle_mesh/pose.h"

namespace rumple::wrinkle_mesh {
namespace {

// Limit of missed_by_limit() / edge. A fold that is five edges wide, with cloth a tenth longer than its base,
// needs less. A larger value comes from a kink in a joint that skinning has crushed.
constexpr float kMostMissed = 1.0f / 7.0f;

std::vector<Vec3> differences(std::span<const Vec3> to, std::span<const Vec3> from) {
    std::vector<Vec3> out(to.size());
    for_each_index(out.size(), kLeastSteps, [&](size_t v) { out[v] = to[v] - from[v]; });
    return out;
}

void add(std::span<Vec3> positions, std::span<const Vec3> displacements) {
    for_each_index(positions.size(), kLeastSteps, [&](size_t v) { positions[v] += displacements[v]; });
}

// The vertices of a layer without its own folds, over positions of the base or of the layer below.
std::vector<Vec3> attached_over(const Model& layer, std::span<const Vec3> below) {
    std::vector<Vec3> out(layer.attached.size());
    attach(layer.base, layer.attachments, weld_positions(layer.base, below), {}, out);
    return out;
}

// The vertices of the finest layer over positions of the base, without folds.
std::vector<Vec3> unwrinkled_over(const Layers& layers, std::span<const Vec3> base) {
    std::vector<Vec3> out(base.begin(), base.end());
    for (const auto& layer : layers.layers) out = attached_over(*layer, out);
    return out;
}

// What layers need of the base without folds: first at its vertices as the artist has them, then at the
// vertices of each layer.
class BaseWithoutFolds {
  public:
    // Throws InvalidInput if positions do not match the base.
    BaseWithoutFolds(const Layers& layers, std::span<const Settings> settings, const Input& input,
                     const GuideLines* guide)
        : positions_(input.positions.begin(), input.positions.end()),
          to_spare_(share_to_spare(layers.base, input, length_to_spare(settings))) {
        const Surface& base = layers.base;
        const float radius = settings[0].bend_radius;
        check_frame(base, positions_);
        if (radius <= 0.0f && !guide) return;
        const std::vector<Vec3> welded = weld_positions(base, positions_);
        std::vector<SpareCloth> of_welded = spare_cloth(base, layers.bent_lines, welded, radius);
        if (guide) {
            const std::vector<GuidedStrain> asked = guided_strain(*guide, welded);
            for (size_t w = 0; w < asked.size(); ++w) of_welded[w] = spared_along(of_welded[w], asked[w]);
            for (const Index w : base.welded_of) guided_.push_back(asked[w]);
        }
        for (const Index w : base.welded_of) spare_.push_back(of_welded[w]);
    }

    // Interpolates to the vertices of the next layer.
    void carry_to(const Model& layer, Pose& pose) {
        pose.unwrinkled = positions_ = attached_over(layer, positions_);
        if (!to_spare_.empty()) pose.to_spare = to_spare_ = carry(layer, std::span<const float>(to_spare_));
        if (!spare_.empty()) pose.spare = spare_ = carry(layer, std::span<const SpareCloth>(spare_));
        if (!guided_.empty()) pose.guided = guided_ = carry(layer, std::span<const GuidedStrain>(guided_));
    }

  private:
    std::vector<Vec3> positions_;
    std::vector<float> to_spare_;       // Pose::to_spare; empty without bodies
    std::vector<SpareCloth> spare_;     // empty: folds along any line
    std::vector<GuidedStrain> guided_;  // empty: no painted directions
};

// How far the next layer may move inwards: what is left after the movement of this layer's vertices.
std::vector<float> gap_left(const Pose& pose, std::span<const Vec3> solved) {
    std::vector<float> gap(pose.gap.size());
    for_each_index(gap.size(), kLeastSteps, [&](size_t v) {
        const float outwards = glm::dot(solved[v] - pose.attachment[v], pose.normal[v]);
        gap[v] = std::max(pose.gap[v] + outwards, 0.0f);
    });
    return gap;
}

// Corrects displacements of solved vertices that would enter a surface below or in front. This is enough for
// the surface between the vertices. gap: from gap_left(), or none.
void keep_outside(const Pose& pose, std::span<const float> gap, std::span<Vec3> displacements) {
    for_each_index(displacements.size(), kLeastSteps, [&](size_t v) {
        Vec3& displacement = displacements[v];
        if (!pose.self_contact.empty() && pose.self_contact[v].towards != Vec3(0.0f))
            displacement = Vec3(0.0f);
        if (gap.empty()) return;
        const float too_deep = -gap[v] - glm::dot(displacement, pose.normal[v]);
        if (too_deep > 0.0f) displacement += too_deep * pose.normal[v];
    });
}

// Converts values of the base's vertices to the vertices that its layer solves: the welded vertices of
// polygons.
std::vector<Index> hints_of_solved(const Surface& base, std::span<const Index> hint) {
    std::vector<bool> used(base.welded.vertex_count, false);
    for (const Index w : base.welded.corner_vertex) used[w] = true;
    std::vector<Index> out;
    for (Index w = 0; w < base.welded.vertex_count; ++w)
        if (used[w]) out.push_back(hint[base.representative[w]]);
    return out;
}

// The input of a layer: first the input of the frame, then the results of the layer below.
class LayerInput {
  public:
    // The base mesh is a cage around its smooth surface, and only the gap accounts for this surface. So only
    // the layers on it use bodies.
    explicit LayerInput(const Input& input) : input_(input), bodies_(input.bodies) {
        input_.bodies = nullptr;
    }

    const Input& input() const { return input_; }

    // Becomes the input of the next layer, from the solved positions of this one. pose: the pose in which
    // this layer was solved, with its contacts. base: its base. missed_by_limit: missed_by_limit() of the
    // solved positions. finest: whether the next layer is the finest.
    void go_on(const Surface& base, const Pose& pose, std::vector<Vec3> solved,
               std::vector<Vec3> missed_by_limit, bool finest) {
        gap_ = gap_left(pose, solved);
        keep_outside(pose, gap_, missed_by_limit);
        positions_ = std::move(solved);
        add(positions_, missed_by_limit);
        if (input_.bodies) {
            body_hint_ = pose.body;
        } else if (bodies_) {
            body_hint_ = hints_of_solved(base, input_.body_hint);
        }
        input_.body_hint = body_hint_;
        input_.positions = positions_;
        input_.gap = gap_;
        input_.looked_below = input_.bodies != nullptr;
        input_.bodies = bodies_;
        input_.shown = finest;
    }

  private:
    Input input_;
    const PosedCollider* bodies_;
    std::vector<Vec3> positions_;
    std::vector<float> gap_;
    std::vector<Index> body_hint_;
};

// Marks vertices for which the layer below searched with a larger reach and found nothing in front. The next
// layer need not search there. Per vertex; empty before the first layer.
class NothingInReach {
  public:
    // Called once for every layer, coarse first. A vertex is marked if all corners of its triangle were.
    void go_on(const Model& layer) {
        const std::vector<std::uint8_t> below = std::move(nothing_);
        nothing_.assign(layer.attached.size(), 0);
        if (below.empty()) return;
        for_each_index(nothing_.size(), kLeastSteps, [&](size_t v) {
            const auto [a, b, c] = display_vertices(layer.base, layer.attachments.places[v].triangle);
            nothing_[v] = below[a] && below[b] && below[c];
        });
    }
    bool at(size_t vertex) const { return nothing_[vertex] != 0; }
    void mark(size_t vertex) { nothing_[vertex] = 1; }

  private:
    std::vector<std::uint8_t> nothing_;
};

// The search distance of a layer, object units. Its attachment radius is the share `apart` of it. 0 if the
// vertex cannot move.
std::vector<float> reaches(const Model& layer, const Settings& settings, const Paint& paint) {
    std::vector<float> reach = attachment_radii(layer, settings, paint);
    const float share = settings.apart > 0.0f ? 1.0f / settings.apart : 0.0f;
    for_each_index(reach.size(), kLeastSteps, [&](size_t v) { reach[v] *= share; });
    return reach;
}

// Fills in Pose::self_contact and heights.
void find_self_contacts(const SelfContactMesh& mesh, const Model& layer, const Settings& settings,
                        const Paint& paint, NothingInReach& nothing, Pose& pose) {
    nothing.go_on(layer);
    if (settings.apart <= 0.0f && settings.slide <= 0.0f) return;
    std::vector<float> reach = reaches(layer, settings, paint);
    for_each_index(reach.size(), kLeastSteps, [&](size_t v) {
        if (nothing.at(v)) reach[v] = 0.0f;
    });
    const PosedSelfContactMesh posed(mesh, pose.attachment);
    pose.self_contact = posed.facing(reach);
    pose.heights = posed.heights();
    for_each_index(reach.size(), kLeastSteps, [&](size_t v) {
        if (reach[v] > 0.0f && pose.self_contact[v].towards == Vec3(0.0f)) nothing.mark(v);
    });
}

// A body in front bounds a vertex like its own cloth. The share `apart` is not applied, because a body does
// not move away. If it is nearer, its plane replaces that of find_self_contacts().
void look_ahead(const PosedCollider& bodies, const Model& layer, const Settings& settings, const Paint& paint,
                float thickness, NothingInReach& nothing, Pose& pose) {
    nothing.go_on(layer);
    if (settings.apart <= 0.0f) return;
    const std::vector<float> reach = reaches(layer, settings, paint);
    for_each_index(reach.size(), kLeastSearches, [&](size_t v) {
        if (reach[v] <= 0.0f || nothing.at(v)) return;
        const Vec3& a = pose.attachment[v];
        const BodyAhead body = bodies.ahead(a, pose.normal[v], reach[v] + thickness, thickness);
        if (body.triangle == kNone) {
            nothing.mark(v);
            return;
        }
        const float before = std::max(glm::dot(a - body.point, body.normal) - thickness, 0.0f);
        SelfContactSide& facing = pose.self_contact[v];
        if (before / settings.apart < facing.distance)
            facing = {-body.normal, before / settings.apart, facing.in_any_direction};
    });
}

void check_counts(const Layers& layers, std::span<const Settings> settings, std::span<const Paint> paint,
                  const Input& input) {
    expect_count("settings", settings.size(), layers.layers.size(), "layers");
    expect_count("paint", paint.size(), layers.layers.size(), "layers");
    const size_t vertices = layers.base.display.vertex_count;
    if (input.bodies) expect_count("body_hint", input.body_hint.size(), vertices, "values");
    if (!input.gap.empty()) expect_count("gap", input.gap.size(), vertices, "values");
    if (paint[0].guide)
        expect_count("paint.along", paint[0].guide->along.size(), size_t(layers.base.welded.vertex_count),
                     "welded vertices");
}

// The largest number of threads that the layers ask for; 0 if one of them leaves it to the size.
int most_threads(std::span<const Settings> settings) {
    int most = 1;
    for (const Settings& of_layer : settings) {
        if (of_layer.threads == 0) return 0;
        most = std::max(most, of_layer.threads);
    }
    return most;
}

bool fits(const Layers& layers, const LayersState* state) {
    return state && state->layers.size() == layers.layers.size();
}

}  // namespace

std::vector<Vec3> missed_by_limit(const Layers& layers, size_t layer, std::span<const Vec3> displacements) {
    std::vector<Vec3> of_limit(displacements.size());
    apply(layers.limit[layer], to_rows(displacements), of_limit);
    std::vector<Vec3> missed = differences(displacements, of_limit);
    for_each_index(missed.size(), kLeastSteps, [&](size_t v) {
        const float most = kMostMissed * layers.layers[layer]->local_edge[v];
        const float length = glm::length(missed[v]);
        if (length > most) missed[v] *= most / length;
    });
    return missed;
}

Surface solved_surface(const Model& layer) {
    const PolygonMesh& mesh = layer.solved;
    return build_surface({layer.positions_rest, mesh.polygon_start, mesh.corner_vertex, fan_triangles(mesh),
                          false, mesh.creases});
}

std::shared_ptr<const Layers> build_layers(Surface base, Index levels, Index display_steps,
                                           Index most_vertices, Index viewport_steps) {
    expect_within("levels", levels, 0, kMostLevels);
    auto out = std::make_shared<Layers>();
    out->base = std::move(base);
    FineSource whole;
    whole.level = levels;
    whole.most_vertices = most_vertices;
    refuse_too_many(out->base.welded.corners(), whole, display_steps);
    FineMesh fine = refine_subdivision(out->base.welded, 0);
    for (Index level = 0; level <= levels; ++level) {
        Source source;
        source.level = level > 0 ? 1 : 0;
        source.most_vertices = most_vertices;
        Surface on = level > 0 ? solved_surface(*out->layers.back()) : out->base;
        if (level > 0) fine = compose(refine_subdivision(on.welded, 1), fine);
        // The base mesh is the cage of the subdivision, so its vertices keep their places.
        const AttachmentKind kind = level > 0 ? AttachmentKind::kLimit : AttachmentKind::kLinear;
        out->layers.push_back(build_unshown(std::move(on), source, kind));
    }
    const auto add_what_is_solved = [&] {
        for (const auto& layer : out->layers) {
            out->self_contact.emplace_back(layer->positions_rest, layer->triangles);
            stop_if_asked();
            out->limit.push_back(vertex_limit_stencils(solved_surface(*layer)));
        }
        out->stretch = build_stretch(out->base);
        out->bent_lines = build_bent_lines(out->base);
        out->hems = find_overlapping_hems(out->base);
        out->shown_in_viewport = show_in_viewport(out->base, out->base, fine, display_steps, viewport_steps,
                                                  out->layers.back()->positions_rest);
    };
    const auto add_what_is_shown = [&] {
        out->shown = show_fine(out->base, out->base, fine, display_steps, out->layers.back()->positions_rest);
    };
    in_parallel(add_what_is_shown, add_what_is_solved);
    return out;
}

std::vector<std::vector<float>> carry_paint(const Layers& layers, std::span<const float> base_values) {
    std::vector<std::vector<float>> out;
    for (const auto& layer : layers.layers)
        out.push_back(carry_paint(*layer, out.empty() ? base_values : std::span<const float>(out.back())));
    return out;
}

LayersState activated(const LayersState& state) {
    LayersState out;
    for (const State& layer : state.layers) out.layers.push_back(activated(layer));
    out.solved = state.solved;
    return out;
}

LayersState solve(const Layers& layers, std::span<const Settings> settings, std::span<const Paint> paint,
                  const Input& input, const LayersState* state, std::vector<Report>& reports) {
    check_counts(layers, settings, paint, input);
    if (!fits(layers, state)) state = nullptr;
    reports.assign(layers.layers.size(), {});
    const SolveTeam team = team_for(*layers.layers.back(), most_threads(settings));
    LayersState out;
    LayerInput layer_input(input);
    BaseWithoutFolds without_folds(layers, settings, input, paint[0].guide.get());
    PaintOfHems of_hems(layers.base, layers.hems, input.positions, layers.layers.size());
    NothingInReach of_cloth, of_bodies;
    for (size_t k = 0; k < layers.layers.size(); ++k) {
        const Model& layer = *layers.layers[k];
        check(layer, paint[k]);
        Pose pose = make_pose(layer, layer_input.input());
        without_folds.carry_to(layer, pose);
        find_self_contacts(layers.self_contact[k], layer, settings[k], paint[k], of_cloth, pose);
        if (input.bodies)
            look_ahead(*input.bodies, layer, settings[k], paint[k], input.thickness, of_bodies, pose);
        out.layers.push_back(solve_pose(layer, settings[k], of_hems.go_on(layer, settings[k], paint[k]),
                                        layer_input.input(), pose, state ? &state->layers[k] : nullptr,
                                        reports[k]));
        const OffsetFrames frames(layer, settings[k], layer_input.input(), pose);
        out.solved = solved_positions(pose, frames.in_object(out.layers[k]));
        layer_input.go_on(layer.base, pose, out.solved,
                          missed_by_limit(layers, k, differences(out.solved, pose.unwrinkled)),
                          k + 2 == layers.layers.size());
    }
    return out;
}

std::vector<Vec3> offsets(const Layers& layers, std::span<const Vec3> animated, const LayersState& state) {
    expect_count("state", state.solved.size(), layers.layers.back()->attached.size(), "positions");
    check_frame(layers.base, animated, "animated");
    return differences(state.solved, unwrinkled_over(layers, animated));
}

void show(const Layers& layers, std::span<const Vec3> animated, std::span<const Vec3> positions,
          const LayersState& state, Picture& picture, bool in_viewport) {
    check_frame(layers.base, positions);
    const SolveTeam team = team_for(*layers.layers.back(), 0);
    const ShownMesh& shown = shown_mesh(layers, in_viewport);
    std::vector<Vec3> offset = offsets(layers, animated, state);
    std::vector<Vec3> subdivided_from = state.solved;
    const bool subdivided = Index(shown.from_solved.index.size()) > shown.mesh.vertex_count;
    if (subdivided) {
        const std::vector<Vec3> missed = missed_by_limit(
            layers, layers.layers.size() - 1, differences(state.solved, unwrinkled_over(layers, positions)));
        add(subdivided_from, missed);
        add(offset, missed);
    }
    const std::vector<Vec3> base = weld_positions(layers.base, positions);
    show_frame(layers.base, shown, layers.stretch, base, triangle_frames(layers.base, base), subdivided_from,
               offset, picture);
    embed_frame(layers.base, shown, animated, picture);
}

}  // namespace rumple::wrinkle_mesh
