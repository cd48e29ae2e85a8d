#include "engine/app/sound_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "engine/app/assets.h"
#include "engine/base/units.h"
#include "engine/session/hash.h"

namespace typodont {

namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kFullSuction = 5e-3;  // m³/s, flow at which the sound of the suction has its full level; 300 l/min
constexpr double kHold = 0.25;         // s, the sound of a live session stops if no tick arrives for this time

}  // namespace

SoundVoice voice_of(const Scene& scene) {
  // A handpiece faster than this sounds like an air turbine, a slower one like an electric handpiece, rad/s.
  constexpr double kTurbine = 150 * kKrpm;
  const double free_speed = scene.servo.spindle.free_speed;
  const bool own =
      !scene.motor.empty() && std::filesystem::exists(assets_folder() / "sounds" / (scene.motor + ".json"));
  SoundVoice voice{own                     ? scene.motor
                   : free_speed > kTurbine ? "air_turbine"
                                           : "handpiece",
                   free_speed,
                   {},
                   scene.sound_lower_order};
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) voice.tools_cut.push_back(tool.turns());
  return voice;
}

SoundLink::SoundLink(const std::string& address, const SoundVoice& voice, const EventLogs& event_logs, bool live,
                     bool binaural, Nanos begin)
    : live_(live),
      begin_(begin),
      options_{live ? kHold : 0.0, voice.lower_order},
      output_(audio::AudioOutput::open(address, {.channels = binaural ? 2 : 1})),
      voice_(voice.tools_cut),
      servo_(event_logs.servo),
      view_(event_logs.view) {
  voice_file_ = named_asset("sounds", voice.model);
  models_ = audio::load_sound_models(voice_file_);
  models_.free_speed = voice.free_speed;
  if (binaural) ears_.emplace(output_->sample_rate());
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
  if (ears_) ears_.emplace(sample_rate);
}

void SoundLink::water(bool spray, double suction_flow) noexcept {
  spray_.store(spray ? 1 : 0, std::memory_order_relaxed);
  suction_.store(std::clamp(suction_flow / kFullSuction, 0.0, 1.0), std::memory_order_relaxed);
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

void SoundLink::render(void* self, std::span<float> samples, Nanos t_first) noexcept {
  auto* link = static_cast<SoundLink*>(self);
  Nanos heard = -1;  // ns, session time of the latest tick whose sound begins in this block
  for (ServoEvent event; link->servo_.next(event);) {
    auto* const next = std::get_if<ServoTick>(&event);
    if (!next || next->t < link->begin_) continue;
    next->t -= link->begin_;
    const ServoTick& tick = *next;
    link->unheard_ += tick.index - std::exchange(link->next_tick_, tick.index + 1);
    audio::SoundState state = link->voice_.state_of(tick);
    if (tick.pedal > 0) state.spray = link->spray_.load(std::memory_order_relaxed);
    state.suction = link->suction_.load(std::memory_order_relaxed);
    link->synth_->push(state);
    link->tool_W_ = tick.X_WG.p;
    link->seen_tool_ = true;
    heard = tick.t;
  }
  // Measures the latency from the tick to its sound. A tick with time t is heard in the sample with time t, or in the
  // first sample of this block if that sample was already played.
  if (heard >= 0 && link->live_)
    link->latency_.store(to_seconds(now() - link->zero_ - std::min(heard, t_first)) + link->device_latency_,
                         std::memory_order_relaxed);
  if (!link->ears_) {
    link->synth_->render(samples, t_first);
    return;
  }
  for (ViewEvent event; link->view_.next(event);)
    if (const auto* const seen = std::get_if<SeenFrom>(&event)) link->listener_ = *seen, link->listened_ = true;
  if (link->listened_ && link->seen_tool_)
    link->ears_->turn(audio::ear_angles(link->tool_W_, link->listener_.eye_W, link->listener_.right_W));
  const double period = 1e9 / link->synth_->sample_rate();
  for (std::size_t done = 0, frames = samples.size() / 2; done < frames;) {
    const std::size_t count = std::min(frames - done, link->mono_.size());
    const std::span<float> mono(link->mono_.data(), count);
    link->synth_->render(mono, t_first + static_cast<Nanos>(std::llround(static_cast<double>(done) * period)));
    link->ears_->render(mono, samples.subspan(2 * done, 2 * count));
    done += count;
  }
}

}  // namespace typodont
