// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "base/tolerances.h"
#include "surface/cloth/base_cloth.h"
#include "surface/cloth/smooth_normals.h"
#include "surface/mesh/normals.h"
#include "surface/refine/refinement.h"

namespace rumple::base_cloth {
namespace {

struct Spring {
    float area = 0.0f;  // of the membrane that it stands for
    bool diagonal = false;
};
using Springs = std::map<std::pair<Index, Index>, Spring>;

float triangle_area(const Surface& surface, const Triangle& triangle) {
    const auto at = [&](int k) {
        return surface.positions_rest[surface.welded.corner_vertex[triangle.corner[k]]];
    };
    return 0.5f * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
}

// A polygon's area is shared by its sides so that the springs of a square grid, and of equilateral triangles,
// stretch like the membrane: two opposite sides of a quad carry its area in their direction, a triangle's
// three all of it.
Springs collect_springs(const Surface& surface) {
    std::vector<float> area(surface.welded.polygons(), 0.0f);
    for (const Triangle& triangle : surface.triangles)
        area[triangle.polygon] += triangle_area(surface, triangle);
    Springs springs;
    const auto add = [&](Index a, Index b, float area_share, bool diagonal) {
        Spring& spring = springs[std::minmax(a, b)];
        spring.area += area_share;
        spring.diagonal = diagonal;
    };
    for (Index p = 0; p < surface.welded.polygons(); ++p) {
        const Index size = surface.welded.polygon_size(p), begin = surface.welded.polygon_start[p];
        const auto vertex = [&](Index k) { return surface.welded.corner_vertex[begin + k % size]; };
        for (Index k = 0; k < size; ++k) add(vertex(k), vertex(k + 1), 2.0f * area[p] / float(size), false);
        if (size != 4) continue;
        add(vertex(0), vertex(2), 0.5f * area[p], true);
        add(vertex(1), vertex(3), 0.5f * area[p], true);
    }
    for (const Triangle& triangle : surface.triangles) {  // polygons of more than four corners
        if (surface.welded.polygon_size(triangle.polygon) <= 4) continue;
        for (int k = 0; k < 3; ++k) {
            const Index a = surface.welded.corner_vertex[triangle.corner[k]];
            const Index b = surface.welded.corner_vertex[triangle.corner[(k + 1) % 3]];
            if (!springs.contains(std::minmax(a, b))) add(a, b, triangle_area(surface, triangle), true);
        }
    }
    return springs;
}

void place_springs(Model& model) {
    const std::vector<Vec3>& rest = model.surface.positions_rest;
    const std::vector<Vec3> normals = smooth_normals_at_rest(model.surface);
    model.frame_to.assign(rest.size(), kNone);
    for (const auto& [pair, spring] : collect_springs(model.surface)) {
        const auto [a, b] = pair;
        const float length = glm::distance(rest[a], rest[b]);
        if (length < kShortestEdge) continue;
        model.springs.push_back({a, b, length, spring.area / (length * length), spring.diagonal,
                                 glm::distance(normals[a], normals[b]) / length});
        if (model.frame_to[a] == kNone) model.frame_to[a] = b;
        if (model.frame_to[b] == kNone) model.frame_to[b] = a;
    }
}

// The vertices that a first one is connected with, breadth first.
std::vector<Index> connected_from(Index first, const std::vector<std::vector<Index>>& neighbours,
                                  std::vector<bool>& seen) {
    std::vector<Index> found{first};
    seen[first] = true;
    for (size_t k = 0; k < found.size(); ++k) {
        for (const Index other : neighbours[found[k]]) {
            if (!seen[other]) found.push_back(other);
            seen[other] = true;
        }
    }
    return found;
}

// Sweeps over the springs carry a pull the farther the more the order runs along the cloth.
void put_springs_in_order(Model& model) {
    const size_t vertices = model.surface.welded.vertex_count;
    std::vector<std::vector<Index>> neighbours(vertices);
    for (const Model::Spring& spring : model.springs) {
        neighbours[spring.a].push_back(spring.b);
        neighbours[spring.b].push_back(spring.a);
    }
    std::vector<bool> seen(vertices), ordered(vertices);
    for (Index v = 0; v < static_cast<Index>(vertices); ++v) {
        if (seen[v]) continue;
        const Index end = connected_from(v, neighbours, seen).back();
        const std::vector<Index> part = connected_from(end, neighbours, ordered);
        model.order.insert(model.order.end(), part.begin(), part.end());
    }
    std::vector<Index> place(vertices);
    for (size_t k = 0; k < vertices; ++k) place[model.order[k]] = static_cast<Index>(k);
    model.spring_start.assign(vertices + 1, 0);
    for (Model::Spring& spring : model.springs) {
        if (place[spring.b] < place[spring.a]) std::swap(spring.a, spring.b);
        ++model.spring_start[place[spring.a] + 1];
    }
    std::partial_sum(model.spring_start.begin(), model.spring_start.end(), model.spring_start.begin());
    std::ranges::sort(model.springs, {}, [&](const Model::Spring& spring) {
        return std::pair(place[spring.a], place[spring.b]);
    });
}

void put_springs_in_fours(Model& model) {
    model.spring_fours.resize(in_fours(model.springs.size()) / kLanes);
    for (Model::SpringFour& four : model.spring_fours) {
        four.a.fill(model.surface.welded.vertex_count);
        four.b = four.a;
    }
    for (size_t s = 0; s < model.springs.size(); ++s) {
        const auto& [a, b, rest, weight, diagonal, curvature] = model.springs[s];
        Model::SpringFour& four = model.spring_fours[s / kLanes];
        const int k = static_cast<int>(s % kLanes);
        four.a[k] = a;
        four.b[k] = b;
        four.rest[k] = rest;
        four.weight[k] = weight;
        four.diagonal[k] = diagonal ? -1 : 0;
    }
}

// Per vertex: how many others in a row have to be swept before it.
std::vector<Index> depths_in_order(const Model& model) {
    std::vector<Index> depth(model.order.size(), 0);
    for (const Model::Spring& spring : model.springs)  // in the order of their first ends
        depth[spring.b] = std::max(depth[spring.b], depth[spring.a] + 1);
    return depth;
}

using SpringsOfVertex = std::vector<std::pair<Index, Index>>;  // the other end, the spring

void add_fours(const Model& model, const SpringsOfVertex& springs, std::vector<Model::Sweep::Four>& fours) {
    for (size_t k = 0; k < in_fours(springs.size()); ++k) {
        if (k % kLanes == 0) {
            Model::Sweep::Four& four = fours.emplace_back();
            four.other.fill(model.surface.welded.vertex_count);
            four.spring.fill(static_cast<Index>(model.springs.size()));
        }
        if (k >= springs.size()) break;
        std::tie(fours.back().other[k % kLanes], fours.back().spring[k % kLanes]) = springs[k];
    }
}

void plan_sweeps(Model& model) {
    std::vector<SpringsOfVertex> earlier(model.order.size()), later(model.order.size());
    for (Index s = 0; s < static_cast<Index>(model.springs.size()); ++s) {
        const Model::Spring& spring = model.springs[s];
        later[spring.a].push_back({spring.b, s});
        earlier[spring.b].push_back({spring.a, s});
    }
    const std::vector<Index> depth = depths_in_order(model);
    Model::Sweep& sweep = model.sweep;
    sweep.vertex = model.order;
    std::ranges::stable_sort(sweep.vertex, {}, [&](Index v) { return depth[v]; });
    for (const Index v : sweep.vertex) {
        sweep.earlier_start.push_back(static_cast<Index>(sweep.earlier.size()));
        sweep.later_start.push_back(static_cast<Index>(sweep.later.size()));
        add_fours(model, earlier[v], sweep.earlier);
        add_fours(model, later[v], sweep.later);
    }
    sweep.earlier_start.push_back(static_cast<Index>(sweep.earlier.size()));
    sweep.later_start.push_back(static_cast<Index>(sweep.later.size()));
}

void collect_triangles(Model& model) {
    const Surface& surface = model.surface;
    model.near = near_triangles(surface);
    model.triangle_of.assign(surface.welded.vertex_count, kNone);
    model.area.assign(surface.welded.vertex_count, 0.0f);
    for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
        for (const Index v : welded_vertices(surface, t)) {
            model.area[v] += triangle_area(surface, surface.triangles[t]) / 3.0f;
            if (model.triangle_of[v] == kNone) model.triangle_of[v] = t;
        }
    }
}

}  // namespace

std::shared_ptr<const Model> build(Surface surface) {
    auto model = std::make_shared<Model>();
    model->surface = std::move(surface);
    place_springs(*model);
    put_springs_in_order(*model);
    put_springs_in_fours(*model);
    plan_sweeps(*model);
    collect_triangles(*model);
    model->limit = vertex_limit_stencils(model->surface);
    model->clearance = build_clearance(model->surface);
    model->overlaps = find_overlaps(model->surface);
    model->hems = find_hems(model->surface);
    model->near_hems = find_near_hems(model->surface, model->hems);
    model->hem_overlaps = find_hem_overlaps(model->surface, model->hems, model->overlaps);
    const std::vector<Vec3>& rest = model->surface.positions_rest;
    model->tucked.assign(rest.size(), false);
    for (const HemOverlap& overlap : model->hem_overlaps)
        for (const Index v : overlap.border) model->tucked[v] = true;
    model->hem_room = room_over_parts(model->surface, model->hems, model->hem_overlaps, rest,
                                      vertex_normals(model->surface, rest));
    return model;
}

}  // namespace rumple::base_cloth
