// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/as_modelled.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <tuple>

namespace rumple {
namespace {

// ---- triangles that were quads

// Two triangles may make a quad if the cosines of its angles are at most kSkewed, and that of their normals
// is at least kFlat. It is surely one if its cosines are at most kStraight.
constexpr float kSkewed = 0.8f, kStraight = 0.45f, kFlat = 0.7f;

// Two triangles with a common edge. Pairs are taken by their badness.
struct Pair {
    float badness, skewed;
    Index left, right;            // polygons
    std::array<Index, 4> corner;  // of the quad, from the one on the left
};

// The corner of a triangle that is not at this edge, as its number in the triangle.
Index opposite(const PolygonMesh& mesh, Index triangle, const Edge& e) {
    const Index* corner = &mesh.corner_vertex[mesh.polygon_start[triangle]];
    for (Index k = 0; k < 3; ++k)
        if (corner[k] != e.a && corner[k] != e.b) return k;
    return 0;
}

std::optional<Pair> pair_at(const Surface& surface, const Edge& e) {
    const PolygonMesh& mesh = surface.welded;
    if (e.right == kNone || mesh.polygon_size(e.left) != 3 || mesh.polygon_size(e.right) != 3) return {};
    const Index* left = &mesh.corner_vertex[mesh.polygon_start[e.left]];
    const Index* right = &mesh.corner_vertex[mesh.polygon_start[e.right]];
    const Index k = opposite(mesh, e.left, e);
    Pair out{0.0f,
             0.0f,
             e.left,
             e.right,
             {left[k], left[(k + 1) % 3], right[opposite(mesh, e.right, e)], left[(k + 2) % 3]}};
    std::array<Vec3, 4> at, side;
    for (size_t c = 0; c < 4; ++c) at[c] = surface.positions_rest[out.corner[c]];
    for (size_t c = 0; c < 4; ++c) side[c] = at[(c + 1) % 4] - at[c];
    for (size_t c = 0; c < 4; ++c) {
        const float lengths = glm::length(side[c]) * glm::length(side[(c + 1) % 4]);
        out.skewed = std::max(out.skewed, std::abs(glm::dot(side[c], side[(c + 1) % 4])) / lengths);
    }
    const Vec3 one = glm::cross(side[3], side[0]), other = glm::cross(side[1], side[2]);
    const float flat = glm::dot(one, other) / (glm::length(one) * glm::length(other));
    out.badness = out.skewed + 1.0f - flat;
    if (!(out.skewed <= kSkewed && flat >= kFlat)) return {};  // also without area
    return out;
}

std::vector<Pair> sorted_pairs(const Surface& surface) {
    std::vector<Pair> out;
    for (const Edge& e : surface.edges)
        if (const std::optional<Pair> pair = pair_at(surface, e)) out.push_back(*pair);
    std::ranges::sort(out, {},
                      [](const Pair& pair) { return std::tuple(pair.badness, pair.left, pair.right); });
    return out;
}

void append_polygon(std::span<const Index> corners, PolygonMesh& out) {
    out.corner_vertex.insert(out.corner_vertex.end(), corners.begin(), corners.end());
    out.polygon_start.push_back(out.corners());
}

// ---- subdivision

// What a vertex of the subdivided mesh was made of.
enum class Kind : unsigned char { kUnknown, kVertex, kEdge, kFace };

// Around a quad, from the corner at a vertex of the mesh before.
constexpr std::array kAround{Kind::kVertex, Kind::kEdge, Kind::kFace, Kind::kEdge};

// The kinds of the vertices of a mesh of quads, found part by part. Two quads with a common edge have the
// kinds of its ends in common, and these say the others.
class Kinds {
  public:
    std::vector<Kind> of;  // per vertex

