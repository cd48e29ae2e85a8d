// A hand that knows how the task should be left, and does it: "--hand expert:" of `typodont servo`. Other than a path
// it sees where its tool is, leads it where it should go, presses while tissue is in the way, and waits until it has
// gone. What it does through the servo, in real tissue, is a session to learn from, and to compare with.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/app/haptic_loop.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/task.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// One thing to do after another.
struct ExpertLeg {
  enum class Kind {
    kMove,    // through the air
    kCut,     // along a line, as fast as the tissue goes
    kScrape,  // along a line; with an edge, to and fro until the tool lies on it
    kWait,    // for `seconds`, or until so much `volume` was put down; the pedal as it is
    kTake,    // another tool, when the drill stands
  } kind = Kind::kMove;
  Pose to;
  double pedal = 0;
  std::uint32_t tool = 0;
  double seconds = 0;
  double volume = 0;    // m³
  double end_pace = 0;  // m/s with which a stroke goes over into the next leg; 0: it stops there
};

/// Where a portion of filling was put down: m along the two axes square to the preparation's. The instrument leaves a
/// hole there into which it fits no other way.
struct FilledSpot {
  std::uint32_t tool = 0;
  double a = 0, b = 0;
};

/// Plans what takes tissue to what the scene's task wants, with the tools of its tray that leave it closest to that.
/// Cavities, crowns and caries are cut; fillings are put down in layers and carved.
class Expert {
 public:
  /// Throws Error where the task names no ideal.
  Expert(const Scene& scene, const haptics::TissueVolume& start);
  /// What to do next, from how it is now: a layer of filling, or all cutting and carving. Empty where nothing is left
  /// that is worth it. Throws Error where the tray has nothing that could begin.
  std::vector<ExpertLeg> plan(const haptics::TissueVolume& now);
  /// What a hand of endless patience would leave by the last plan, without a servo.
  const haptics::TissueVolume& planned() const { return *planned_; }

 private:
  const Scene& scene_;
  TaskJudge judge_;
  std::optional<SurroundingsShape> around_;
  double whole_;  // m³ that the task changes
  std::optional<haptics::TissueVolume> planned_;
  std::vector<FilledSpot> filled_;  // so far
  int layers_ = 0, cuts_ = 0;       // planned so far
  double missing_ = 1e9;            // m³ of filling, at the least when it looked
  double off_ = 0;                  // m³ that were off before it cut last
  int vain_ = 0;                    // layers in a row that brought nothing
  std::size_t instrument_ = 0;      // that fills, from the finest; then all of them again, over the contour
};

class ExpertHand final : public haptics::HapticDevice {
 public:
  ExpertHand(std::vector<ExpertLeg> legs, double rate);
  /// What info() says of such a hand. Like a scripted one it follows every turn, whatever the torque.
  static haptics::DeviceInfo info_for(double rate);
  const haptics::DeviceInfo& info() const noexcept override { return info_; }
  bool read(haptics::HandSample& sample) noexcept override;
  void write(const dvec3&, const dvec3&) noexcept override {}
  /// The eyes of this hand: it leads its tool from where the servo last had it.
  void see(const ServoTick& tick) noexcept override { seen_ = tick; }
  /// Begins the next plan, once read() has ended the last one. Swaps: the finished plan is in `legs` afterwards, so
  /// that nothing is freed. Servo thread.
  void go_on(std::vector<ExpertLeg>& legs) noexcept;
  double done() const { return static_cast<double>(leg_) / static_cast<double>(legs_.size()); }

 private:
  void next_leg() noexcept;
  /// At the end of a leg of an edge: on along its run, or back, or to the next run.
  void end_scraping() noexcept;
  /// Leaves a stroke that it cannot finish: out the way the shank points, over to where the next begins. Straight there
  /// it would press through what should stay.
  void leave() noexcept;

  haptics::DeviceInfo info_;
  std::vector<ExpertLeg> legs_;
  double dt_;
  ServoTick seen_;
  std::size_t leg_ = 0;
  std::array<ExpertLeg, 2> way_out_;  // of a stroke that it left …
  std::size_t way_ = 2;               // … and where on it: 2, it is at its plan
  std::uint64_t ticks_ = 0;
  Pose from_;          // where this leg began
  Pose free_;          // where it last went through the air
  double along_ = 0;   // m of it that the wanted place has come
  double filled_ = 0;  // m³ in the tissue when it began, more or less than at the start
  double waited_ = 0;  // s that it has stood still
  // Strokes of an edge that go on into each other are a run: it is drawn to and fro until the tool lies on the line.
  std::size_t run_ = 0;  // the leg that begins the run …
  Pose run_from_;        // … and where that begins
  double worst_ = 0;     // m, how far the tool was beside the line in this pass
  int times_ = 0;        // that it went back and forth
  bool back_ = false;    // it goes back now
  dvec3 lead_{0};        // m, by which the hand leads the tool
  double most_lead_;     // m, of a cut: as much as gives the force that it works with
};

/// Runs the hand in simulated time until nothing is left to do: it carries out its plan, looks at the tissue, and plans
/// the rest. `each`: called after every tick.
void run_expert(HapticLoop& loop, ExpertHand& hand, Expert& expert,
                const std::function<void(const ServoTick&, const Cut*)>& each);

}  // namespace typodont
