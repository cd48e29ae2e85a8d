// Tests patches on their way from the carver to the servo: they are kept up to date while the servo continues to cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>
#include <random>

#include "engine/base/ring.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/contact/cubic.h"
#include "haptics/cutting/carve.h"
#include "haptics/patch_exchange.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::Carver;
using haptics::PatchExchange;
using haptics::TissuePatch;
using haptics::Tool;
using test::HapticBench;

constexpr const char* kBlock =
    R"({"voxel_mm": 0.1, "band_mm": 1.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]})";

std::vector<Tool> bur_with_shank_and_condenser() {
  std::vector<Tool> tools(2);
  tools[0].diameter = tools[0].length = 1.2_mm;
  tools[0].shank_length = 5.0_mm;
  tools[0].shank_diameter = 1.0_mm;
  tools[1].diameter = tools[1].length = 0.8_mm;
  tools[1].cuts = false;
  tools[1].fill = Tissue::kComposite;
  tools[1].fill_reach = 0.6_mm;
  tools[1].fill_rate = 3e-9;  // m³/s
  return tools;
}

/// The same block with a softer layer below its surface.
constexpr const char* kGradedBlock = R"({"voxel_mm": 0.1, "band_mm": 1.2, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}},
    {"tissue": "dentin", "hardness": 0.4, "solid": {"box": {"center_mm": [0, 0, 1.2], "size_mm": [6, 6, 1]}}}]})";

haptics::TissueVolume block(const char* json = kBlock) {
  return haptics::TissueVolume(haptics::read_solids(Json::parse(json, "block")));
}

TissuePatch patch_for(const std::vector<Tool>& tools) {
  TissuePatch patch;
  patch.resize(haptics::patch_edge_for(tools, 0.1_mm));
  return patch;
}

void expect_equal(const TissuePatch& a, const TissuePatch& b) {
  EXPECT_EQ(a.cuts, b.cuts);
  EXPECT_EQ(a.lo, b.lo);
  EXPECT_EQ(a.cut_lo, b.cut_lo);
  EXPECT_EQ(a.cut_hi, b.cut_hi);
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.tissue, b.tissue);
  EXPECT_EQ(a.hardness, b.hardness);
  EXPECT_EQ(a.filled_lo, b.filled_lo);
  EXPECT_EQ(a.filled_hi, b.filled_hi);
  ASSERT_EQ(a.coarse_levels.size(), b.coarse_levels.size());
  if (!a.coarse_levels.empty()) expect_equal(a.coarse_levels.front(), b.coarse_levels.front());
}

/// Checks that an updated patch has the bits of a newly extracted one. `fills`: true if there are fillings between the
/// cuts.
void update_patches(bool fills, const char* json) {
  const std::vector<Tool> tools = bur_with_shank_and_condenser();
  std::mt19937_64 random(5);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Carver kept(block(json), tools), fresh(block(json), tools);
  TissuePatch a = patch_for(tools), b = a;
  dvec3 at(0, 0, 2.2_mm);
  std::uint64_t index = 0;
  int filled = 0;
  for (int patch = 0; patch < 12; ++patch) {
    kept.take_snapshot(at, a);
    kept.remember_writes(true);
    for (int round = 0; round < 3; ++round) {
      for (int i = 0; i < 20; ++i) {
        Cut cut;
        cut.index = ++index;
        cut.t = static_cast<Nanos>(index) * 1'000'000;
        cut.X_WA.p = at;
        at += 20e-6 * dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1.5, 1));
        cut.X_WB.p = at;
        if (fills && i % 7 == 6) {
          cut.tool = 1;
          cut.fill_radius = uniform(0.1, 0.5) * kMillimetre;
          cut.X_WA.p = at + dvec3(uniform(-0.4, 0.4), 0, -0.7) * kMillimetre;
          ++filled;
        }
        kept.apply(cut);
        fresh.apply(cut);
      }
      ASSERT_TRUE(kept.bring_up_to_date(a));
    }
    fresh.take_snapshot(a.center_W, b);
    ASSERT_EQ(a.number, b.number);
    expect_equal(a, b);
  }
  EXPECT_EQ(filled > 50, fills);
}

