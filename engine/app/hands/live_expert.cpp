#include "engine/app/hands/live_expert.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "engine/app/hands/expert_hand.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/hands/probing_hand.h"
#include "engine/app/recording/resume.h"
#include "engine/base/clock.h"
#include "engine/base/log.h"
#include "engine/base/ring.h"
#include "engine/base/ticker.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;
using Legs = std::vector<ExpertLeg>;

// Time between two checks for a requested plan or a new copy of the tissue.
constexpr auto kPollInterval = 2ms;

class LiveExpert final : public haptics::HapticDevice {
 public:
  LiveExpert(const Scene& scene, const haptics::TissueVolume& start, Wiring& wiring, double rate, bool paced)
      : wiring_(wiring),
        paced_(paced),
        expert_(scene, load_untouched(scene), kHandMargins),
        hand_(expert_.plan(start), rate, expert_.grip()),
        ticker_(rate, paced) {
    planner_ = std::jthread([this](std::stop_token stop) { plan_when_asked(stop); });
  }
  ~LiveExpert() override {
    planner_.request_stop();
    planner_.join();
    haptics::TissueVolume* copy = nullptr;
    while (wiring_.copies_to_expert.pop(copy)) delete copy;
  }

  const haptics::DeviceInfo& info() const noexcept override { return hand_.info(); }
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override {
    held_ = (tick.faults & bits(Fault::kHeld)) != 0;
    hand_.see(tick);
  }

  bool read(haptics::HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    if (!paced_ && waits_) std::this_thread::sleep_for(kPollInterval);
    if (!held_ && !follow_plan()) return false;
    sample = last_;
    sample.t = t;
    if (held_) sample.pedal = 0;
    return true;
  }

 private:
  /// Computes the next sample. While a plan is being made, the hand rests with the pedal released. False: the plan is
  /// empty. Servo thread only.
  bool follow_plan() noexcept {
    if (waits_) {
      Legs* next = nullptr;
      if (!plans_.pop(next)) return true;
      if (next->empty()) return false;
      waits_ = false;
      hand_.go_on(*next);
    }
    if (hand_.read(last_)) return true;
    waits_ = true;
    last_.pedal = 0;
    asked_ = true;
    return true;
  }

  /// Makes a plan when the servo thread asks. Planner thread only.
  void plan_when_asked(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (!asked_.exchange(false)) {
        std::this_thread::sleep_for(kPollInterval);
        continue;
      }
      wiring_.expert_wants_copy = true;
      haptics::TissueVolume* copy = nullptr;
      while (!stop.stop_requested() && !wiring_.copies_to_expert.pop(copy)) std::this_thread::sleep_for(kPollInterval);
      const std::unique_ptr<const haptics::TissueVolume> tissue(copy);
      if (!tissue) return;
      made_.push_back(std::make_unique<Legs>());
      try {
        *made_.back() = expert_.plan(*tissue);
      } catch (const std::exception& e) {  // the plan stays empty, which ends the session
        log::warn("the expert cannot go on: {}", e.what());
      }
      plans_.push(made_.back().get());
    }
  }

  Wiring& wiring_;
  const bool paced_;
  Expert expert_;    // planner thread only, once that thread runs
  ExpertHand hand_;  // from here to waits_: servo thread only
  haptics::HandSample last_;
  Ticker ticker_;
  bool held_ = false;
  bool waits_ = false;              // true: waits for the next plan
  std::atomic<bool> asked_{false};  // set by the servo thread, cleared by the planner thread
  Ring<Legs*> plans_{2};            // plans from the planner thread to the servo thread
  // Owns all plans until the end. Planner thread only.
  std::vector<std::unique_ptr<Legs>> made_;
  std::jthread planner_;
};

/// Follows an expert that needs no plan. The hand rests during an emergency stop.
class LiveUnplannedExpert final : public haptics::HapticDevice {
 public:
  LiveUnplannedExpert(std::unique_ptr<haptics::HapticDevice> hand, bool paced)
      : hand_(std::move(hand)), ticker_(info().rate, paced) {}
  const haptics::DeviceInfo& info() const noexcept override { return hand_->info(); }
  void write(const dvec3&, const dvec3&) noexcept override {}
  void see(const ServoTick& tick) noexcept override {
    held_ = (tick.faults & bits(Fault::kHeld)) != 0;
    if (!held_) hand_->see(tick);
  }
  bool read(haptics::HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    if (!held_ && !hand_->read(last_)) return false;
    sample = last_;
    sample.t = t;
    if (held_) sample.pedal = 0;
    return true;
  }

 private:
  std::unique_ptr<haptics::HapticDevice> hand_;
  haptics::HandSample last_;
  Ticker ticker_;
  bool held_ = false;
};

}  // namespace

std::unique_ptr<haptics::HapticDevice> make_unplanned_expert(const Scene& scene, double rate) {
  if (scene.implant) return std::make_unique<ImplantExpert>(scene, rate);
  if (scene.task && !scene.task->sites.empty()) return std::make_unique<ProbingHand>(scene, rate);
  return nullptr;
}

std::unique_ptr<haptics::HapticDevice> make_live_expert(const Scene& scene, const haptics::TissueVolume& start,
                                                        Wiring& wiring, double rate, bool paced) {
  if (auto hand = make_unplanned_expert(scene, rate))
    return std::make_unique<LiveUnplannedExpert>(std::move(hand), paced);
  return std::make_unique<LiveExpert>(scene, start, wiring, rate, paced);
}

}  // namespace typodont
