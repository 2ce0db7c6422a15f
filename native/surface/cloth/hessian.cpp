// SPDX-License-Identifier: GPL-3.0-or-later
// Conjugate gradients (J. R. Shewchuk 1994, B3), preconditioned by the incomplete factors
// (D + L) D^-1 (D + L)^T of the Hessian: L is what is below its diagonal, and D such that the product has its
// diagonal. Along a chain that is the Hessian itself, so what pulls at a hem is felt at the waist in one
// sweep. In the variables (D + L)^T x a gradient is one sweep each way, and no product with the Hessian
// (S. C. Eisenstat, "Efficient Implementation of a Class of Preconditioned Conjugate Gradient Methods", SIAM
// Journal on Scientific and Statistical Computing 2, 1981).
#include "surface/cloth/hessian.h"

#include <cmath>

namespace rumple::base_cloth {
namespace {

constexpr double kResidual = 0.05;  // conjugate gradients stop at this share of the force they began with

using Block = glm::dmat3;

Block to_block(const Matrix& m) {
    return Block(glm::dvec3(m.column[0].vec()), glm::dvec3(m.column[1].vec()), glm::dvec3(m.column[2].vec()));
}
Matrix to_matrix(const Block& m) {
    return {{Vec3(m[0]), Vec3(m[1]), Vec3(m[2])}};
}

Block block_of(const Hessian::Spring& spring) {
    const glm::dvec3 n(spring.direction.vec());
    return double(spring.across) * Block(1.0) + double(spring.along) * glm::outerProduct(n, n);
}

// B W B of a spring's block B = a I + b n n^T and a symmetric W: with u = W n and v = a b u + b^2 (n . u) / 2
// n it is a^2 W + n v^T + v n^T.
Block between(const Hessian::Spring& spring, const Block& w) {
    const glm::dvec3 n(spring.direction.vec()), u = w * n;
    const double a = spring.across, b = spring.along;
    const glm::dvec3 v = a * b * u + 0.5 * b * b * glm::dot(n, u) * n;
    return a * a * w + glm::outerProduct(n, v) + glm::outerProduct(v, n);
}

// A vertex without area, of no polygon or of flat ones, has neither weight nor force: it stays.
Block inverse_or_nothing(const Block& block) {
    const Block inverse = glm::inverse(block);
    const glm::dvec3 sum = inverse[0] + inverse[1] + inverse[2];
    return std::isfinite(sum.x + sum.y + sum.z) ? inverse : Block(0.0);
}

class Factors {
  public:
    Factors(const Model& model, const Hessian& hessian);

    // (D + L)^-1 rows
    void forward(std::vector<Row>& rows) const {
        for (size_t k = 0; k < model_.order.size(); ++k) {
            Row& here = rows[model_.order[k]];
            here.xyz = inverse_[k] * here;
            for_springs(k, [&](Index other, const Hessian::Spring& spring) {
                rows[other].xyz += times(spring, here);
            });
        }
    }
    // (D + L)^-T rows
    void backward(std::vector<Row>& rows) const {
        for (size_t k = model_.order.size(); k-- > 0;) {
            Row& here = rows[model_.order[k]];
            for_springs(k, [&](Index other, const Hessian::Spring& spring) {
                here.xyz += times(spring, rows[other]);
            });
            here.xyz = inverse_[k] * here;
        }
    }
    // D rows
    void weigh(const std::vector<Row>& rows, std::vector<Row>& out) const {
        for (size_t k = 0; k < model_.order.size(); ++k)
            out[model_.order[k]].xyz = diagonal_[k] * rows[model_.order[k]];
    }
    // (D + L)^-1 Hessian (D + L)^-T p, where `back` is (D + L)^-T p: the Hessian is (D + L) + (D + L)^T and,
    // on its diagonal, what is beyond 2 D.
    void multiply(const std::vector<Row>& p, const std::vector<Row>& back, std::vector<Row>& out) const {
        for (size_t k = 0; k < model_.order.size(); ++k) {
            const Index v = model_.order[k];
            out[v].xyz = p[v].xyz + beyond_[k] * back[v];
        }
        forward(out);
        for (size_t v = 0; v < out.size(); ++v) out[v].xyz += back[v].xyz;
    }