TEST(PatchExchange, AnUpdatedPatchHasTheBitsOfANewlyExtractedOne) {
  for (const bool fills : {false, true})
    for (const char* json : {kBlock, kGradedBlock}) update_patches(fills, json);
}

/// Checks that a moved patch has the bits of a newly extracted one. `fills`: true if there are fillings between the
/// cuts.
void move_patches(bool fills) {
  // Two patches that alternate, as servo and carver exchange them. Their owner cuts in them, strokes are undone, and
  // steps are short, long, or longer than a patch is wide.
  const std::vector<Tool> tools = bur_with_shank_and_condenser();
  std::mt19937_64 random(11);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Carver carver(block(), tools);
  TissuePatch patches[] = {haptics::empty_patch_for(tools, 0.1_mm), haptics::empty_patch_for(tools, 0.1_mm)};
  dvec3 at(0, 0, 2.2_mm);
  std::uint64_t index = 0;
  int undone = 0;
  for (int round = 0; round < 60; ++round) {
    TissuePatch& patch = patches[round % 2];
    carver.take_snapshot(at, patch);
    TissuePatch anew = haptics::empty_patch_for(tools, 0.1_mm);
    carver.take_snapshot(at, anew, patch.number);
    expect_equal(patch, anew);
    for (int i = 0; i < 10; ++i) {
      Cut cut;
      cut.index = ++index;
      cut.t = static_cast<Nanos>(index) * 1'000'000;
      cut.X_WA.p = at;
      at += 20e-6 * dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1.5, 1));
      cut.X_WB.p = at;
      if (fills && i == 9 && round % 3 == 0) {
        cut.tool = 1;
        cut.fill_radius = uniform(0.1, 0.5) * kMillimetre;
      }
      carver.apply(cut);
      const haptics::Sweep sweep(tools[0], cut.X_WA, cut.X_WB, carver.volume().frame());
      haptics::carve(patch, sweep);  // as the servo does; the carver must copy the samples that this changes again
    }
    if (round % 7 == 6) undone += carver.undo();
    const double step = round % 5 == 4 ? 12 : round % 2 ? 0.7 : 0.1;  // mm
    at += dvec3(uniform(-step, step), uniform(-step, step), 0) * kMillimetre;
    at = dvec3(glm::clamp(at.x, -2.5_mm, 2.5_mm), glm::clamp(at.y, -2.5_mm, 2.5_mm), 2.2_mm);
  }
  EXPECT_GT(undone, 5);
}

TEST(TissuePatch, AMovedPatchHasTheBitsOfANewlyExtractedOne) {
  for (const bool fills : {false, true}) move_patches(fills);
}

TEST(TissuePatch, ConsistsOfWholeLeavesAndHoldsTheToolWithinItsTravel) {
  for (const double voxel : {0.05_mm, 0.1_mm, 0.2_mm}) {
    for (const double diameter : {0.6_mm, 1.2_mm, 4.0_mm}) {
      Tool tool;
      tool.diameter = tool.length = diameter;
      const std::array tools{tool};
      haptics::DenseTissue dense = haptics::read_solids(Json::parse(kBlock, "block"));
      dense.frame.voxel = voxel;
      Carver carver(haptics::TissueVolume(dense), tools);
      TissuePatch patch = haptics::empty_patch_for(tools, voxel);
      const double travel = haptics::patch_travel_for(tools, voxel), reach = tool.reach() / voxel;
      std::mt19937_64 random(3);
      std::uniform_real_distribution<double> place(-3e-3, 3e-3);
      for (int i = 0; i < 20; ++i) {
        const dvec3 wanted_W(place(random), place(random), place(random));
        carver.take_snapshot(wanted_W, patch);
        EXPECT_EQ(patch.n % 8, 0);
        EXPECT_EQ((patch.lo.x | patch.lo.y | patch.lo.z) & 7, 0);
        const dvec3 off = (patch.center_W - wanted_W) / voxel;
        EXPECT_LE(std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}), 4 + 1e-9);
        // At half of the travel a new patch becomes due, so the centre must be nearer than this to the wanted centre.
        EXPECT_FALSE(haptics::snapshot_due_for(wanted_W, patch.center_W, travel * voxel));
        const dvec3 center_V = dense.frame.to_voxels(patch.center_W);
        for (const double sign : {-1.0, 1.0}) EXPECT_TRUE(patch.holds(center_V + sign * travel, reach + 1));
        carver.take_snapshot(patch.center_W, patch);
        EXPECT_EQ(dense.frame.to_voxels(patch.center_W), center_V) << "the recorded centre gives the same patch";
      }
    }
  }
}

