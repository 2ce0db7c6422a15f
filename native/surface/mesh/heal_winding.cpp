// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/mesh/heal_winding.h"

#include <algorithm>
#include <cmath>

namespace rumple {
namespace {

constexpr double kInsideOut =
    0.03;  // least volume / area^1.5 of a tube or a bag; a sheet has less; a ball has 0.094

struct Side {
    Index polygon;
    bool turned;
};
using Sides = std::vector<std::vector<Side>>;  // for every polygon

Sides sides_of(const std::vector<Joint>& joints, const std::vector<Index>& polygon_of, Index polygons) {
    Sides sides(polygons);
    for (const Joint& joint : joints) {
        const Index p = polygon_of[joint.corner[0]], q = polygon_of[joint.corner[1]];
        sides[p].push_back({q, joint.turned});
        sides[q].push_back({p, joint.turned});
    }
    return sides;
}

// The polygons that are connected to one polygon by joints or seams, itself first. `turned` receives whether
// they have the opposite winding to it.
std::vector<Index> part_of(Index first, const Sides& joined, const Sides& sewn, std::vector<bool>& reached,
                           std::vector<bool>& turned) {
    std::vector<Index> part{first};
    reached[first] = true;
    const auto go_on = [&](Index p, const Sides& sides) {
        for (const auto& [q, against] : sides[p]) {
            if (reached[q]) continue;
            reached[q] = true;
            turned[q] = turned[p] != against;
            part.push_back(q);
        }
    };
    // Follows all joints before any seam, so that a seam with a wrong winding does not cut a joint.
    for (std::size_t next = 0, seam = 0; seam < part.size();) {
        if (next < part.size()) {
            go_on(part[next++], joined);
        } else {
            go_on(part[seam++], sewn);
        }
    }
    return part;
}

// Whether a part faces inwards: 3V = sum over polygons of (corner - middle) . area, as for a closed surface.
// The openings of a garment change the result little, because the part's middle is the origin.
bool is_inside_out(const HealedMesh& healed, std::span<const Vec3> positions, const std::vector<Index>& part,
                   const std::vector<bool>& turned) {
    const auto first_of = [&](Index p) {
        const Index corner = healed.mesh.polygon_start[p];
        return glm::dvec3(positions[healed.vertex_source[healed.mesh.corner_vertex[corner]]]);
    };
    glm::dvec3 moment(0.0), whole(0.0);
    double area = 0.0, volume = 0.0;
    for (const Index p : part) {
        const glm::dvec3 half = area_vector(healed, positions, p) * (turned[p] ? -0.5 : 0.5);
        moment += first_of(p) * glm::length(half);
        volume += glm::dot(first_of(p), half) / 3.0;
        whole += half;
        area += glm::length(half);
    }
    if (area > 0.0) volume -= glm::dot(moment / area, whole) / 3.0;
    return volume < -kInsideOut * area * std::sqrt(area);
}

}  // namespace

std::vector<Index> polygons_of_corners(const PolygonMesh& mesh) {
    std::vector<Index> polygon(mesh.corners());
    for (Index p = 0; p < mesh.polygons(); ++p)
        std::fill(polygon.begin() + mesh.polygon_start[p], polygon.begin() + mesh.polygon_start[p + 1], p);
    return polygon;
}

glm::dvec3 area_vector(const HealedMesh& healed, std::span<const Vec3> positions, Index p) {
    const PolygonMesh& mesh = healed.mesh;
    const auto at = [&](Index c) {
        return glm::dvec3(positions[healed.vertex_source[mesh.corner_vertex[c]]]);
    };
    const glm::dvec3 origin = at(mesh.polygon_start[p]);
    glm::dvec3 sum(0.0);
    for (Index c = mesh.polygon_start[p]; c < mesh.polygon_start[p + 1]; ++c)
        sum += glm::cross(at(c) - origin, at(next_corner(mesh, p, c)) - origin);
    return sum;
}

std::vector<bool> wind_polygons(const HealedMesh& healed, std::span<const Vec3> positions,
                                std::vector<Joint>& joints, const std::vector<Joint>& seams,
                                std::set<std::array<Index, 2>>& cut) {
    const PolygonMesh& mesh = healed.mesh;
    const std::vector<Index> polygon = polygons_of_corners(mesh);
    const Sides joined = sides_of(joints, polygon, mesh.polygons()),
                sewn = sides_of(seams, polygon, mesh.polygons());
    std::vector<bool> turned(mesh.polygons(), false), reached(mesh.polygons(), false);
    for (Index first = 0; first < mesh.polygons(); ++first) {
        if (reached[first]) continue;
        const std::vector<Index> part = part_of(first, joined, sewn, reached, turned);
        double as_it_is = 0.0, other = 0.0;  // areas
        for (const Index p : part)
            (turned[p] ? other : as_it_is) += glm::length(area_vector(healed, positions, p));
        if (other > as_it_is)
            for (const Index p : part) turned[p] = !turned[p];
        if (is_inside_out(healed, positions, part, turned))
            for (const Index p : part) turned[p] = !turned[p];
    }
    std::erase_if(joints, [&](const Joint& joint) {
        const Index p = polygon[joint.corner[0]], q = polygon[joint.corner[1]];
        const bool fits = (turned[p] != turned[q]) == joint.turned;
        const Index a = mesh.corner_vertex[joint.corner[0]];
        const Index b = mesh.corner_vertex[next_corner(mesh, p, joint.corner[0])];
        if (!fits) cut.insert({std::min(a, b), std::max(a, b)});
        return !fits;
    });
    return turned;
}

}  // namespace rumple
