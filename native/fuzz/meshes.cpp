// SPDX-License-Identifier: GPL-3.0-or-later
#include "meshes.h"

#include <algorithm>
#include <cmath>

namespace rumple::fuzz {
namespace {

using Face = std::vector<std::int32_t>;

void add_face(Mesh& mesh, const Face& face) {
    mesh.corner.insert(mesh.corner.end(), face.begin(), face.end());
    mesh.start.push_back(std::int32_t(mesh.corner.size()));
}

// columns x rows quads, or twice as many triangles. rolled: the last column is sewn to the first.
void add_sheet(Mesh& mesh, int columns, int rows, bool triangles, bool rolled, float z) {
    const auto first = std::int32_t(mesh.positions.size() / 3);
    const int across = rolled ? columns : columns + 1;
    for (int r = 0; r <= rows; ++r) {
        for (int c = 0; c < across; ++c) {
            const float angle = 6.2831853f * float(c) / float(columns);
            const float x = rolled ? std::cos(angle) : float(c) * 0.3f;
            mesh.positions.insert(mesh.positions.end(),
                                  {x, float(r) * 0.3f, rolled ? std::sin(angle) : z * float(c % 2)});
        }
    }
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
            const int next = (c + 1) % across;
            const std::int32_t a = first + r * across + c, b = first + r * across + next,
                               d = first + (r + 1) * across + c, e = first + (r + 1) * across + next;
            if (triangles) {
                add_face(mesh, {a, b, e});
                add_face(mesh, {a, e, d});
            } else {
                add_face(mesh, {a, b, e, d});
            }
        }
    }
}

void add_box(Mesh& mesh) {
    for (int v = 0; v < 8; ++v)
        mesh.positions.insert(mesh.positions.end(), {float(v & 1), float(v >> 1 & 1), float(v >> 2 & 1)});
    for (const Face& face : {Face{0, 2, 3, 1}, Face{4, 5, 7, 6}, Face{0, 1, 5, 4}, Face{2, 6, 7, 3},
                             Face{0, 4, 6, 2}, Face{1, 3, 7, 5}})
        add_face(mesh, face);
}

void add_fan(Mesh& mesh, int sides) {
    Face face;
    for (int k = 0; k < sides; ++k) {
        const float angle = 6.2831853f * float(k) / float(sides);
        mesh.positions.insert(mesh.positions.end(), {std::cos(angle), std::sin(angle), 0.0f});
        face.push_back(k);
    }
    add_face(mesh, face);
}

// Two sheets side by side, with coincident borders.
void add_seam(Mesh& mesh, int size) {
    add_sheet(mesh, 2, size, false, false, 0.1f);
    const size_t half = mesh.positions.size() / 3;
    add_sheet(mesh, 2, size, false, false, 0.1f);
    for (size_t v = half; v < 2 * half; ++v) mesh.positions[3 * v] += 0.6f;
}

void break_faces(Mesh& mesh, Bytes& bytes) {
    const int faces = int(mesh.start.size()) - 1, vertices = int(mesh.positions.size() / 3);
    const int face = bytes.below(faces);
    const auto begin = mesh.corner.begin() + mesh.start[size_t(face)],
               end = mesh.corner.begin() + mesh.start[size_t(face) + 1];
    switch (bytes.below(6)) {
        case 0:
            std::reverse(begin, end);
            break;
        case 1:
            add_face(mesh, Face(begin, end));
            break;
        case 2:
            *begin = bytes.whole(0, vertices - 1);
            break;
        case 3:
            add_face(mesh, {*begin, *(begin + 1), bytes.below(vertices)});
            break;
        case 4:
            mesh.positions.insert(mesh.positions.end(), {1.0f, 2.0f, 3.0f});
            break;
        case 5:
            mesh.start[size_t(face)] = bytes.whole(0, int(mesh.corner.size()));
            break;
    }
}

void fill_with_triangles(Mesh& mesh) {
    for (size_t p = 0; p + 1 < mesh.start.size(); ++p) {
        for (std::int64_t c = std::int64_t(mesh.start[p]) + 1;
             c + 1 < mesh.start[p + 1] && mesh.triangle.size() < 6000; ++c)
            mesh.triangle.insert(mesh.triangle.end(), {mesh.start[p], std::int32_t(c), std::int32_t(c + 1)});
    }
}

float scale(Bytes& bytes) {
    constexpr float kScales[] = {1.0f, 1.0f, 1.0f, 0.01f, 100.0f, 1e-6f, 1e5f, 1e-20f, 1e12f, 1e-38f};
    return kScales[bytes.below(std::size(kScales))];
}

}  // namespace

Mesh mesh(Bytes& bytes) {
    Mesh out;
    const int kind = bytes.below(8), size = 1 + bytes.below(4), width = 1 + bytes.below(4);
    switch (kind) {
        case 0:
        case 1:
            add_sheet(out, width, size, kind == 1, false, 0.0f);
            break;
        case 2:
        case 3:
            add_sheet(out, width + 3, size, kind == 3, true, 0.0f);
            break;
        case 4:
            add_box(out);
            break;
        case 5:
            add_fan(out, size + 2);
            break;
        case 6:
            add_seam(out, size);
            break;
        case 7:
            add_sheet(out, width, size, false, false, 0.2f);
            add_sheet(out, width, size, true, false, 0.3f);
            break;
    }
    const float by = scale(bytes);
    for (float& x : out.positions) x *= by;
    for (int moved = bytes.below(4); moved > 0; --moved) {
        const int number = bytes.below(int(out.positions.size()));
        out.positions[size_t(number)] = by * bytes.real(-2.0f, 2.0f);
    }
    if (bytes.byte() >= 200) break_faces(out, bytes);
    fill_with_triangles(out);
    if (bytes.hostile() && !out.triangle.empty())
        out.triangle[size_t(bytes.below(int(out.triangle.size())))] = bytes.whole(0, 8);
    if (bytes.hostile()) out.triangle.resize(out.triangle.size() / 6 * 3);
    return out;
}

std::vector<float> pose_of(const std::vector<float>& rest, Bytes& bytes) {
    std::vector<float> out = rest;
    const float x = 0.3f + 0.1f * float(bytes.below(10)), y = 0.5f + 0.1f * float(bytes.below(8)),
                bend = 0.2f * float(bytes.below(6)), shift = float(bytes.below(3));
    for (size_t v = 0; v + 2 < out.size(); v += 3) {
        out[v + 2] += bend * std::sin(3.0f * rest[v]) * std::abs(rest[v]);
        out[v] = rest[v] * x + shift;
        out[v + 1] *= y;
    }
    for (int astray = bytes.below(3); astray > 0 && !out.empty(); --astray)
        out[size_t(bytes.below(int(out.size())))] = bytes.real(-3.0f, 3.0f);
    constexpr float kWild[] = {0.0f, 1e3f, 1e7f, 1e14f, 1e-15f};
    if (const int scaled = bytes.byte(); scaled >= 220) {
        for (float& value : out) value *= kWild[scaled % std::size(kWild)];
    }
    return out;
}

std::vector<float> values(size_t count, float low, float high, Bytes& bytes) {
    std::vector<float> out(count, low + 0.7f * (high - low));
    for (int changed = bytes.below(5); changed > 0 && count > 0; --changed)
        out[size_t(bytes.byte() * 7) % count] = bytes.real(low, high);
    return out;
}

}  // namespace rumple::fuzz
