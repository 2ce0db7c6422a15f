// SPDX-License-Identifier: GPL-3.0-or-later
// The handles that an input has made so far, and the operations on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bytes.h"
#include "calls.h"
#include "meshes.h"

namespace rumple::fuzz {

// The fuzzer's own data about the mesh of a handle.
struct Base {
    std::vector<float> rest;  // (n, 3)
    std::int32_t vertices = 0, welded = 0, triangles = 0, corners = 0, polygons = 0;
};

template <typename T>
struct Entry {
    T* handle = nullptr;
    std::shared_ptr<const Base> base;
    int id = 0;     // of this entry
    int model = 0;  // id of its model; for a model, its own id
    int number = 0;
};

// Some handles of one kind. If there are too many, the oldest is freed, although others may still use its
// data.
template <typename T>
class Pool {
  public:
    using Free = void (*)(T*);
    explicit Pool(Free free) : free_(free) {}
    Pool(const Pool&) = delete;
    ~Pool() {
        for (const Entry<T>& entry : entries_) free_(entry.handle);
    }

    // A NULL handle is not kept. Returns the entry, or NULL.
    const Entry<T>* add(T* handle, std::shared_ptr<const Base> base, int model, int number = 0) {
        if (!handle) return nullptr;
        if (entries_.size() == 5) drop(0);
        static int ids = 0;
        ++ids;
        entries_.push_back({handle, std::move(base), ids, model == 0 ? -ids : model, number});
        return &entries_.back();
    }
    bool empty() const { return entries_.empty(); }
    // One of the entries. Without entries, and sometimes at random, an entry without a handle.
    Entry<T> pick(Bytes& bytes) const {
        if (entries_.empty() || bytes.byte() >= 252) return {};
        return entries_[size_t(bytes.below(int(entries_.size())))];
    }
    // An entry that was made for a model. Mostly for the given one, sometimes for any.
    Entry<T> pick_of(int model, Bytes& bytes) const {
        return bytes.byte() >= 240 ? pick(bytes) : newest_of(model);
    }
    Entry<T> newest_of(int model) const {
        for (size_t i = entries_.size(); i-- > 0;) {
            if (entries_[i].model == model) return entries_[i];
        }
        return {};
    }
    void free_one(Bytes& bytes) {
        if (!entries_.empty()) drop(size_t(bytes.below(int(entries_.size()))));
    }

  private:
    void drop(size_t at) {
        free_(entries_[at].handle);
        entries_.erase(entries_.begin() + std::ptrdiff_t(at));
    }

