// SPDX-License-Identifier: GPL-3.0-or-later
// Points of the subdivision limit surface at any place of the base.
//
// OpenSubdiv uses ptex faces. A triangle of a Loop mesh and a quad of a Catmull-Clark mesh are one ptex face.
// Any other polygon with n corners is n ptex faces, the i-th at corner i:
//
//   quad           3 --- 2     triangle  2        n-gon, sub-face i:
//   (u, v)         |     |               | \        (0,0) corner i
//                  0 --- 1               0 - 1      (1,0) middle of the edge to corner i + 1
//                                                   (1,1) centre
//                                                   (0,1) middle of the edge from corner i - 1
#include <opensubdiv/far/ptexIndices.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "base/elementary.h"
#include "base/stop.h"
#include "surface/refine/subdivider.h"

namespace rumple {
namespace {

using LimitFactory = Far::LimitStencilTableFactoryReal<double>;

struct PtexPlace {
    int face = 0;  // ptex face within the polygon
    double u = 0.0;
    double v = 0.0;
};

// Maps the polygon to the regular n-gon around the origin with corner 0 at (1, 0). Every triangulation of a
// polygon is also one of the regular n-gon, so this map is one-to-one for any rest shape (concave, bent,
// flat).
glm::dvec2 corner_in_regular_polygon(Index i, Index n) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    return {elementary::cos(angle), elementary::sin(angle)};
}

// Sub-face i is the kite of corner (1), the middles of its two edges and the
// centre (0). x is the coordinate from the corner to the centre, y the one at right
// angles. With s = u + v and d = u - v its bilinear map is
//   y = d * half_width,   x = s * depth + u v * c,   u v = (s^2 - d^2) / 4.
// So d is known, and s is the root of a quadratic, in a form without cancellation.
PtexPlace invert_kite(const glm::dvec2& p, Index n) {
    const double turn = 2.0 * std::numbers::pi / n;
    Index i = static_cast<Index>(std::lround(elementary::atan2(p.y, p.x) / turn));
    i = (i % n + n) % n;
    const glm::dvec2 corner = corner_in_regular_polygon(i, n);
    const double x = 1.0 - glm::dot(p, corner);
    const double y = corner.x * p.y - corner.y * p.x;
    const double half_width = elementary::cos(turn / 2) * elementary::sin(turn / 2);
    const double depth = elementary::sin(turn / 2) * elementary::sin(turn / 2);
    const double c = 1.0 - 2.0 * depth;
    const double d = y / half_width;
    const double q = x + c * d * d / 4.0;
    const double s = 2.0 * q / (depth + std::sqrt(std::max(depth * depth + c * q, 0.0)));
    return {i, std::clamp((s + d) / 2.0, 0.0, 1.0), std::clamp((s - d) / 2.0, 0.0, 1.0)};
}

PtexPlace to_ptex(const Surface& surface, const SurfacePoint& place, bool loop) {
    const Triangle& triangle = surface.triangles[place.triangle];
    const Index begin = surface.welded.polygon_start[triangle.polygon];
    const Index n = surface.welded.polygon_size(triangle.polygon);
    const double weight[3] = {1.0 - place.b0 - place.b1, place.b0, place.b1};
    static constexpr double kSquare[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static constexpr double kTriangle[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    glm::dvec2 p(0.0);
    for (int k = 0; k < 3; ++k) {
        const Index i = triangle.corner[k] - begin;
        if (n == 4) {
            p += weight[k] * glm::dvec2(kSquare[i][0], kSquare[i][1]);
        } else if (loop) {
            p += weight[k] * glm::dvec2(kTriangle[i][0], kTriangle[i][1]);
        } else {
            p += weight[k] * corner_in_regular_polygon(i, n);
        }
    }
    if (n != 4 && !loop) return invert_kite(p, n);
    PtexPlace result{0, std::clamp(p.x, 0.0, 1.0), std::clamp(p.y, 0.0, 1.0)};
    if (loop) result.v = std::min(result.v, 1.0 - result.u);
    return result;
}

// Isolates irregular vertices and creases up to this level. OpenSubdiv then uses Gregory patches around the
// vertices. Along infinitely sharp creases its patches end as at borders.
void refine_adaptively(Far::TopologyRefiner& refiner, const PolygonMesh& mesh, Index levels) {
    Far::TopologyRefiner::AdaptiveOptions options(levels);
    options.useInfSharpPatch = !mesh.creases.empty();
    refiner.RefineAdaptive(options);
}

SparseRows limit_rows_at(const Far::TopologyRefiner& refiner, const LimitFactory::LocationArrayVec& locations,
                         std::span<const Index> column_of) {
    LimitFactory::Options options;
    options.generate1stDerivatives = false;
    if (locations.empty()) return {};
    stop_if_asked();
    const std::unique_ptr<const Far::LimitStencilTableReal<double>> table(
        LimitFactory::Create(refiner, locations, nullptr, nullptr, options));
    return copy_rows(*table, column_of);
}

// The location of a polygon's corner. Its coordinates are static, because the location refers to them.
LimitFactory::LocationArray location_of_corner(const Far::PtexIndices& ptex, Index polygon, Index size,
                                               Index corner, bool loop) {
    static constexpr double kZero = 0.0, kOne = 1.0;
    LimitFactory::LocationArray location;
    location.numLocations = 1;
    const bool is_one_face = loop || size == 4;  // one ptex face
    location.ptexIdx = ptex.GetFaceId(polygon) + (is_one_face ? 0 : corner);
    location.s = is_one_face && (corner == 1 || (corner == 2 && !loop)) ? &kOne : &kZero;
    location.t = is_one_face && corner >= 2 ? &kOne : &kZero;
    return location;
}

// Distributes the rows of attached places to all places. Unattached places get an empty row.
SparseRows spread_rows(const SparseRows& attached, std::span<const SurfacePoint> places) {
    SparseRows rows;
    Index r = 0;
    for (const SurfacePoint& place : places) {
        if (place.triangle != kNone) {
            rows.append_row(attached, r++);
        } else {
            rows.end_row();
        }
    }
    return rows;
}

}  // namespace

SparseRows limit_rows_by_patches(const PolygonMesh& mesh) {
    const UsedVertices used(mesh);
    const Refiner refiner = make_refiner(mesh, used);
    refine_adaptively(*refiner, mesh, kExactLimitLevels);
    const Far::PtexIndices ptex(*refiner);
    const bool loop = refiner->GetSchemeType() == Sdc::SCHEME_LOOP;
    LimitFactory::LocationArrayVec locations(mesh.vertex_count);
    for (Index p = mesh.polygons() - 1; p >= 0; --p) {
        const Index begin = mesh.polygon_start[p], size = mesh.polygon_size(p);
        for (Index k = 0; k < size; ++k)
            locations[mesh.corner_vertex[begin + k]] = location_of_corner(ptex, p, size, k, loop);
    }
    return limit_rows_at(*refiner, locations, used.vertex_of);
}

SparseRows limit_stencils(const Surface& surface, std::span<const SurfacePoint> places, Index exact_levels) {
    if (places.empty()) return {};
    const UsedVertices used(surface.welded);
    const Refiner refiner = make_refiner(surface.welded, used);
    refine_adaptively(*refiner, surface.welded, exact_levels);
    const Far::PtexIndices ptex(*refiner);
    const bool loop = refiner->GetSchemeType() == Sdc::SCHEME_LOOP;

    std::vector<double> u, v;  // of attached places; reserved, because locations have pointers into them
    u.reserve(places.size());
    v.reserve(places.size());
    LimitFactory::LocationArrayVec locations;
    for (const SurfacePoint& place : places) {
        if (place.triangle == kNone) continue;
        const PtexPlace at = to_ptex(surface, place, loop);
        u.push_back(at.u);
        v.push_back(at.v);
        LimitFactory::LocationArray location;
        location.ptexIdx = ptex.GetFaceId(surface.triangles[place.triangle].polygon) + at.face;
        location.numLocations = 1;
        location.s = &u.back();
        location.t = &v.back();
        locations.push_back(location);
    }
    const SparseRows attached = limit_rows_at(*refiner, locations, used.vertex_of);
    assert(attached.rows() == static_cast<Index>(locations.size()));
    return spread_rows(attached, places);
}

}  // namespace rumple
