#include "engine/app/sound_link.h"

#include <filesystem>

namespace typodont {

namespace {

constexpr std::uint64_t kSeed = 1;

std::filesystem::path voice_of(const Scene& scene) {
  const auto folder = assets_folder() / "sounds";
  const auto own = folder / (scene.motor + ".json");
  return !scene.motor.empty() && std::filesystem::exists(own) ? own : folder / "handpiece.json";
}

}  // namespace

audio::SoundState sound_state(const ServoTick& tick, const ServoTick& previous, bool cutting_tool) noexcept {
  audio::SoundState state;
  state.t = tick.t;
  state.spindle = tick.spindle;
  state.pedal = tick.pedal;
  state.contact_area = tick.contact_area;
  state.force = glm::length(tick.f_T_W);
  state.tissue = tick.tissue;
  state.cutting_tool = cutting_tool;
  const double dt = to_seconds(tick.t - previous.t);
  if (dt > 0) {
    double removed = 0;
    for (std::size_t i = 0; i < tick.removed.size(); ++i) removed += tick.removed[i] - previous.removed[i];
    state.removal_rate = removed / dt;
    const dvec3 v = (tick.X_WG.p - previous.X_WG.p) / dt;
    state.slip_speed = glm::length(v - glm::dot(v, tick.n_C_W) * tick.n_C_W);
  }
  return state;
}

SoundLink::SoundLink(const std::string& address, const Scene& scene)
    : cutting_tool_(scene.servo.tool.cuts), output_(audio::AudioOutput::open(address)) {
  models_ = audio::load_sound_models(voice_of(scene));
  synth_ = std::make_unique<audio::DrillSynth>(models_, output_->sample_rate(), kSeed);
  audio::AudioSource source;
  source.self = this;
  source.render = render;
  source.rate_changed = [](void* self, double rate) {
    auto* link = static_cast<SoundLink*>(self);
    link->synth_ = std::make_unique<audio::DrillSynth>(link->models_, rate, kSeed);
  };
  output_->start(source, 0);
}

SoundLink::~SoundLink() = default;

void SoundLink::push(const ServoTick& tick) noexcept {
  states_.push(sound_state(tick, previous_, cutting_tool_));
  previous_ = tick;
}

void SoundLink::advance(Nanos t) { output_->advance(t); }

void SoundLink::stop(Nanos t) {
  output_->advance(t);
  output_->stop();
}

void SoundLink::render(void* self, std::span<float> mono, Nanos t_first) noexcept {
  auto* link = static_cast<SoundLink*>(self);
  audio::SoundState state;
  while (link->states_.pop(state)) link->synth_->push(state);
  link->synth_->render(mono, t_first);
}

}  // namespace typodont
