// Sessions for tests. In their ticks every field has an unusual number, which comes from a seed.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/contract/loop_timing.h"
#include "engine/contract/safety_event.h"
#include "engine/session/session_data.h"
#include "tests/support/folder.h"

namespace typodont::session::test {

using TemporaryFolder = typodont::test::Folder;
using typodont::test::read_text;
using typodont::test::refusal;

/// A test with an empty folder.
struct FolderTest : testing::Test {
  TemporaryFolder folder;
};

struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double number(double scale) { return std::uniform_real_distribution<double>(-scale, scale)(engine); }
  dvec3 vec(double scale) { return {number(scale), number(scale), number(scale)}; }
  Pose pose(double scale) { return {vec(scale), glm::normalize(dquat(number(1), number(1), number(1), number(1)))}; }
};

inline ServoTick random_tick(std::uint64_t index, Random& random) {
  ServoTick t;
  t.index = index;
  t.t = static_cast<Nanos>(index) * 1'000'003;
  t.X_WT = random.pose(0.02);
  t.X_WG = random.pose(0.02);
  t.f_T_W = random.vec(3);
  t.tau_T_W = random.vec(0.01);
  t.pedal = std::abs(random.number(1));
  t.depth = std::abs(random.number(1e-3));
  t.n_C_W = glm::normalize(random.vec(1));
  t.contact_area = std::abs(random.number(1e-6));
  for (int i = 1; i < kTissueCount; ++i) t.removed[i] = std::abs(random.number(1e-9));
  t.tissue = static_cast<Tissue>(random.engine() % kTissueCount);
  t.spindle = random.number(4e4);
  t.cutting_power = std::abs(random.number(2));
  t.energy = random.number(1e-2);
  t.wear = std::abs(random.number(1));
  t.cpu_time = static_cast<Nanos>(random.engine() % 100'000);
  t.faults = static_cast<std::uint32_t>(random.engine() & 0x1ff);
  t.patch = static_cast<std::uint32_t>(random.engine());
  t.cuts = 0;
  return t;
}

inline std::vector<ServoTick> random_ticks(std::size_t count, std::uint64_t seed, std::uint64_t first = 0) {
  Random random(seed);
  std::vector<ServoTick> ticks;
  for (std::size_t i = 0; i < count; ++i) ticks.push_back(random_tick(first + i, random));
  return ticks;
}

inline std::vector<Cut> random_cuts(std::size_t count, std::uint64_t seed, std::uint64_t first = 1) {
  Random random(seed);
  std::vector<Cut> cuts;
  for (std::size_t i = 0; i < count; ++i) {
    Cut c;
    c.index = first + i;
    c.tick = 3 * c.index;
    c.t = static_cast<Nanos>(c.index) * 999;
    c.X_WA = random.pose(0.01);
    c.X_WB = random.pose(0.01);
    c.tool = static_cast<std::uint32_t>(i % 3);
    for (int k = 1; k < kTissueCount; ++k) c.removed[k] = std::abs(random.number(1e-12));
    c.n_C_W = glm::normalize(random.vec(1));
    c.spindle = random.number(4e4);
    cuts.push_back(c);
  }
  return cuts;
}

inline std::vector<PatchUse> random_patches(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<PatchUse> patches;
  for (std::size_t i = 0; i < count; ++i) {
    patches.push_back({static_cast<std::uint32_t>(i + 1), 7 * i + random.engine() % 7, 5 * i + random.engine() % 5,
                       random.vec(0.01)});
  }
  return patches;
}

inline SessionHeader some_header() {
  SessionHeader h;
  h.scene_json = "{\"name\": \"Zähne, 牙齿\", \"score\": {}}";
  h.rig_json = "{\"display\": \"offscreen\"}";
  h.files = {{"teeth/molar.vdb", 1234567, "fnv1a64:0123456789abcdef"}};
  h.hand = "script:hand.csv";
  h.seeds = {{"tremor", 0xfedcba9876543210u}, {"debris", 7}};
  h.tools = {"round_012", "round_014", "flame_012"};
  h.streams = {{"head", {{"head_x_m", "m"}, {"head_y_m", "m"}}}, {"sound", {{"level", ""}}}};
  h.servo_rate = 1000;
  h.vibration_band = 150;
  h.position_step = 0.055e-3;
  h.gives_torque = false;
  h.voxel = 1e-4;
  h.volumes_before[1] = 3.25e-7;
  h.date = "2025-01-02T03:04:05Z";
  return h;
}

/// Returns the report of one minute at 1 kHz, with a device that has motors and whose watchdog switched off the force
/// once.
inline LoopReport some_loop() {
  LoopReport loop;
  Random random(3);
  for (Nanos i = 0; i < 60'000; ++i) {
    const Nanos woke = i * 1'000'000 + static_cast<Nanos>(random.engine() % 30'000);
    loop.timing.record(woke, woke + (i == 41'000 ? 1'700'000 : 12'000 + static_cast<Nanos>(random.engine() % 9'000)));
  }
  loop.fifo = loop.memory_locked = true;
  loop.say("pinning refused");
  loop.heat = 0.25, loop.worst_heat = 0.93, loop.bearable_force = 4.5;
  loop.armed = true;
  loop.safety = bits(SafetyEvent::kWatchdog) | bits(SafetyEvent::kThermal);
  return loop;
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

inline bool same_bits(const Pose& a, const Pose& b) {
  return same_bits(a.p.x, b.p.x) && same_bits(a.p.y, b.p.y) && same_bits(a.p.z, b.p.z) && same_bits(a.R.w, b.R.w) &&
         same_bits(a.R.x, b.R.x) && same_bits(a.R.y, b.R.y) && same_bits(a.R.z, b.R.z);
}

/// Returns true if the fields that a replay compares are equal.
inline bool same_for_replay(const ServoTick& a, const ServoTick& b) {
  return a.index == b.index && a.t == b.t && same_bits(a.X_WT, b.X_WT) && same_bits(a.X_WG.R, b.X_WG.R) &&
         same_bits(a.f_T_W, b.f_T_W) && same_bits(a.n_C_W, b.n_C_W) && same_bits(a.pedal, b.pedal) &&
         same_bits(a.cutting_power, b.cutting_power) && same_bits(a.wear, b.wear) && a.tissue == b.tissue &&
         a.faults == b.faults && a.patch == b.patch && a.cuts == b.cuts && a.cpu_time == b.cpu_time;
}

inline bool same(const Cut& a, const Cut& b) {
  return a.index == b.index && a.tick == b.tick && a.t == b.t && same_bits(a.X_WA, b.X_WA) &&
         same_bits(a.X_WB, b.X_WB) && a.tool == b.tool && same_bits(a.removed, b.removed) &&
         same_bits(a.n_C_W, b.n_C_W) && same_bits(a.spindle, b.spindle);
}

inline bool same(const PatchUse& a, const PatchUse& b) {
  return a.patch == b.patch && a.first_tick == b.first_tick && a.cuts == b.cuts && same_bits(a.center_W, b.center_W);
}

/// Returns the distance between two doubles of the same sign, in units in the last place.
inline double ulps(double a, double b) {
  if (a == b) return 0;
  return std::abs(a - b) / (std::nextafter(std::abs(a), std::numeric_limits<double>::infinity()) - std::abs(a));
}

}  // namespace typodont::session::test
