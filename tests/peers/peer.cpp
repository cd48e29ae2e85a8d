#include "peer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"

namespace typodont::peers {

using test::Course;
using test::kProbeRadius;
using test::ModelTissue;

namespace {

constexpr double kTick = 1e-3;         // s
constexpr std::size_t kSettled = 100;  // ticks until the hand is on the surface; earlier ticks are not timed
constexpr std::size_t kPressed = 300;  // ticks until the pressing hand no longer swings
constexpr int kPasses = 3;             // the shortest time of each tick counts
constexpr double kMin = 0.02;          // N, a smaller force has no reliable direction
constexpr std::size_t kDrillTicks = 600;
constexpr double kPress = 1;       // N, force with which the drilling hand presses
constexpr double kGrid = 0.02e-3;  // m, spacing of the grid with which a swept volume is measured

/// Prints the results of one test of one model.
class Rows {
 public:
  Rows(const char* motion, const ModelTissue& tissue, const PeerModel& model)
      : case_(fmt::format("{}/{}/{}/{}", motion, tissue.name, model.name, model.knob)) {}
  void add(const char* measure, double value) const { fmt::print("{},{},{:.6g}\n", case_, measure, value); }
  void times(std::vector<double> ns) const {
    ns.erase(ns.begin(), ns.begin() + kSettled);
    add("time_ns", quantile(ns, 0.5));
    add("slow_ns", quantile(ns, 0.999));
  }

 private:
  std::string case_;
};

/// Typodont's default contact model; servo and carver run in lock-step. The time of a tick is the servo's.
class DefaultPeer : public Peer {
 public:
  DefaultPeer(const ModelTissue& tissue, double voxel_mm, bool drills)
      : scene_(tissue.make(voxel_mm), settings(drills), materials()) {}
  PeerTick tick(const dvec3& hand, bool drills) override {
    scene_.tick({hand}, drills ? 1 : 0);
    PeerTick tick{.force = drills ? scene_.last.f_T_W : scene_.last.f_model_W,
                  .ball = scene_.last.X_WG.p,
                  .cpu_ns = static_cast<double>(scene_.last.cpu_time)};
    if (scene_.did_cut) tick.cut = std::pair(scene_.cut.X_WA.p, scene_.cut.X_WB.p);
    return tick;
  }
  double volume() const override { return total(scene_.carver.volume().volumes()); }

 private:
  static MaterialTable materials() {
    MaterialTable table;
    table.fill({kStiffness, 8e9, 0.2, 0.15, 2150, dvec3(0.8)});
    return table;
  }
  static haptics::ServoSettings settings(bool drills) {
    haptics::ServoSettings settings;
    settings.tool.diameter = settings.tool.length = 2 * kProbeRadius;
    settings.stiffness = kStiffness;
    settings.spindle.free_speed = 300 * kKrpm;
    if (!drills) settings.damping = 0, settings.friction = settings.cutting = false;
    return settings;
  }

  test::HapticBench scene_;
};

}  // namespace

void print_header() {
  fmt::print("case,measure,value\n");
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
      if (pass > 0 || i < kSettled || glm::length(truth) < kMin) continue;
      const double angle =
          glm::length(tick.force) > 0
              ? glm::acos(std::clamp(glm::dot(glm::normalize(tick.force), glm::normalize(truth)), -1.0, 1.0)) / kDegree
              : 180;
      const double size = 100 * (glm::length(tick.force) / glm::length(truth) - 1);
      squares += angle * angle, sizes += size * size, worst = std::max(worst, angle), ++count;
    }
  }
  const Rows rows("slide", tissue, model);
  rows.times(times);
  rows.add("direction_rms_deg", std::sqrt(squares / std::max(count, 1)));
  rows.add("direction_max_deg", worst);
  rows.add("magnitude_rms_percent", std::sqrt(sizes / std::max(count, 1)));
}

void print_drill(const ModelTissue& tissue, const PeerModel& model) {
  std::vector<double> times(kDrillTicks, 1e18);
  std::vector<std::pair<dvec3, dvec3>> ways;
  double lost = 0, depth = 0, step = 0, squares = 0;
  int count = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    test::PressingHand hand(tissue);
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
  const double swept = test::swept_volume(tissue.shape, ways, kProbeRadius, kGrid);
  const Rows rows("drill", tissue, model);
  rows.times(times);
  if (swept > 0) rows.add("removal_error_percent", 100 * std::abs(lost / swept - 1));
  rows.add("depth_mm", depth / kMillimetre);
  rows.add("force_error_rms_N", std::sqrt(squares / std::max(count, 1)));
  rows.add("step_N", step);
}

PeerModel default_model(const ModelTissue& tissue, double voxel_mm) {
  return {"offset", fmt::format("voxel {:g} mm", voxel_mm), [&tissue, voxel_mm](const dvec3&, bool drills) {
            return std::make_unique<DefaultPeer>(tissue, voxel_mm, drills);
          }};
}

Course slide_course(const ModelTissue& tissue) {
  return test::slide_course(tissue, 1500);
}

}  // namespace typodont::peers