    Free free_;
    std::vector<Entry<T>> entries_;
};

#define RUMPLE_POOL(type, name)                        \
    Pool<type> name {                                  \
        [](type* handle) { RUN(type##_free, handle); } \
    }

struct World {
    RUMPLE_POOL(rumple_surface, surfaces);
    RUMPLE_POOL(rumple_healed, healed);
    RUMPLE_POOL(rumple_coarse, coarses);
    RUMPLE_POOL(rumple_frame, frames);
    RUMPLE_POOL(rumple_collider, colliders);
    RUMPLE_POOL(rumple_base_cloth, cloths);
    RUMPLE_POOL(rumple_base_cloth_paint, cloth_paints);
    RUMPLE_POOL(rumple_base_cloth_state, cloth_states);
    RUMPLE_POOL(rumple_cloth_cover, covers);
    RUMPLE_POOL(rumple_wrinkle_mesh, meshes);
    RUMPLE_POOL(rumple_wrinkle_mesh_paint, mesh_paints);
    RUMPLE_POOL(rumple_wrinkle_mesh_pose, mesh_poses);
    RUMPLE_POOL(rumple_wrinkle_mesh_state, mesh_states);
    RUMPLE_POOL(rumple_wrinkle_layers, layers);
    RUMPLE_POOL(rumple_wrinkle_layers_paint, layers_paints);
    RUMPLE_POOL(rumple_wrinkle_layers_state, layers_states);
    RUMPLE_POOL(rumple_wrinkle_transfer, transfers);
    RUMPLE_POOL(rumple_wrinkle_field, fields);
    RUMPLE_POOL(rumple_wrinkle_field_paint, field_paints);
    RUMPLE_POOL(rumple_wrinkle_field_pose, field_poses);
    RUMPLE_POOL(rumple_wrinkle_field_state, field_states);
    RUMPLE_POOL(rumple_waves, waves);
    RUMPLE_POOL(rumple_canvas, canvases);
    RUMPLE_POOL(rumple_twins, twins);
    RUMPLE_POOL(rumple_lines, lines);
    RUMPLE_POOL(rumple_wrinkle_paths, paths);
    RUMPLE_POOL(rumple_wrinkle_paths_paint, paths_paints);
    RUMPLE_POOL(rumple_wrinkle_paths_pose, paths_poses);
    RUMPLE_POOL(rumple_wrinkle_paths_state, paths_states);
    RUMPLE_POOL(rumple_curves, curves);
    RUMPLE_POOL(rumple_drawing, drawings);
    RUMPLE_POOL(rumple_wrinkle_maps, maps);
};

// Frees a handle of one of these pools.
template <typename... Pools>
void free_one_of(Bytes& bytes, Pools&... pools) {
    int left = bytes.below(sizeof...(pools));
    ((left-- == 0 ? pools.free_one(bytes) : void()), ...);
}

// An array of the caller, sometimes with a wrong count or without a pointer.
template <typename T>
struct Argument {
    std::vector<T> data;
    const T* pointer;
    size_t count;

    Argument(std::vector<T> values, size_t columns, Bytes& bytes) : data(std::move(values)) {
        count = data.size() / columns;
        data.resize(data.size() + columns);
        pointer = data.data();
        if (!bytes.hostile()) return;
        switch (bytes.below(4)) {
            case 0:
                ++count;
                break;
            case 1:
                count = count > 0 ? count - 1 : 0;
                break;
            case 2:
                pointer = nullptr;
                break;
            case 3:
                count = size_t(-1);
                break;
        }
    }
};
using Floats = Argument<float>;
using Numbers = Argument<std::int32_t>;

// The output array of a call with a number of rows. Sometimes one row less is asked for.
struct Written {
    std::vector<float> data;
    size_t count;

    Written(size_t rows, size_t columns, Bytes& bytes) : data(rows * columns + 1, 0.25f), count(rows) {
        if (bytes.hostile() && count > 0) --count;
    }
    float* pointer() { return data.data(); }
    // After a call: checks the output. If the call was refused, nothing may be written.
    void check(rumple_status status, const char* name) const {
        if (status == RUMPLE_OK) {
            expect_finite(name, data.data(), data.size() - 1);
        } else {
            for (const float value : data) require(value == 0.25f, "written by a call that failed", name);
        }
    }
};

// Checks that handles of other models are refused. handles: the arguments besides the model.
template <typename... Handles>
void expect_of_model(rumple_status status, int model, const char* name, const Handles&... handles) {
    const bool fits = ((!handles.handle || handles.model == model) && ...);
    require(fits || status == RUMPLE_INVALID, "took what was made for another model", name);
}

// The time of the next frame, s. It starts at 0 in every input.
extern double next_time;

// A frame of a base.
struct Posed {
    std::vector<float> positions, next;
    std::vector<std::uint8_t> labels;
    rumple_pose pose;

    Posed(const Base& base, Bytes& bytes);
};
// A clip of a base whose labels are computed.
struct Clip {
    Argument<double> times;
    Floats positions;
    mutable std::vector<std::uint8_t> labels;

    Clip(const Base& base, Bytes& bytes);
    std::uint8_t* out() const { return labels.data(); }
    void check(rumple_status status) const;
};
void vary(rumple_reference_settings& settings, Bytes& bytes);
rumple_fine_plan fine_plan(rumple_fine_plan plan, Bytes& bytes);

void check_shown(const rumple_shown_mesh* shown, Bytes& bytes);
void add_frame(World& world, rumple_frame* frame, const std::shared_ptr<const Base>& base, int model);
void check_mesh_state(const rumple_wrinkle_mesh_state_view& view);
void check_reference(const rumple_reference_view& view);
rumple_wrinkle_mesh_settings mesh_settings(Bytes& bytes);
rumple_wrinkle_mesh_painted mesh_painted(const Base& base, std::vector<std::vector<float>>& keep,
                                         Bytes& bytes);
// A collider with its positions in this pose. keep: owns the positions.
rumple_bodies bodies(const World& world, std::vector<float>& keep, Bytes& bytes);

using Operation = void (*)(World&, Bytes&);
extern const std::vector<Operation> kSurface, kCloth, kMesh, kLayers, kField, kBrush, kPaths, kMaps;

}  // namespace rumple::fuzz
