// SPDX-License-Identifier: GPL-3.0-or-later
// Conjugate gradients (J. R. Shewchuk 1994, B3), preconditioned by the incomplete factors
// (D + L) D^-1 (D + L)^T of the Hessian. L is the part below its diagonal, and D is such that the product has
// the same diagonal as the Hessian. Along a chain the product is the Hessian itself, so a pull at a hem
// reaches the waist in one sweep. In the variables (D + L)^T x an iteration is one sweep in each direction,
// without a product with the Hessian (S. C. Eisenstat, "Efficient Implementation of a Class of Preconditioned
// Conjugate Gradient Methods", SIAM Journal on Scientific and Statistical Computing 2, 1981).
#include "surface/cloth/hessian.h"

#include <array>
#include <cmath>
#include <utility>

namespace rumple::base_cloth {
namespace {

constexpr double kResidual = 0.05;  // conjugate gradients stop at this share of the force they began with

// x, y, z and a fourth number without meaning, in double precision: in two halves, which SSE2 and NEON
// compute.
struct DoubleRow {
    using Half = double __attribute__((vector_size(16)));
    Half xy{}, zw{};

    DoubleRow() = default;
    DoubleRow(const Half& xy_, const Half& zw_) : xy(xy_), zw(zw_) {}
    DoubleRow(double x_, double y_, double z_) : xy{x_, y_}, zw{z_, 0.0} {}
    double x() const { return xy[0]; }
    double y() const { return xy[1]; }
    double z() const { return zw[0]; }
};
DoubleRow operator+(const DoubleRow& a, const DoubleRow& b) {
    return {a.xy + b.xy, a.zw + b.zw};
}
DoubleRow operator-(const DoubleRow& a, const DoubleRow& b) {
    return {a.xy - b.xy, a.zw - b.zw};
}
DoubleRow operator*(double s, const DoubleRow& a) {
    return {s * a.xy, s * a.zw};
}
double dot(const DoubleRow& a, const DoubleRow& b) {
    return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}
DoubleRow to_double(const Row& row) {
    return {row.xyz[0], row.xyz[1], row.xyz[2]};
}
Row to_row(const DoubleRow& row) {
    return Vec3(static_cast<float>(row.x()), static_cast<float>(row.y()), static_cast<float>(row.z()));
}

struct Block {  // 3 x 3
    DoubleRow column[3];
};
Block operator+(const Block& a, const Block& b) {
    return {{a.column[0] + b.column[0], a.column[1] + b.column[1], a.column[2] + b.column[2]}};
}
Block operator-(const Block& a, const Block& b) {
    return {{a.column[0] - b.column[0], a.column[1] - b.column[1], a.column[2] - b.column[2]}};
}
Block operator*(double s, const Block& m) {
    return {{s * m.column[0], s * m.column[1], s * m.column[2]}};
}
DoubleRow operator*(const Block& m, const DoubleRow& v) {
    return v.x() * m.column[0] + v.y() * m.column[1] + v.z() * m.column[2];
}
Block outer_product(const DoubleRow& a, const DoubleRow& b) {
    return {{b.x() * a, b.y() * a, b.z() * a}};
}
Block to_block(const Matrix& m) {
    return {{to_double(m.column[0]), to_double(m.column[1]), to_double(m.column[2])}};
}
Matrix to_matrix(const Block& m) {
    return {{to_row(m.column[0]), to_row(m.column[1]), to_row(m.column[2])}};
}

Block block_of(const Hessian::Spring& spring) {
    const DoubleRow n = to_double(spring.direction);
    const double across = spring.across;
    const Block identity{{{across, 0.0, 0.0}, {0.0, across, 0.0}, {0.0, 0.0, across}}};
    return identity + double(spring.along) * outer_product(n, n);
}

// B W B for a spring's block B = a I + b n n^T and a symmetric W. With u = W n and
// v = a b u + b^2 (n . u) / 2 n it is a^2 W + n v^T + v n^T.
Block between(const Hessian::Spring& spring, const Block& w) {
    const DoubleRow n = to_double(spring.direction), u = w * n;
    const double a = spring.across, b = spring.along;
    const DoubleRow v = a * b * u + 0.5 * b * b * dot(n, u) * n;
    return a * a * w + outer_product(n, v) + outer_product(v, n);
}

// A vertex without area, in no polygon or in polygons without area, has neither weight nor force, so it does
// not move.
Block inverse_or_nothing(const Block& block) {
    const auto column = [&](int i) {
        const DoubleRow& c = block.column[i];
        return glm::dvec3(c.x(), c.y(), c.z());
    };
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(column(0), column(1), column(2)));
    const glm::dvec3 sum = inverse[0] + inverse[1] + inverse[2];
    Block out;
    for (int i = 0; i < 3 && std::isfinite(sum.x + sum.y + sum.z); ++i)
        out.column[i] = {inverse[i].x, inverse[i].y, inverse[i].z};
    return out;
}

// Four springs of a vertex.
struct SpringLanes {
    std::array<Index, kLanes> other;
    Vec3Lanes direction;
    Lanes along{}, across{};