    explicit Kinds(const PolygonMesh& mesh)
        : of(size_t(mesh.vertex_count)),
          mesh_(mesh),
          neighbours_(size_t(mesh.polygons())),
          tried_(size_t(mesh.polygons())),
          uses_(size_t(mesh.vertex_count)),
          on_border_(size_t(mesh.vertex_count)) {
        for (const Index v : mesh.corner_vertex) ++uses_[v];
        for (const Edge& e : collect_edges(mesh)) {
            if (e.right == kNone) {
                on_border_[e.a] = on_border_[e.b] = true;
            } else {
                neighbours_[e.left].push_back(e.right);
                neighbours_[e.right].push_back(e.left);
            }
        }
    }

    // Whether there is an answer for all quads.
    bool find() {
        std::vector<Index> corner_of(of.size(), kNone);
        for (Index c = mesh_.corners(); c-- > 0;) corner_of[mesh_.corner_vertex[c]] = c;
        for (const Index c : corner_of) {
            if (c == kNone || of[mesh_.corner_vertex[c]] != Kind::kUnknown) continue;
            Index turn = 0;
            while (turn < 4 && !find_part(c / 4, c % 4 + turn)) ++turn;
            if (turn == 4) return false;
        }
        return true;
    }

    Index corner(Index quad, Index k) const { return mesh_.corner_vertex[4 * quad + k % 4]; }

    // The corner of a quad at a vertex of the mesh before, as far as kinds are known; kNone: they disagree.
    Index first_corner(Index quad) const {
        for (Index first = 0; first < 4; ++first) {
            bool agrees = true;
            for (Index k = 0; k < 4; ++k) {
                const Kind kind = of[corner(quad, first + k)];
                agrees = agrees && (kind == Kind::kUnknown || kind == kAround[k]);
            }
            if (agrees) return first;
        }
        return kNone;
    }

  private:
    // Gives all vertices that hang together with a quad their kinds, or none.
    bool find_part(Index from, Index first) {
        ++try_;
        std::vector<Index> front, reached;
        bool fits = take(from, first, front, reached);
        while (fits && !front.empty()) {
            const Index quad = front.back();
            front.pop_back();
            for (const Index next : neighbours_[quad]) {
                const Index corner = first_corner(next);
                fits =
                    fits && corner != kNone && (tried_[next] == try_ || take(next, corner, front, reached));
            }
        }
        for (const Index v : reached)
            if (!fits) of[v] = Kind::kUnknown;
        return fits;
    }

    bool take(Index quad, Index first, std::vector<Index>& front, std::vector<Index>& reached) {
        tried_[quad] = try_;
        front.push_back(quad);
        for (Index k = 0; k < 4; ++k) {
            const Index v = corner(quad, first + k);
            if (of[v] == kAround[k]) continue;
            if (of[v] != Kind::kUnknown || !can_be(v, kAround[k])) return false;
            of[v] = kAround[k];
            reached.push_back(v);
        }
        return true;
    }

    // Whether as many quads meet at a vertex as where this kind was made.
    bool can_be(Index v, Kind kind) const {
        if (kind == Kind::kEdge) return uses_[v] == (on_border_[v] ? 2 : 4);
        return kind == Kind::kVertex || (!on_border_[v] && uses_[v] >= 3);
    }

    const PolygonMesh& mesh_;
    std::vector<std::vector<Index>> neighbours_;  // per quad
    std::vector<Index> tried_;                    // per quad: the last try that reached it
    std::vector<Index> uses_;                     // per vertex
    std::vector<bool> on_border_;
    Index try_ = 0;
};

// A quad as the part of its polygon at one corner: seen from the polygon's middle, from one edge to the next.
struct Wedge {
    Index face, from, to, vertex;  // of the subdivided mesh

