// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/reference.h"

namespace rumple::bindings {

py::array stored_array(const py::dict& from, const char* name) {
    if (!from.contains(name))
        throw InvalidInput(std::string("state: expected an array ") + name + ", got none");
    return py::cast<py::array>(from[name]);
}

py::dict reference_arrays(const ReferenceState& state) {
    py::dict out;
    out["time"] = state.time;
    out["labels"] = to_numpy<std::uint8_t>(state.labels, 0);
    out["reference"] = to_numpy<float>(state.reference, 3);
    out["past_times"] = to_numpy<double>(state.past_times, 0);
    out["past_positions"] = to_numpy(state.past_positions);
    return out;
}

ReferenceState reference_from(const py::dict& from) {
    ReferenceState state;
    if (!from.contains("time")) throw InvalidInput("state: expected time, got none");
    state.time = py::cast<double>(from["time"]);
    const auto labels = scalars<std::uint8_t>(stored_array(from, "labels"), "labels", 0);
    const auto reference = vectors(stored_array(from, "reference"), "reference");
    const auto times = scalars<double>(stored_array(from, "past_times"), "past_times", 0);
    const auto past = vectors(stored_array(from, "past_positions"), "past_positions");
    state.labels.assign(labels.begin(), labels.end());
    for (const Vec3& r : reference) state.reference.push_back({r.x, r.y, r.z});
    state.past_times.assign(times.begin(), times.end());
    state.past_positions.assign(past.begin(), past.end());
    return state;
}

py::object reference_or_none(const ReferenceState& state) {
    if (state.empty()) return py::none();
    return reference_arrays(state);
}

ReferenceState reference_or_empty(const std::optional<py::dict>& from) {
    return from ? reference_from(*from) : ReferenceState{};
}

Moment make_moment(double time, const std::optional<py::array>& labels,
                   const std::optional<py::array>& next_positions, double next_time) {
    Moment moment;
    moment.time = time;
    if (labels) moment.labels = scalars<std::uint8_t>(*labels, "labels", 0);
    if (next_positions) moment.next_positions = vectors(*next_positions, "next_positions");
    moment.next_time = next_time;
    return moment;
}

py::array clip_labels(const Surface& surface, const ReferenceModel& model, const ReferenceSettings& settings,
                      const py::array& times, const py::array& positions, bool raw) {
    const auto seconds = scalars<double>(times, "times", 0);
    const auto flat = vectors(positions, "positions");
    Labels labels;
    {
        const py::gil_scoped_release release;
        labels = label_clip(surface, model, settings, seconds, flat, raw);
    }
    return to_numpy<std::uint8_t>(labels, py::ssize_t(surface.triangles.size()));
}

}  // namespace rumple::bindings