    // Adds their part at one end if the other ends have `rows`. It adds one spring after the other, so that
    // rounding does not change.
    void add_to(const std::vector<Row>& rows, Row& sum) const {
        const Vec3Lanes v =
            columns(std::array{rows[other[0]], rows[other[1]], rows[other[2]], rows[other[3]]});
        std::array<Row, kLanes> product;
        store_rows(across * v + along * dot(direction, v) * direction, product);
        for (const Row& one : product) sum.xyz += one.xyz;
    }
};

SpringLanes lanes_of(const Model::Sweep::Four& four, const Hessian& hessian) {
    SpringLanes out;
    out.other = four.other;
    std::array<Row, kLanes> direction;
    for (int k = 0; k < kLanes; ++k) {
        const size_t s = size_t(four.spring[k]);
        if (s >= hessian.springs.size()) continue;
        direction[k] = hessian.springs[s].direction;
        out.along[k] = hessian.springs[s].along;
        out.across[k] = hessian.springs[s].across;
    }
    out.direction = columns(direction);
    return out;
}

std::vector<SpringLanes> lanes_of(const std::vector<Model::Sweep::Four>& fours, const Hessian& hessian) {
    std::vector<SpringLanes> out;
    out.reserve(fours.size());
    for (const Model::Sweep::Four& four : fours) out.push_back(lanes_of(four, hessian));
    return out;
}

class Factors {
  public:
    Factors(const Model& model, const Hessian& hessian);

    // Computes (D + L)^-1 of the vector rows(vertex), which is called once per vertex.
    template <typename Rows>
    void forward(const Rows& rows, std::vector<Row>& out) const {
        for (size_t k = 0; k < sweep_.vertex.size(); ++k) {
            const Index v = sweep_.vertex[k];
            Row here = rows(v);
            for (Index f = sweep_.earlier_start[k]; f < sweep_.earlier_start[k + 1]; ++f)
                earlier_[f].add_to(out, here);
            out[v].xyz = inverse_[v] * here;
        }
    }
    // (D + L)^-T rows
    void backward(const std::vector<Row>& rows, std::vector<Row>& out) const {
        for (size_t k = sweep_.vertex.size(); k-- > 0;) {
            const Index v = sweep_.vertex[k];
            Row here = rows[v];
            for (Index f = sweep_.later_start[k]; f < sweep_.later_start[k + 1]; ++f)
                later_[f].add_to(out, here);
            out[v].xyz = inverse_[v] * here;
        }
    }
    // D row, for one vertex
    Row weighed(size_t v, const Row& row) const { return Row(diagonal_[v] * row); }
    // (D + L)^-1 Hessian (D + L)^-T p minus `back`, where `back` is (D + L)^-T p. The Hessian is
    // (D + L) + (D + L)^T plus, on its diagonal, beyond_.
    void multiply(const std::vector<Row>& p, const std::vector<Row>& back, std::vector<Row>& out) const {
        forward([&](Index v) { return Row(p[v].xyz + beyond_[v] * back[v]); }, out);
    }

