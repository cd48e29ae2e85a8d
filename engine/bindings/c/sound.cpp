// The functions of the C interface for sound.
#include <cmath>
#include <filesystem>
#include <span>

#include "audio/ar_fit.h"
#include "audio/drill_synth.h"
#include "audio/sound_models.h"
#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/bindings/c/call.h"
#include "engine/bindings/c/typodont_sound.h"

namespace typodont::bindings {

struct SynthObject {
  audio::DrillSynth synth;
};
template <>
struct ObjectOf<typodont_synth> {
  using Type = SynthObject;
  static constexpr Kind kKind = Kind::kSynth;
};

}  // namespace typodont::bindings

using namespace typodont;
using namespace typodont::bindings;

typodont_result typodont_synth_new(const char* voice, double sample_rate, uint64_t seed, typodont_synth** out) {
  return guarded([&] {
    require(voice && out, "NULL for the voice or for the place of the handle");
    require(sample_rate >= 8000 && sample_rate <= 192'000, "sample_rate: expected 8000 to 192000 Hz");
    std::error_code code;
    const bool file = std::filesystem::exists(voice, code);
    const auto models = audio::load_sound_models(file ? std::filesystem::path(voice) : named_asset("sounds", voice));
    *out = make_handle<typodont_synth>(
        std::make_unique<SynthObject>(SynthObject{audio::DrillSynth(models, sample_rate, seed)}));
  });
}

typodont_result typodont_synth_free(typodont_synth* synth) {
  return free_handle(synth);
}

typodont_result typodont_synth_push(typodont_synth* synth, const typodont_sound_state* state) {
  const HandleLock<typodont_synth> held(synth);
  if (!held) return held.why();
  if (!state || !sized(state->struct_size, sizeof *state)) return fail(TYPODONT_BAD_INPUT, kBadSize);
  for (const double v : {state->spindle, state->pedal, state->contact_area, state->force, state->removal_rate,
                         state->slip_speed, state->suction}) {
    if (!std::isfinite(v)) return fail(TYPODONT_BAD_INPUT, "a state with a number that is not finite");
  }
  if (state->tissue >= static_cast<std::uint32_t>(kTissueCount)) return fail(TYPODONT_BAD_INPUT, "no such tissue");
  held->synth.push({.t = state->t_ns,
                    .spindle = state->spindle,
                    .pedal = state->pedal,
                    .contact_area = state->contact_area,
                    .force = state->force,
                    .removal_rate = state->removal_rate,
                    .tissue = static_cast<Tissue>(state->tissue),
                    .cutting_tool = state->turns != 0,
                    .slip_speed = state->slip_speed,
                    .suction = state->suction});
  return TYPODONT_OK;
}

typodont_result typodont_synth_render(typodont_synth* synth, float* samples, size_t count) {
  const HandleLock<typodont_synth> held(synth);
  if (!held) return held.why();
  if (!samples && count > 0) return fail(TYPODONT_BAD_INPUT, "NULL for the samples");
  held->synth.render(std::span(samples, count));
  return TYPODONT_OK;
}

typodont_result typodont_sound_fit(const char* recording, const char* order, const char* model, double* distance_dB) {
  return guarded([&] {
    require(recording && model, "NULL for the recording or for the model's file");
    audio::FitOptions options;
    if (order) options.order = order;
    const audio::FitReport report = audio::fit_recording(recording, options);
    write_file_atomically(model, audio::to_json(report.model));
    if (distance_dB) *distance_dB = report.distance_dB;
  });
}