TEST(TissuePatch, IsCentredAheadOfAToolThatMoves) {
  HapticBench bench(kBlock, test::probe_settings("offset"));
  const double travel = haptics::patch_travel_for(std::array{bench.settings.tool}, 0.1_mm) * 0.1_mm;
  const dvec3 from(-2.0_mm, -1.0_mm, 2.5_mm);
  int ahead = 0, patches = 0;
  std::uint32_t last = 0;
  for (int i = 0; i < 100; ++i) {
    const dvec3 p = from + dvec3(30e-6 * i, 0, 0);  // 30 mm/s
    bench.tick({p});
    if (bench.last.patch == last || i < 20) continue;
    last = bench.last.patch;
    ++patches;
    ahead += bench.patch().center_W.x > p.x;
    // the tool is never farther than half of the travel from the centre, so the carver is not reported as late
    EXPECT_LE(std::abs(bench.patch().center_W.x - p.x), travel / 2 + 0.4_mm);
  }
  EXPECT_GT(patches, 1);
  EXPECT_EQ(ahead, patches);
  for (int i = 0; i < 60; ++i) {
    bench.tick({from + dvec3(3.0_mm, 0, 0)});
    EXPECT_EQ(bench.last.faults & bits(Fault::kStalePatch), 0u);
  }
}

/// Returns a hash of the forces and of the proxy's poses of a session: a bur with a shank slides over a block, and then
/// drills into it and moves to the side.
std::uint64_t hash_of_session() {
  haptics::ServoSettings settings = test::drill_settings("offset");
  settings.tool.shank_length = 5.0_mm, settings.tool.shank_diameter = 1.0_mm;
  HapticBench bench(kBlock, settings);
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](double value) { hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3u; };
  dvec3 p(-2.0_mm, -1.0_mm, 2.5_mm);
  for (int i = 0; i < 1500; ++i) {
    p += i < 150 ? dvec3(17e-6, 9e-6, 0) : i < 700 ? dvec3(0, 0, -1.5e-6) : dvec3(3e-6, -2e-6, 0);
    bench.tick({p}, i < 150 ? 0 : 1);
    for (const dvec3& v : {bench.last.f_T_W, bench.last.X_WG.p}) add(v.x), add(v.y), add(v.z);
    add(static_cast<double>(bench.last.patch));
  }
  return hash ^ bench.carver.volume().hash();
}

TEST(TissuePatch, TheForceLawGivesTheBitsOfItsVersion) {
  EXPECT_EQ(hash_of_session(), 0xdb5180a821829b24u) << "raise kForceLaw with this hash";
}

