// SPDX-License-Identifier: GPL-3.0-or-later
// Layers on a coarse mesh, shown on the base mesh.
#include "api/coarse.h"
#include "api/sound.h"
#include "api/wrinkle_layers.h"
#include "systems/wrinkle_mesh/transfer.h"

using namespace rumple;
using namespace rumple::api;
using namespace rumple::wrinkle_mesh;

struct rumple_wrinkle_transfer {
    std::shared_ptr<const Transfer> model;
    ShownMeshes shown;
    std::shared_ptr<const CoarseMesh> coarse;
    std::shared_ptr<const Layers> layers;
};

rumple_wrinkle_transfer_plan rumple_wrinkle_transfer_plan_default(void) {
    return {0, 0, 0, FineSource{}.most_vertices};
}

rumple_status rumple_wrinkle_transfer_build(const rumple_surface* base, const rumple_coarse* coarse,
                                            const rumple_wrinkle_layers* layers,
                                            const rumple_wrinkle_transfer_plan* plan,
                                            rumple_wrinkle_transfer** model) {
    return made(model, "model", [&] {
        const rumple_surface& whole = given(base, "base");
        const rumple_coarse& over = given(coarse, "coarse");
        const rumple_wrinkle_layers& solved = given(layers, "layers");
        const rumple_wrinkle_transfer_plan& from = given(plan, "plan");
        if (over.base != whole.shared) throw InvalidInput("coarse: it was made for another mesh");
        if (solved.base.get() != &over.mesh->surface)
            throw InvalidInput("layers: they were built over another mesh");
        auto built = build_transfer(whole.surface, *over.mesh, *solved.model, from.level, from.display_steps,
                                    from.most_vertices, from.viewport_steps);
        ShownMeshes shown(*built);
        return new rumple_wrinkle_transfer{std::move(built), std::move(shown), over.mesh, solved.model};
    });
}

void rumple_wrinkle_transfer_free(rumple_wrinkle_transfer* model) {
    delete model;
}

const rumple_shown_mesh* rumple_wrinkle_transfer_shown(const rumple_wrinkle_transfer* model,
                                                       bool in_viewport) {
    return model ? model->shown.in(in_viewport) : nullptr;
}

rumple_status rumple_wrinkle_transfer_show(const rumple_wrinkle_transfer* model, const float* animated,
                                           size_t animated_count, const rumple_wrinkle_layers_state* state,
                                           bool in_viewport, rumple_frame** frame) {
    return made(frame, "frame", [&] {
        const rumple_wrinkle_transfer& m = given(model, "model");
        if (given(state, "state").model != m.layers)
            throw InvalidInput("state: it was made for another model");
        Picture picture;
        show(*m.model, *m.coarse, *m.layers, vectors(animated, animated_count, "animated"), state->state,
             picture, in_viewport);
        return new_frame(m.model, sound(std::move(picture)), in_viewport);
    });
}
