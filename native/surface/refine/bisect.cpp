// SPDX-License-Identifier: GPL-3.0-or-later
// "Keep applying edge splits until the longest edge falls below a given
// threshold" (section 3 of the paper).
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <string>

#include "base/expect.h"
#include "base/tolerances.h"
#include "surface/refine/split_parts.h"

namespace rumple {
namespace {

// A piece of a base triangle.
struct Piece {
    Index base;
    Index vertex[3];
    Index line[3];          // line[k] is from vertex k to vertex k + 1
    glm::dvec3 weights[3];  // weights of the base triangle's corners, for each vertex
};

// An edge and its adjacent pieces. The second is kNone on a boundary.
struct Line {
    Index a;
    Index b;
    Index piece[2];
};

// Sorted by length, then by creation. A split line leaves an entry with its former length in the queue.
struct Entry {
    double length;
    Index line;

    bool operator<(const Entry& other) const {
        return length < other.length || (length == other.length && line > other.line);
    }
};

// A conforming triangle mesh. The longest edge of the whole mesh is split first, so it is also the longest
// edge of its triangles. This keeps angles bounded (Rivara 1984).
class Bisection {
  public:
    Bisection(const Surface& surface, FineMesh& fine) : surface_(surface), fine_(fine) {
        const std::vector<Index> fine_of = add_base_vertices(surface, fine);
        positions_.resize(fine.mesh.vertex_count);
        for (Index v = 0; v < surface.welded.vertex_count; ++v) {
            if (fine_of[v] != kNone) positions_[fine_of[v]] = glm::dvec3(surface.positions_rest[v]);
        }
        std::map<EdgeKey, Index> line_of;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            add_base_triangle(static_cast<Index>(t), fine_of, line_of);
        }
    }

    void split_until(double longest, Index most_vertices) {
        for (Index line = 0; line < static_cast<Index>(lines_.size()); ++line)
            queue_.push({length(line), line});
        while (!queue_.empty() && queue_.top().length > longest * (1.0 + kLengthSlack)) {
            const Entry entry = queue_.top();
            queue_.pop();
            if (entry.length != length(entry.line)) continue;
            if (fine_.mesh.vertex_count >= most_vertices) {
                throw InvalidInput("longest: edges of at most " + short_text(longest) + " need more than " +
                                   std::to_string(most_vertices) +
                                   " vertices: allow longer edges (for Wrinkle Paths: wider folds)");
            }
            split(entry.line);
        }
    }

    // In the order of base triangles, so that neighbours on the cloth are close in memory.
    void write_triangles() {
        std::stable_sort(pieces_.begin(), pieces_.end(),
                         [](const Piece& x, const Piece& y) { return x.base < y.base; });
        FineTriangles triangles(surface_, fine_);
        for (const Piece& piece : pieces_) triangles.add(piece.base, piece.vertex, piece.weights);
    }

  private:
    double length(Index line) const {
        return glm::length(positions_[lines_[line].a] - positions_[lines_[line].b]);
    }

    void add_base_triangle(Index t, const std::vector<Index>& fine_of, std::map<EdgeKey, Index>& line_of) {
        const Triangle& triangle = surface_.triangles[t];
        Piece piece{t, {}, {}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        const Index self = static_cast<Index>(pieces_.size());
        for (int k = 0; k < 3; ++k) {
            piece.vertex[k] = fine_of[surface_.welded.corner_vertex[triangle.corner[k]]];
            const EdgeKey key = edge_key(surface_, triangle, k);
            const auto [found, fresh] = line_of.try_emplace(key, static_cast<Index>(lines_.size()));
            if (fresh) lines_.push_back({fine_of[key.a], fine_of[key.b], {kNone, kNone}});
            Line& line = lines_[found->second];
            line.piece[fresh ? 0 : 1] = self;
            piece.line[k] = found->second;
        }
        pieces_.push_back(piece);
    }

    // Line a-b becomes a-m, with a new line m-b. The adjacent pieces are split by new lines too.
    void split(Index line) {
        const Line whole = lines_[line];
        const Index middle = add_middle(line);
        const Index rest = static_cast<Index>(lines_.size());
        lines_[line].b = middle;
        lines_.push_back({middle, whole.b, {kNone, kNone}});
        for (int side = 0; side < 2; ++side) {
            if (whole.piece[side] == kNone) continue;
            lines_[rest].piece[side] = bisect(whole.piece[side], line, rest, middle);
        }
        queue_.push({length(line), line});
        for (Index l = rest; l < static_cast<Index>(lines_.size()); ++l) queue_.push({length(l), l});
    }

    // Adds a vertex in the middle of the line, with weights from the first adjacent piece.
    Index add_middle(Index line) {
        const Piece& piece = pieces_[lines_[line].piece[0]];
        const int k = side_of(piece, line);
        Index column[3];
        for (int c = 0; c < 3; ++c) {
            column[c] = surface_.welded.corner_vertex[surface_.triangles[piece.base].corner[c]];
        }
        add_row(fine_.vertex_from_parent, column, 0.5 * (piece.weights[k] + piece.weights[(k + 1) % 3]));
        positions_.push_back(0.5 * (positions_[lines_[line].a] + positions_[lines_[line].b]));
        return fine_.mesh.vertex_count++;
    }

    static int side_of(const Piece& piece, Index line) {
        return piece.line[0] == line ? 0 : piece.line[1] == line ? 1 : 2;
    }

    // Cuts the piece from the middle of its side k (from p to q) to the opposite vertex o. The piece keeps
    // one half, a new piece gets the other one. Returns the piece with the end b of the line, which is
    // adjacent to `rest`.
    Index bisect(Index index, Index line, Index rest, Index middle) {
        const Piece whole = pieces_[index];
        const int p = side_of(whole, line), q = (p + 1) % 3, o = (p + 2) % 3;
        const glm::dvec3 weights = 0.5 * (whole.weights[p] + whole.weights[q]);
        const Index twin = static_cast<Index>(pieces_.size());
        const Index cut = static_cast<Index>(lines_.size());
        const bool forward = whole.vertex[p] == lines_[line].a;  // the line is from p to q
        lines_.push_back({middle, whole.vertex[o], {index, twin}});

        Piece at_p = whole, at_q = whole;
        at_p.vertex[q] = middle;
        at_p.weights[q] = weights;
        at_p.line[p] = forward ? line : rest;
        at_p.line[q] = cut;
        at_q.vertex[p] = middle;
        at_q.weights[p] = weights;
        at_q.line[p] = forward ? rest : line;
        at_q.line[o] = cut;
        // The half at the line's end a keeps its index, so that `line` need not be changed.
        pieces_[index] = forward ? at_p : at_q;
        pieces_.push_back(forward ? at_q : at_p);
        const Index outer = forward ? whole.line[q] : whole.line[o];  // the side that now belongs to the twin
        std::replace(lines_[outer].piece, lines_[outer].piece + 2, index, twin);
        return twin;
    }

    const Surface& surface_;
    FineMesh& fine_;
    std::vector<Piece> pieces_;
    std::vector<Line> lines_;
    std::vector<glm::dvec3> positions_;  // of fine vertices
    std::priority_queue<Entry> queue_;
};

}  // namespace

FineMesh refine_longest_edge(const Surface& surface, float longest, Index most_vertices) {
    if (!(longest > 0.0f) || !std::isfinite(longest)) {
        throw InvalidInput("longest: expected a length above 0, got " + short_text(longest));
    }
    FineMesh fine;
    Bisection bisection(surface, fine);
    bisection.split_until(longest, most_vertices);
    bisection.write_triangles();
    return fine;
}

}  // namespace rumple