TEST(PatchExchange, TheServoTakesACompletePatchAndLeavesOthersToTheCarverFirst) {
  haptics::ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 1.2_mm;
  settings.spindle.free_speed = 300.0_krpm;
  HapticBench bench(kBlock, settings);
  PatchExchange exchange(bench.carver);
  ServoTick tick;
  Cut cut;
  std::vector<Cut> made;
  int i = 0;
  const auto drill = [&](int ticks) {
    for (const int end = i + ticks; i < end; ++i) {
      const Pose hand{{0.1_mm * std::sin(0.01 * i), 0, 2.6_mm - 2e-6 * i}};
      if (bench.servo.tick({i * 1'000'000LL, hand, 1}, tick, cut)) made.push_back(cut);
    }
  };
  const auto carve = [&] {
    for (const Cut& c : made) bench.carver.apply(c);
    made.clear();
  };
  const auto take = [&](Nanos t) {
    test::NoAlloc guard;
    haptics::Snapshot* const patch = exchange.take(bench.patch(), tick.cuts, t);
    if (patch) bench.servo.adopt(*patch);
    EXPECT_EQ(guard.count(), 0u);
    return patch != nullptr;
  };
  exchange.offer(bench.carver, {0, 0, 2.6_mm});
  EXPECT_TRUE(take(1)) << "the first one";
  EXPECT_FALSE(exchange.keep_up(bench.carver, bench.patch().number)) << "it has been taken";
  drill(200);
  ASSERT_GT(made.size(), 50u);
  carve();

  // The second of two patches is complete, and not a step from the servo's patch.
  exchange.offer(bench.carver, {0, 0, 2.3_mm});
  exchange.offer(bench.carver, {0, 0, 2.4_mm});
  drill(5);
  ASSERT_FALSE(made.empty());
  EXPECT_FALSE(take(10)) << "it lacks cuts";
  carve();
  EXPECT_TRUE(exchange.keep_up(bench.carver, tick.patch));
  EXPECT_EQ(tick.patch, 1u);
  EXPECT_TRUE(take(11));
  EXPECT_EQ(bench.patch().number, 3u);
  EXPECT_EQ(bench.patch().cuts, tick.cuts);
  drill(1);
  EXPECT_EQ(tick.patch, 3u);
  EXPECT_FALSE(exchange.keep_up(bench.carver, tick.patch));
  carve();

  // A step needs no cuts from the carver.
  exchange.offer(bench.carver, {0, 0, 3.0_mm});
  drill(3);
  ASSERT_FALSE(made.empty());
  EXPECT_TRUE(take(12)) << "a step";
  EXPECT_EQ(bench.patch().from, 3u);
  carve();
  drill(1);
  EXPECT_FALSE(exchange.keep_up(bench.carver, tick.patch));
  carve();

  // The exchange must not wait for ever for a carver that is too slow.
  exchange.offer(bench.carver, {0, 0, 2.4_mm});
  exchange.offer(bench.carver, {0, 0, 2.5_mm});
  drill(3);
  EXPECT_FALSE(take(1'000'000));
  EXPECT_FALSE(take(4'000'000));
  EXPECT_TRUE(take(7'000'000)) << "brought up to date by the servo itself";
  carve();
  drill(1);
  EXPECT_FALSE(exchange.keep_up(bench.carver, tick.patch));

  // The exchange also does not wait for tissue that an undo restored, and does not change it on its way.
  carve();
  ASSERT_TRUE(bench.carver.undo());
  exchange.offer(bench.carver, {0, 0, 2.5_mm});
  drill(2);
  const std::uint64_t cuts = tick.cuts - made.size();
  carve();
  EXPECT_TRUE(exchange.keep_up(bench.carver, tick.patch));
  EXPECT_TRUE(take(8'000'000));
  EXPECT_EQ(bench.patch().cuts, cuts);
  TissuePatch check = bench.empty_patch();
  bench.carver.volume().copy(bench.patch().lo, glm::ivec3(check.n), check.distance.data(), check.tissue.data());
  EXPECT_EQ(bench.patch().distance, check.distance);
}

/// Checks that the patch that the servo uses contains the bits of the volume.
void expect_bits_of_volume(const TissuePatch& patch, const haptics::TissueVolume& volume, int tick) {
  TissuePatch check;
  check.resize(patch.n);
  if (volume.graded()) check.grade();
  volume.copy_for_patch(patch.lo, glm::ivec3(patch.n), check.distance.data(), check.tissue.data(),
                        volume.graded() ? check.hardness.data() : nullptr);
  ASSERT_EQ(patch.distance, check.distance) << tick;
  ASSERT_EQ(patch.tissue, check.tissue) << tick;
  ASSERT_EQ(patch.hardness, check.hardness) << tick;
  for (std::size_t i = 0; i < patch.tissue.size(); ++i) {
    if (!haptics::is_filled(patch.tissue[i])) continue;
    const int at = static_cast<int>(i), n = patch.n;
    const glm::ivec3 voxel = patch.lo + glm::ivec3(at / (n * n), at / n % n, at % n);
    ASSERT_TRUE(glm::all(glm::lessThanEqual(patch.filled_lo, voxel))) << tick;
    ASSERT_TRUE(glm::all(glm::greaterThanEqual(patch.filled_hi, voxel))) << tick;
  }
}

