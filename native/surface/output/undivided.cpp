// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/output/undivided.h"

#include <algorithm>
#include <array>
#include <compare>

namespace rumple {
namespace {

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
bool append_polygon(std::span<const Wedge> wedges, std::span<const Index> number, PolygonMesh& out) {
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

std::optional<Undivided> undivided(const PolygonMesh& mesh) {
    for (Index p = 0; p < mesh.polygons(); ++p)
        if (mesh.polygon_size(p) != 4) return {};
    Kinds kinds(mesh);
    if (mesh.polygons() == 0 || !kinds.find()) return {};
    Undivided out;
    std::vector<Index> number(kinds.of.size(), kNone);
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        if (kinds.of[v] != Kind::kVertex) continue;
        number[v] = out.mesh.vertex_count++;
        out.vertex.push_back(v);
    }
    const std::vector<Wedge> wedges = wedges_of(mesh, kinds);
    for (auto begin = wedges.begin(); begin != wedges.end();) {
        const auto end = std::ranges::upper_bound(begin, wedges.end(), begin->face, {}, &Wedge::face);
        if (!append_polygon({begin, end}, number, out.mesh)) return {};
        begin = end;
    }
    return out;
}

}  // namespace rumple