    auto operator<=>(const Wedge&) const = default;
};

std::vector<Wedge> wedges_of(const PolygonMesh& mesh, const Kinds& kinds) {
    std::vector<Wedge> out;
    for (Index quad = 0; quad < mesh.polygons(); ++quad) {
        const Index first = kinds.first_corner(quad);
        out.push_back({kinds.corner(quad, first + 2), kinds.corner(quad, first + 3),
                       kinds.corner(quad, first + 1), kinds.corner(quad, first)});
    }
    std::ranges::sort(out);
    return out;
}

// Appends the polygon of all wedges around a face. False if they are no single ring.
bool append_ring(std::span<const Wedge> wedges, std::span<const Index> number, PolygonMesh& out) {
    size_t k = 0;
    for (size_t count = 0; count < wedges.size(); ++count) {
        out.corner_vertex.push_back(number[wedges[k].vertex]);
        const auto next = std::ranges::lower_bound(wedges, wedges[k].to, {}, &Wedge::from);
        if (next == wedges.end() || next->from != wedges[k].to) return false;
        k = size_t(next - wedges.begin());
        if (k == 0 && count + 1 < wedges.size()) return false;
    }
    out.polygon_start.push_back(out.corners());
    return k == 0;
}

}  // namespace

MeshBefore without_loose_vertices(PolygonMesh mesh) {
    MeshBefore out;
    std::vector<Index> number(size_t(mesh.vertex_count), kNone);
    for (const Index v : mesh.corner_vertex) number[v] = 0;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        if (number[v] == kNone) continue;
        number[v] = Index(out.vertex.size());
        out.vertex.push_back(v);
    }
    mesh.vertex_count = Index(out.vertex.size());
    for (Index& v : mesh.corner_vertex) v = number[v];
    for (Crease& crease : mesh.creases) crease.a = number[crease.a], crease.b = number[crease.b];
    out.mesh = std::move(mesh);
    return out;
}

std::optional<MeshBefore> joined_triangles(const Surface& surface) {
    const PolygonMesh& mesh = surface.welded;
    const std::vector<Pair> pairs = sorted_pairs(surface);
    std::vector<const Pair*> pair_of(size_t(mesh.polygons()), nullptr);
    Index straight = 0;
    for (const Pair& pair : pairs) {
        if (pair_of[pair.left] || pair_of[pair.right]) continue;
        pair_of[pair.left] = pair_of[pair.right] = &pair;
        straight += 2 * (pair.skewed <= kStraight);
    }
    PolygonMesh joined;
    Index triangles = 0;
    for (Index p = 0; p < mesh.polygons(); ++p) {
        const std::span<const Index> corners(&mesh.corner_vertex[mesh.polygon_start[p]],
                                             size_t(mesh.polygon_size(p)));
        triangles += corners.size() == 3;
        if (!pair_of[p])
            append_polygon(corners, joined);
        else if (pair_of[p]->left == p)
            append_polygon(pair_of[p]->corner, joined);
    }
    if (2 * triangles < mesh.polygons() || straight < kJoined * triangles) return {};
    joined.vertex_count = mesh.vertex_count;
    return without_loose_vertices(std::move(joined));
}

std::optional<MeshBefore> undivided(const PolygonMesh& mesh) {
    for (Index p = 0; p < mesh.polygons(); ++p)
        if (mesh.polygon_size(p) != 4) return {};
    Kinds kinds(mesh);
    if (mesh.polygons() == 0 || !kinds.find()) return {};
    MeshBefore out;
    std::vector<Index> number(kinds.of.size(), kNone);
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        if (kinds.of[v] != Kind::kVertex) continue;
        number[v] = out.mesh.vertex_count++;
        out.vertex.push_back(v);
    }
    const std::vector<Wedge> wedges = wedges_of(mesh, kinds);
    for (auto begin = wedges.begin(); begin != wedges.end();) {
        const auto end = std::ranges::upper_bound(begin, wedges.end(), begin->face, {}, &Wedge::face);
        if (!append_ring({begin, end}, number, out.mesh)) return {};
        begin = end;
    }
    return out;
}

}  // namespace rumple