// A hand drills or fills, leaves the tissue quickly, and undoes strokes, for both kinds of tissue: with and without
// hardness per voxel. The snapshots lack up to four cuts that the servo has already made.
TEST(TissuePatch, OfTheServoHasTheBitsOfTheVolumeAfterEveryStep) {
  constexpr const char* kGraded =
      R"({"voxel_mm": 0.1, "band_mm": 1.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}},
          {"tissue": "dentin", "hardness": 0.5, "solid": {"sphere": {"center_mm": [0.5, 0, 2], "radius_mm": 0.8}}}]})";
  for (const int session : {0, 1, 2, 3}) {
    const char* const tissue = session % 2 ? kGraded : kBlock;
    const bool fills = session > 1;
    haptics::ServoSettings settings = test::drill_settings("offset");
    settings.tools = bur_with_shank_and_condenser();
    if (fills) std::swap(settings.tools[0], settings.tools[1]);
    settings.tool = settings.tools[0];
    HapticBench bench(tissue, settings);
    EXPECT_EQ(bench.carver.volume().graded(), tissue == kGraded);
    std::mt19937_64 random(17);
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    ServoTick tick;
    Cut cut;
    std::deque<std::uint64_t> made;  // indices of the cuts that the carver has not made yet
    dvec3 p{0, 0, 3.0_mm}, way{0};
    int steps = 0, complete = 0, late = 0, filled = 0, compared = 0;
    for (int i = 0; i < 4000; ++i) {
      // Every 40 ticks, the hand takes another direction; sometimes it leaps through the air.
      if (i % 40 == 0) way = 12e-6 * dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 0.8));
      if (i % 1000 == 999) p.z = 3.2_mm, p.x = uniform(-1.8, 1.8) * kMillimetre;
      p = glm::clamp(p + way, dvec3(-2.0_mm, -2.0_mm, 1.8_mm), dvec3(2.0_mm, 2.0_mm, 3.3_mm));
      if (i == 0) tick.X_WT = tick.X_WG = {p};
      if (i % 1000 == 899) {
        bench.steps.apply_cuts(UINT64_MAX), made.clear();
        EXPECT_TRUE(bench.carver.undo());
        if (i % 2000 == 1899) {
          EXPECT_TRUE(bench.carver.redo());
        }
      }
      const int lacking = static_cast<int>(uniform(0, 5));
      if (made.size() > static_cast<std::size_t>(lacking))
        bench.steps.apply_cuts(made[made.size() - 1 - static_cast<std::size_t>(lacking)]);
      if (bench.carver.snapshot_due(tick)) {
        const std::uint32_t held = bench.patch().number;
        late += bench.carver.cuts() < tick.cuts;
        bench.steps.take_snapshot(bench.carver.snapshot_center(tick));
        bench.steps.adopt_snapshot();
        ++(bench.patch().from == held && held != 0 ? steps : complete);
      }
      if (bench.steps.tick_servo({i * 1'000'000LL, {p}, 1}, tick, cut)) {
        made.push_back(cut.index);
        filled += cut.fill_radius > 0;
      }
      if (i % 20 != 0) continue;
      bench.steps.apply_cuts(UINT64_MAX), made.clear();
      // After an undo or the removal of a loose piece, the servo's patch equals the volume only after the next
      // snapshot.
      if (bench.carver.snapshot_due(tick)) continue;
      expect_bits_of_volume(bench.patch(), bench.carver.volume(), i);
      if (HasFatalFailure()) return;
      ++compared;
    }
    EXPECT_GT(steps, 20);
    EXPECT_GT(complete, 2);
    EXPECT_GT(late, 10);
    if (fills) {
      EXPECT_GT(filled, 20);
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(TissuePatch, ACubicQueryGivesTheSameBitsForEverySimdWidth) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> distance(-12, 12);
  std::uniform_real_distribution<double> fraction(0, 1);
  std::vector<float> samples(6 * 6 * 8);
  for (int i = 0; i < 2000; ++i) {
    for (float& sample : samples) sample = distance(random);
    const double fractions[3] = {fraction(random), i % 10 ? fraction(random) : 0, fraction(random)};
    std::array<double, 4> narrow, wide;
    haptics::cubic(samples.data(), 48, 8, fractions, narrow.data(), 2);
    for (int lanes = 4; lanes <= haptics::widest_cubic(); lanes *= 2) {
      haptics::cubic(samples.data(), 48, 8, fractions, wide.data(), lanes);
      ASSERT_EQ(wide, narrow) << lanes << " lanes, " << i;
    }
  }
}

