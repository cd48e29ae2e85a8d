#include "engine/app/sound_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "engine/app/assets.h"
#include "engine/base/units.h"
#include "engine/session/hash.h"

namespace typodont {

namespace {

constexpr std::uint64_t kSeed = 1;
// s/m³, level of the suction (0..1) per flow: 300 l/min are about 3 dB quieter than the drill under load, so that the
// drill is heard through it.
constexpr double kSuctionPerFlow = 0.18 / 5e-3;
constexpr double kHold = 0.25;  // s, time without a tick after which the sound of a live session stops

std::filesystem::path voice_of(const Scene& scene) {
  const auto folder = assets_folder() / "sounds";
  const auto own = folder / (scene.motor + ".json");
  if (!scene.motor.empty() && std::filesystem::exists(own)) return own;
  // rad/s; a faster handpiece sounds like an air turbine, a slower one like an electric handpiece
  constexpr double kTurbine = 150 * kKrpm;
  return folder / (scene.servo.spindle.free_speed > kTurbine ? "air_turbine.json" : "handpiece.json");
}

std::vector<bool> tools_that_cut(const Scene& scene) {
  std::vector<bool> cut;
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) cut.push_back(tool.turns());
  return cut;
}

}  // namespace

SoundLink::SoundLink(const std::string& address, const Scene& scene, bool live)
    : live_(live),
      options_{live ? kHold : 0.0, scene.sound_lower_order},
      output_(audio::AudioOutput::open(address)),
      voice_(tools_that_cut(scene)) {
  voice_file_ = voice_of(scene);
  models_ = audio::load_sound_models(voice_file_);
  models_.free_speed = scene.servo.spindle.free_speed;
  make_synth(output_->sample_rate());
}

SoundLink::~SoundLink() = default;

std::string SoundLink::about() const {
  const session::SourceFile file = session::describe_file(voice_file_);
  return fmt::format("sound: {} {}, {:.0f} Hz, seed {}", voice_file_.filename().string(), file.hash,
                     output_->sample_rate(), kSeed);
}

void SoundLink::make_synth(double sample_rate) {
  synth_ = std::make_unique<audio::DrillSynth>(models_, sample_rate, kSeed, options_);
}

void SoundLink::push(const ServoTick& tick) noexcept {
  ticks_.push(tick);
}

void SoundLink::advance(Nanos t) {
  if (!begun_) {
    audio::AudioSource source;
    source.self = this;
    source.render = render;
    source.rate_changed = [](void* self, double rate) { static_cast<SoundLink*>(self)->make_synth(rate); };
    zero_ = now() - t;
    device_latency_ = output_->stats().device_latency;
    output_->start(source, live_ ? t : 0);
    begun_ = true;
  }
  output_->advance(t);
}

void SoundLink::stop(Nanos t) {
  advance(t);
  output_->stop();
}

void SoundLink::render(void* self, std::span<float> mono, Nanos t_first) noexcept {
  auto* link = static_cast<SoundLink*>(self);
  ServoTick tick;
  bool heard = false;
  while (link->ticks_.pop(tick)) {
    audio::SoundState state = link->voice_.state_of(tick);
    state.suction = kSuctionPerFlow * link->suction_flow_.load(std::memory_order_relaxed);
    link->synth_->push(state);
    heard = true;
  }
  // A tick that arrived too late for its own sample is heard in the first sample of this block.
  if (heard && link->live_)
    link->latency_.store(to_seconds(now() - link->zero_ - std::min(tick.t, t_first)) + link->device_latency_,
                         std::memory_order_relaxed);
  link->synth_->render(mono, t_first);
}

}  // namespace typodont
