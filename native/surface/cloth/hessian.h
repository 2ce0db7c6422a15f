// SPDX-License-Identifier: GPL-3.0-or-later
// The Hessian of the base cloth's energy, made positive definite, and the solve with it. Internal to the base
// cloth.
#pragma once

#include <vector>

#include "base/lanes.h"
#include "surface/cloth/base_cloth.h"

namespace rumple::base_cloth {

struct Matrix {  // 3 x 3
    Row column[3];
};
inline Lanes operator*(const Matrix& m, const Row& v) {
    return m.column[0].xyz * v.xyz[0] + m.column[1].xyz * v.xyz[1] + m.column[2].xyz * v.xyz[2];
}
inline Matrix scaled_identity(float scale) {
    return {{Row(Lanes{scale}), Row(Lanes{0.0f, scale}), Row(Lanes{0.0f, 0.0f, scale})}};
}
inline void add(const Matrix& more, Matrix& m) {
    for (int i = 0; i < 3; ++i) m.column[i].xyz += more.column[i].xyz;
}
// scale times n x n.
inline void add_outer_product(float scale, const Row& n, Matrix& m) {
    for (int i = 0; i < 3; ++i) m.column[i].xyz += scale * (n.xyz * n.xyz[i]);
}

struct Hessian {
    // Of a spring: the block B = across I + along n x n between its ends, positive semidefinite. It stands on
    // the diagonal of both, and with a minus between them.
    struct Spring {
        Row direction;        // n, unit
        float along = 0.0f;   // >= -across
        float across = 0.0f;  // >= 0
    };
    std::vector<Spring> springs;   // as those of the model
    std::vector<Matrix> diagonal;  // per vertex, without what springs add to it; positive semidefinite
};

// Solves hessian step = force, from step 0, until the residual is a share of the force, or for so many
// iterations; returns their number. force, step: per vertex. What has no weight stays.
int conjugate_gradients(const Model& model, const Hessian& hessian, const std::vector<Row>& force,
                        int most_iterations, std::vector<Row>& step);

double inner_product(const std::vector<Row>& a, const std::vector<Row>& b);

}  // namespace rumple::base_cloth