TEST(TissuePatch, ACubicQueryReproducesACubicAndAConstantHasZeroGradient) {
  std::vector<float> samples(6 * 6 * 8);
  const auto query = [&](auto field, const dvec3& at) {
    for_each_voxel({6, 6, 8}, [&](int x, int y, int z) {
      samples[static_cast<std::size_t>((x * 6 + y) * 8 + z)] = static_cast<float>(field(x - 2, y - 2, z - 4));
    });
    std::array<double, 4> out;
    haptics::cubic(samples.data(), 48, 8, &at.x, out.data(), haptics::widest_cubic());
    return out;
  };
  const dvec3 p(0.3125, 0.71875, 0.171875);  // whole numbers of samples make every float exact
  const auto cubic = [](double x, double y, double z) {
    return x * x * x - 2 * y * y * y + 3 * z * z * z + x * y * z - 4 * y * y + 5;
  };
  const auto out = query(cubic, p);
  EXPECT_NEAR(out[0], cubic(p.x, p.y, p.z), 1e-6);
  EXPECT_NEAR(out[1], 3 * p.x * p.x + p.y * p.z, 1e-6);
  EXPECT_NEAR(out[2], -6 * p.y * p.y + p.x * p.z - 8 * p.y, 1e-6);
  EXPECT_NEAR(out[3], 9 * p.z * p.z + p.x * p.y, 1e-6);
  const auto constant = query([](int, int, int) { return 11.25; }, p);
  EXPECT_NEAR(constant[0], 11.25, 1e-13);
  for (int axis = 1; axis < 4; ++axis) EXPECT_NEAR(constant[static_cast<std::size_t>(axis)], 0, 1e-13);
}

TEST(MissingPatch, AHandThatJumpsThroughASheetAgainAndAgainIsPulledBackByTheFullForceEachTime) {
  const haptics::ServoSettings settings = test::probe_settings("offset");
  test::HapticBench bench(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6, 6, 1]}}}]})", settings);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(-1e-3, 1e-3);
  for (int k = 0; k < 20; ++k) {
    const dvec3 above(anywhere(random), anywhere(random), 3e-3);
    for (int i = 0; i < 3; ++i) bench.tick({dvec3(0, 0, 0.2)});
    for (int i = 0; i < 20; ++i) bench.tick({above});
    const dvec3 below = above - dvec3(0, 0, 20e-3);
    for (int i = 0; i < 100; ++i) bench.tick({below});
    EXPECT_NEAR(bench.last.X_WG.p.z, 0.5e-3 + 0.6e-3, 1e-6) << k;
    EXPECT_NEAR(bench.last.f_T_W.z, settings.stiffness * (1.1e-3 + 17e-3), 0.1) << k;
  }
}

TEST(MissingPatch, AHandThatIsManyPatchesAheadDoesNotMoveTheHeadThroughASheet) {
  // The head follows patch by patch, at most 0.9 mm per tick, so it needs up to 20 ticks. No patch is late meanwhile.
  const haptics::ServoSettings settings = test::probe_settings("offset");
  test::HapticBench bench(
      R"({"voxel_mm": 0.05, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6, 6, 1]}}}]})", settings);
  for (const double from : {6e-3, 10e-3, 14e-3, 17e-3}) {
    for (int i = 0; i < 3; ++i) bench.tick({dvec3(0, 0, 0.2)});
    for (int i = 0; i < 20; ++i) bench.tick({dvec3(0, 0, from)});
    for (int i = 0; i < 100; ++i) bench.tick({dvec3(0, 0, from - 19e-3)});
    EXPECT_NEAR(bench.last.X_WG.p.z, 0.5e-3 + 0.6e-3, 1e-6) << from;
  }
}

}  // namespace
}  // namespace typodont