  private:
    const Model::Sweep& sweep_;
    std::vector<SpringLanes> earlier_, later_;
    std::vector<Matrix> diagonal_, inverse_, beyond_;  // per vertex: D, D^-1, the Hessian's diagonal - 2 D
};

// D is positive definite. The part of a spring that is left at its later end is B - B D^-1 B. It is zero if
// only this spring held the earlier end (D = B), and more if something else held it too. It is a difference,
// so it is computed in double precision.
Factors::Factors(const Model& model, const Hessian& hessian)
    : sweep_(model.sweep),
      earlier_(lanes_of(sweep_.earlier, hessian)),
      later_(lanes_of(sweep_.later, hessian)),
      diagonal_(hessian.diagonal.size()),
      inverse_(hessian.diagonal.size()),
      beyond_(hessian.diagonal.size()) {
    std::vector<Block> whole(hessian.diagonal.size());
    for (size_t v = 0; v < whole.size(); ++v) whole[v] = to_block(hessian.diagonal[v]);
    for (size_t s = 0; s < model.springs.size(); ++s) {
        const Block block = block_of(hessian.springs[s]);
        for (const Index v : {model.springs[s].a, model.springs[s].b}) whole[v] = whole[v] + block;
    }
    std::vector<Block> left = whole;
    for (size_t k = 0; k < model.order.size(); ++k) {
        const Index v = model.order[k];
        const Block inverse = inverse_or_nothing(left[v]);
        for (Index s = model.spring_start[k]; s < model.spring_start[k + 1]; ++s)
            left[model.springs[s].b] = left[model.springs[s].b] - between(hessian.springs[s], inverse);
        diagonal_[v] = to_matrix(left[v]);
        inverse_[v] = to_matrix(inverse);
        beyond_[v] = to_matrix(whole[v] - 2.0 * left[v]);
    }
}

// The sum over the vertices of the inner products of the two rows that rows(vertex) returns. One pass
// computes the rows and multiplies them.
template <typename Rows>
double inner_product_of(size_t count, const Rows& rows) {
    double sum = 0.0;
    for (size_t v = 0; v < count; v += kLanes) {
        std::array<Row, kLanes> product;
        for (int k = 0; k < kLanes; ++k) {
            const auto [a, b] = rows(v + size_t(k));
            product[k].xyz = a.xyz * b.xyz;
        }
        const Vec3Lanes columns_of_four = columns(product);
        const Lanes dots = columns_of_four.x + columns_of_four.y + columns_of_four.z;
        for (int k = 0; k < kLanes; ++k) sum += double(dots[k]);
    }
    return sum;
}

}  // namespace

double inner_product(const std::vector<Row>& a, const std::vector<Row>& b) {
    return inner_product_of(a.size(), [&](size_t v) { return std::pair(a[v], b[v]); });
}

int conjugate_gradients(const Model& model, const Hessian& hessian, const std::vector<Row>& force,
                        int most_iterations, std::vector<Row>& step) {
    const Factors factors(model, hessian);
    const size_t count = force.size();
    std::vector<Row> residual(count), weighed(count), back(count), product(count);
    factors.forward([&](Index v) { return force[v]; }, residual);
    double now = inner_product_of(count, [&](size_t v) {
        weighed[v] = factors.weighed(v, residual[v]);
        return std::pair(residual[v], weighed[v]);
    });
    std::vector<Row> p = weighed;
    const double enough = kResidual * kResidual * now;
    for (int i = 0; i < most_iterations; ++i) {
        if (now <= enough || now <= 0.0) return i;
        factors.backward(p, back);
        factors.multiply(p, back, product);
        const double curvature = inner_product_of(count, [&](size_t v) {
            product[v].xyz += back[v].xyz;
            return std::pair(p[v], product[v]);
        });
        const float alpha = static_cast<float>(now / curvature);
        const double next = inner_product_of(count, [&](size_t v) {
            step[v].xyz += alpha * back[v].xyz;
            residual[v].xyz -= alpha * product[v].xyz;
            weighed[v] = factors.weighed(v, residual[v]);
            return std::pair(residual[v], weighed[v]);
        });
        const float beta = static_cast<float>(next / now);
        for (size_t v = 0; v < count; ++v) p[v].xyz = weighed[v].xyz + beta * p[v].xyz;
        now = next;
    }
    return most_iterations;
}

}  // namespace rumple::base_cloth
