#include "peer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/app/bench/stored_rows.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/scene.h"

namespace typodont::peers {

using haptics::bench::Course;
using haptics::bench::kProbeRadius;
using haptics::bench::ModelTissue;

namespace {

constexpr double kTick = 1e-3;         // s
constexpr std::size_t kSettled = 100;  // ticks until the hand is on the surface; earlier ticks are not timed
constexpr std::size_t kPressed = 300;  // ticks until the pressing hand no longer swings
constexpr int kPasses = 3;             // the shortest time of each tick counts
constexpr double kLeast = 0.02;        // N, a smaller force has no reliable direction
constexpr std::size_t kDrillTicks = 600;
constexpr double kPress = 1;       // N, force with which the drilling hand presses
constexpr double kGrid = 0.02e-3;  // m, spacing of the grid with which a swept volume is measured

/// Prints the rows of one test of one model.
class Rows {
 public:
  Rows(const ModelTissue& tissue, const char* motion, const PeerModel& model)
      : case_(fmt::format("{}, {}, {}", tissue.name, motion, model.name)), knob_(model.knob) {}
  void error(const char* measure, double error, const char* unit, double ns) const {
    fmt::print("models,\"{}: {}\",{},{:.6g},\"{}\",{:.6g},tick,,,,\n", case_, measure, knob_, error, unit, ns);
  }
  /// Prints the row of the 99.9 % quantile and returns the median of the ticks' times (ns).
  double times(std::vector<double> times) const {
    times.erase(times.begin(), times.begin() + kSettled);
    fmt::print("models,\"{}: tick, 99.9 %\",{},,,{:.6g},tick,,,,\n", case_, knob_, quantile(times, 0.999));
    return quantile(times, 0.5);
  }

 private:
  std::string case_, knob_;
};

/// Typodont's default contact model; servo and carver run in lock-step. The time of a tick is the servo's.
class DefaultPeer : public Peer {
 public:
  DefaultPeer(const ModelTissue& tissue, double voxel_mm, bool drills)
      : scene_(tissue.make(voxel_mm), settings(drills)) {}
  PeerTick tick(const dvec3& hand, bool drills) override {
    const std::uint64_t cuts = scene_.last.cuts;
    const double ns = scene_.tick({hand}, drills ? 1 : 0);
    PeerTick tick{
        .force = drills ? scene_.last.f_T_W : scene_.last.f_model_W, .ball = scene_.last.X_WG.p, .cpu_ns = ns};
    if (scene_.last.cuts > cuts) tick.cut = std::pair(scene_.cut.X_WA.p, scene_.cut.X_WB.p);
    return tick;
  }
  double volume() const override { return total(scene_.carver.volume().volumes()); }

 private:
  static haptics::ServoSettings settings(bool drills) {
    haptics::ServoSettings settings;
    settings.tool = haptics::bench::head(haptics::HeadShape::kSphere, 2 * kProbeRadius, 2 * kProbeRadius);
    settings.stiffness = kStiffness;
    settings.spindle.free_speed = 300 * kKrpm;
    if (!drills) settings.damping = 0, settings.friction = settings.cutting = false;
    return settings;
  }

  haptics::bench::Scene scene_;
};

}  // namespace

void print_header() {
  fmt::print("{}\n", kRowColumns);
}

void print_slide(const ModelTissue& tissue, const Course& course, const PeerModel& model) {
  std::vector<double> times(course.hand.size(), 1e18);
  double squares = 0, sizes = 0, worst = 0;
  int count = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::unique_ptr<Peer> peer = model.begin(course.hand.front(), false);
    for (std::size_t i = 0; i < course.hand.size(); ++i) {
      const PeerTick tick = peer->tick(course.hand[i], false);
      times[i] = std::min(times[i], tick.cpu_ns);
      const dvec3 truth = kStiffness * (course.truth[i] - course.hand[i]);
      if (pass > 0 || i < kSettled || glm::length(truth) < kLeast) continue;
      const double angle = glm::length(tick.force) > 0 ? haptics::bench::degrees_between(tick.force, truth) : 180;
      const double size = 100 * (glm::length(tick.force) / glm::length(truth) - 1);
      squares += angle * angle, sizes += size * size, worst = std::max(worst, angle), ++count;
    }
  }
  const Rows rows(tissue, "slide", model);
  const double median = rows.times(times);
  rows.error("direction", std::sqrt(squares / std::max(count, 1)), "degree, rms", median);
  rows.error("direction", worst, "degree, greatest", median);
  rows.error("magnitude", std::sqrt(sizes / std::max(count, 1)), "%, rms", median);
}

void print_drill(const ModelTissue& tissue, const PeerModel& model) {
  std::vector<double> times(kDrillTicks, 1e18);
  std::vector<std::pair<dvec3, dvec3>> ways;
  double lost = 0, depth = 0, step = 0, squares = 0;
  int count = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    haptics::bench::PressingHand hand(tissue);
    const std::unique_ptr<Peer> peer = model.begin(hand.position(), true);
    const double before = peer->volume();
    const dvec3 start = hand.position();
    dvec3 force(0), ball(0);
    ways.clear();
    for (std::size_t i = 0; i < kDrillTicks; ++i) {
      const PeerTick tick = peer->tick(hand.next(force, kTick), true);
      times[i] = std::min(times[i], tick.cpu_ns);
      if (tick.cut) ways.push_back(*tick.cut);
      if (pass == 0 && i >= kPressed) {
        step = std::max(step, glm::length(tick.force) - glm::length(force));
        const double off = glm::dot(tick.force, hand.normal()) - kPress;
        squares += off * off, ++count;
      }
      force = tick.force, ball = tick.ball;
    }
    lost = before - peer->volume();
    depth = glm::dot(start - ball, hand.normal());
  }
  const double swept = haptics::bench::swept_volume(tissue.shape, ways, kProbeRadius, kGrid);
  const Rows rows(tissue, "drill", model);
  const double median = rows.times(times);
  if (swept > 0) rows.error("removal", 100 * (lost / swept - 1), "% more than the swept volume", median);
  rows.error("depth", depth / kMillimetre, "mm, no error: what was drilled", median);
  rows.error("force", std::sqrt(squares / std::max(count, 1)), "N, rms, off the 1 N of the hand", median);
  rows.error("step", step, "N a tick", median);
}

PeerModel default_model(const ModelTissue& tissue, double voxel_mm) {
  return {"offset", fmt::format("voxel {:g} mm", voxel_mm), [&tissue, voxel_mm](const dvec3&, bool drills) {
            return std::make_unique<DefaultPeer>(tissue, voxel_mm, drills);
          }};
}

Course slide_course(const ModelTissue& tissue) {
  return haptics::bench::slide_course(tissue, 2500);
}

}  // namespace typodont::peers
