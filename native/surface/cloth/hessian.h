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
    // The block of a spring, B = across I + along n x n, positive semidefinite. B is added to the diagonal
    // blocks of both ends, and -B to the blocks between them.
    struct Spring {
        Row direction;        // n, unit
        float along = 0.0f;   // >= -across
        float across = 0.0f;  // >= 0
    };
    std::vector<Spring> springs;   // in the order of the model's springs
    std::vector<Matrix> diagonal;  // per vertex, without the blocks of springs; positive semidefinite
};

// Solves hessian step = force, starting from step = 0, until the residual is a given share of the force, or
// until the largest number of iterations. Returns the number of iterations. force, step: per vertex. Vertices
// without weight do not move.
int conjugate_gradients(const Model& model, const Hessian& hessian, const std::vector<Row>& force,
                        int most_iterations, std::vector<Row>& step);

double inner_product(const std::vector<Row>& a, const std::vector<Row>& b);

}  // namespace rumple::base_cloth
