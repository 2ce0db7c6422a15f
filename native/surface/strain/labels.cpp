// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/strain/labels.h"

#define MAXFLOW_INCLUDE_TEMPLATE_IMPLEMENTATION
// After realloc() has moved a block, the library shifts its pointers into the block by the difference of the
// addresses. g++ 14 at -O3 inlines this code here, sees the use of the old address, and warns, although these
// are system headers.
#pragma GCC diagnostic push
#ifndef __clang__  // clang does not know this warning
#pragma GCC diagnostic ignored "-Wuse-after-free"
#endif
#include <maxflow.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>

#include "base/elementary.h"

namespace rumple {
namespace {

constexpr double kSigma = 0.05, kAlpha = 9.0, kBeta = 90.0;  // section 4.1.2

double square(double x) {
    return x * x;
}

double rest_cost(double a, double b) {
    return 1.0 -
           elementary::exp(-square(std::abs(a - 1.0) + std::abs(b - 1.0)) / (2.0 * square(kSigma)));  // (4.4)
}

double dominance_cost(double a, double b) {  // (4.5) in our reading
    const double high = elementary::exp(-kAlpha * (a - 1.0)), low = elementary::exp(-kBeta * (a - 1.0));
    if (a > b) return (high - low) * elementary::exp(-square(a - b) / (4.0 * square(kSigma))) + low;
    return (high < 1.0 ? a / b : b / a) * (high - 1.0) + 1.0;
}

// Capacities are integers, so that the cut is exact in any order of the flow. All costs above kMostCost (a
// triangle that doubles its size within a tenth of a second) are equal.
constexpr double kCapacity = 65536.0;
constexpr double kMostCost = 100.0;
constexpr int kNever = 1 << 28;

int capacity(double cost) {
    return static_cast<int>(std::lround(kCapacity * std::clamp(cost, 0.0, kMostCost)));
}

using Graph = maxflow::Graph<int, int, long long>;

// If it returned, maxflow would end the process.
void no_memory(const char*) {
    throw std::bad_alloc();
}

// Nodes 2 i and 2 i + 1 of triangle i are on the source's side if its label is above compress and above rest.
class LabelGraph {
  public:
    explicit LabelGraph(size_t nodes) : graph_(int(2 * nodes), int(6 * nodes), no_memory) {
        graph_.add_node(int(2 * nodes));
    }

    void add_unary(size_t i, const LabelCosts& cost) {
        const int above_compress = int(2 * i), above_rest = above_compress + 1;
        graph_.add_tweights(above_compress, capacity(cost[kCompress]), 0);
        graph_.add_edge(above_compress, above_rest, capacity(cost[kRest]), kNever);
        graph_.add_tweights(above_rest, 0, capacity(cost[kStretch]));
    }
    void add_pair(size_t i, size_t j) {
        const int step = capacity(kLabelStep);
        for (int level = 0; level < 2; ++level)
            graph_.add_edge(int(2 * i) + level, int(2 * j) + level, step, step);
    }
    Labels solve(size_t nodes) {
        graph_.maxflow();
        const auto above = [&](size_t node) {
            return graph_.what_segment(int(node), Graph::SINK) == Graph::SOURCE;
        };
        Labels labels(nodes);
        for (size_t i = 0; i < nodes; ++i) labels[i] = std::uint8_t(above(2 * i) + above(2 * i + 1));
        return labels;
    }

  private:
    Graph graph_;
};

double step_cost(int a, int b) {
    return kLabelStep * std::abs(a - b);
}

// Calls visit(i, j) for every pair of neighbours in space (within one frame) and in time.
template <typename Visit>
void visit_pairs(const TriangleNet& net, size_t count, Visit&& visit) {
    const size_t triangles = size_t(net.triangles());
    for (size_t frame = 0; frame < count; frame += triangles) {
        for (size_t h = 0; h < net.twin.size(); ++h) {
            if (net.twin[h] != kNone && size_t(net.twin[h]) > h)
                visit(frame + h / 3, frame + size_t(triangle_of(net.twin[h])));
        }
        if (frame == 0) continue;
        for (size_t t = 0; t < triangles; ++t) visit(frame - triangles + t, frame + t);
    }
}

}  // namespace

LabelCosts label_costs(const Stretch& change) {
    if (!change.defined) return {1.0, 0.0, 1.0};
    const double a = change.compression, b = change.stretch;
    return {dominance_cost(a, b), rest_cost(a, b), dominance_cost(b, a)};  // (4.6), (4.4), (4.7)
}

Labels cut_labels(const TriangleNet& net, std::span<const LabelCosts> costs,
                  std::span<const std::uint8_t> before) {
    LabelGraph graph(costs.size());
    for (size_t i = 0; i < costs.size(); ++i) {
        LabelCosts cost = costs[i];
        for (int l = 0; i < before.size() && l < 3; ++l) cost[l] += step_cost(l, before[i]);
        graph.add_unary(i, cost);
    }
    visit_pairs(net, costs.size(), [&](size_t i, size_t j) { graph.add_pair(i, j); });
    return graph.solve(costs.size());
}

Labels cut_clip(const TriangleNet& net, std::span<const LabelCosts> costs, size_t most_in_cut) {
    const size_t triangles = size_t(net.triangles());
    const size_t most = std::max(most_in_cut / triangles, 2 * kFramesAhead) * triangles;
    Labels labels;
    while (labels.size() < costs.size()) {
        const size_t done = labels.size();
        const std::span<const std::uint8_t> before =
            done ? std::span(labels).last(triangles) : std::span<std::uint8_t>();
        const Labels piece =
            cut_labels(net, costs.subspan(done, std::min(most, costs.size() - done)), before);
        const bool last = done + piece.size() == costs.size();
        const size_t kept = last ? piece.size() : piece.size() - kFramesAhead * triangles;
        labels.insert(labels.end(), piece.begin(), piece.begin() + std::ptrdiff_t(kept));
    }
    return labels;
}

Labels cheapest_labels(std::span<const LabelCosts> costs) {
    Labels labels;
    for (const LabelCosts& cost : costs)
        labels.push_back(std::uint8_t(std::min_element(cost.begin(), cost.end()) - cost.begin()));
    return labels;
}

double label_energy(const TriangleNet& net, std::span<const LabelCosts> costs,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> labels) {
    double sum = 0.0;
    for (size_t i = 0; i < costs.size(); ++i) {
        sum += costs[i][labels[i]] + (i < before.size() ? step_cost(labels[i], before[i]) : 0.0);
    }
    visit_pairs(net, costs.size(), [&](size_t i, size_t j) { sum += step_cost(labels[i], labels[j]); });
    return sum;
}

}  // namespace rumple