  private:
    // The springs from a place of the order to later ones.
    template <typename Act>
    void for_springs(size_t k, Act&& act) const {
        for (Index s = model_.spring_start[k]; s < model_.spring_start[k + 1]; ++s)
            act(model_.springs[s].b, hessian_.springs[s]);
    }
    static Lanes times(const Hessian::Spring& spring, const Row& v) {
        return spring.across * v.xyz + spring.along * dot(spring.direction, v) * spring.direction.xyz;
    }

    const Model& model_;
    const Hessian& hessian_;
    std::vector<Matrix> diagonal_, inverse_, beyond_;  // D, D^-1, the Hessian's diagonal less 2 D, in order
};

// D is positive definite: what is left of a spring at its later end, B - B D^-1 B, is none where it was all
// that held the earlier one (D = B), and more where something else did. In double precision, as it is a
// difference.
Factors::Factors(const Model& model, const Hessian& hessian) : model_(model), hessian_(hessian) {
    std::vector<Block> whole(hessian.own.size());
    for (size_t v = 0; v < whole.size(); ++v) whole[v] = to_block(hessian.own[v]);
    for (size_t s = 0; s < model.springs.size(); ++s) {
        const Block block = block_of(hessian.springs[s]);
        whole[model.springs[s].a] += block;
        whole[model.springs[s].b] += block;
    }
    std::vector<Block> left = whole;
    for (std::vector<Matrix>* made : {&diagonal_, &inverse_, &beyond_}) made->reserve(model.order.size());
    for (size_t k = 0; k < model.order.size(); ++k) {
        const Index v = model.order[k];
        const Block inverse = inverse_or_nothing(left[v]);
        for_springs(
            k, [&](Index other, const Hessian::Spring& spring) { left[other] -= between(spring, inverse); });
        diagonal_.push_back(to_matrix(left[v]));
        inverse_.push_back(to_matrix(inverse));
        beyond_.push_back(to_matrix(whole[v] - 2.0 * left[v]));
    }
}

}  // namespace

double inner_product(const std::vector<Row>& a, const std::vector<Row>& b) {
    double sum = 0.0;
    for (size_t v = 0; v < a.size(); v += kLanes) {
        std::array<Row, kLanes> product;
        for (int k = 0; k < kLanes; ++k) product[k].xyz = a[v + k].xyz * b[v + k].xyz;
        const Vec3Lanes columns_of_four = columns(product);
        const Lanes dots = columns_of_four.x + columns_of_four.y + columns_of_four.z;
        for (int k = 0; k < kLanes; ++k) sum += double(dots[k]);
    }
    return sum;
}

int conjugate_gradients(const Model& model, const Hessian& hessian, const std::vector<Row>& force,
                        int most_gradients, std::vector<Row>& step) {
    const Factors factors(model, hessian);
    std::vector<Row> residual = force, weighed(force.size()), product(force.size());
    factors.forward(residual);
    factors.weigh(residual, weighed);
    std::vector<Row> p = weighed, back(force.size());
    double now = inner_product(residual, weighed);
    const double enough = kResidual * kResidual * now;
    for (int i = 0; i < most_gradients; ++i) {
        if (now <= enough || now <= 0.0) return i;
        back = p;
        factors.backward(back);
        factors.multiply(p, back, product);
        const float alpha = static_cast<float>(now / inner_product(p, product));
        for (size_t v = 0; v < p.size(); ++v) {
            step[v].xyz += alpha * back[v].xyz;
            residual[v].xyz -= alpha * product[v].xyz;
        }
        factors.weigh(residual, weighed);
        const double next = inner_product(residual, weighed);
        const float beta = static_cast<float>(next / now);
        for (size_t v = 0; v < p.size(); ++v) p[v].xyz = weighed[v].xyz + beta * p[v].xyz;
        now = next;
    }
    return most_gradients;
}

}  // namespace rumple::base_cloth
