// Compares the time of a servo tick through the C interface with the time of the same tick without this interface, in
// the same run.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <typodont.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "engine/app/recording/resume.h"
#include "engine/app/stepped.h"
#include "engine/base/clock.h"

namespace typodont {
namespace {

constexpr const char* kBall = R"({"tissue": {"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300})";
constexpr int kTicks = 500, kRounds = 20;
/// The times of two equal cores (servo and tissue) differ by up to 3 %, because they lie at different addresses in
/// memory. So several pairs are measured.
constexpr int kPairs = 61;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Returns the CPU time (ns) of one tick, measured over a round of kTicks ticks.
template <class Tick>
double time_of(Nanos& t, Tick&& tick) {
  const Nanos start = thread_cpu_time();
  for (int i = 0; i < kTicks; ++i, ++t) tick(t);
  return static_cast<double>(thread_cpu_time() - start) / kTicks;
}

struct Round {
  double own, through;  // ns per tick of the core without the interface, and of the same tick through the C interface
};

/// Measures two equal cores, one without and one with the C interface, in alternating rounds. The hand moves about z
/// metres above the ball's centre. `own_first`: true if the core without the interface is created first.
std::vector<Round> rounds(double z, bool own_first) {
  const Scene scene = parse_scene(Json::parse(kBall, "ball"), "ball.json");
  haptics::DeviceInfo hand;
  hand.torque_limit = 1;
  std::optional<SteppedSession> session;
  typodont_scene* c_scene = nullptr;
  typodont_core* core = nullptr;
  EXPECT_EQ(typodont_scene_parse(kBall, nullptr, nullptr, &c_scene), TYPODONT_OK) << typodont_error();
  if (own_first) session.emplace(scene, load_tissue(scene), hand);
  EXPECT_EQ(typodont_core_new(c_scene, nullptr, nullptr, &core), TYPODONT_OK) << typodont_error();
  if (!own_first) session.emplace(scene, load_tissue(scene), hand);
  const auto place = [&](Nanos t) { return dvec3(1e-7 * static_cast<double>(t % 1000), 0, z); };
  typodont_tick c_tick{};
  c_tick.struct_size = sizeof c_tick;
  std::vector<Round> rounds(kRounds);
  Nanos t = 0, c_t = 0;
  for (Round& round : rounds) {
    round.own = time_of(t, [&](Nanos i) {
      haptics::HandSample sample;
      sample.t = i * 1'000'000;
      sample.X_WT.p = place(i);
      session->tick(sample);
    });
    round.through = time_of(c_t, [&](Nanos i) {
      typodont_sample sample{};
      sample.struct_size = sizeof sample;
      sample.t_ns = i * 1'000'000;
      const dvec3 p = place(i);
      sample.X_WT = {{p.x, p.y, p.z}, {1, 0, 0, 0}};
      if (typodont_core_tick(core, &sample, &c_tick, nullptr) != TYPODONT_OK) ADD_FAILURE() << typodont_error();
    });
  }
  EXPECT_EQ(session->last().f_T_W.z, c_tick.force[2]);
  EXPECT_EQ(typodont_core_free(core), TYPODONT_OK);
  EXPECT_EQ(typodont_scene_free(c_scene), TYPODONT_OK);
  return rounds;
}

/// Returns the time (ns) that the C interface adds to a tick: the median of the differences between neighbouring
/// rounds.
double on_top(double z) {
  std::vector<double> own, more;
  for (int pair = 0; pair < kPairs; ++pair) {
    for (const Round& round : rounds(z, pair % 2 == 0)) {
      own.push_back(round.own);
      more.push_back(round.through - round.own);
    }
  }
  fmt::print("{:.1f} mm: core {:.1f} ns, through C {:.1f} ns more\n", z * 1e3, median(own), median(more));
  return median(more);
}

TEST(DoorsBench, ATickThroughTheCInterfaceTakesAtMost20NanosecondsMoreInTheAir) {
  EXPECT_LE(on_top(4e-3), 20);
}

TEST(DoorsBench, ATickThroughTheCInterfaceTakesAtMost20NanosecondsMoreInContact) {
  EXPECT_LE(on_top(3.5e-3), 20);
}

}  // namespace
}  // namespace typodont
