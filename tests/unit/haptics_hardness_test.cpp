// Tests hardness per voxel: its effect on force and cutting, and where it is stored.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/cutting/carve.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/cutting/inside_fraction.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/program.h"
#include "tests/support/swinging_hand.h"
#include "tests/support/undo_redo.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::hardness_byte;
using haptics::hardness_fraction;
using haptics::kOwnHardness;
using haptics::ServoSettings;
using haptics::Sweep;
using haptics::TissuePatch;
using haptics::TissueVolume;
using haptics::Tool;
using test::HapticBench;

constexpr auto kDentin = static_cast<std::size_t>(Tissue::kDentin);
constexpr double kDentinEnergy = 8e9;  // J/m³, of test::plain_materials()

/// Returns a block of dentin with its top at z = 2.5 mm. If `hardness` is empty, the block's JSON has no hardness.
std::string block(const std::string& hardness = "") {
  return fmt::format(
      R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "dentin"{}, "solid": {{"box": {{"size_mm": [5, 5, 5]}}}}}}]}})",
      hardness.empty() ? "" : ", \"hardness\": " + hardness);
}

/// Hardness of the same block in three layers of 1.2 mm. The softest layer is at the top; the lowest extends to the
/// floor.
constexpr std::array kLayers = {0.3, 0.6, 1.0};
std::string layered() {
  return R"({"voxel_mm": 0.1, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [5, 5, 5]}}},
    {"tissue": "dentin", "hardness": 0.6, "solid": {"box": {"center_mm": [0, 0, 1.3], "size_mm": [5, 5, 2.4]}}},
    {"tissue": "dentin", "hardness": 0.3, "solid": {"box": {"center_mm": [0, 0, 1.9], "size_mm": [5, 5, 1.2]}}}]})";
}

TissueVolume sampled(const std::string& json) {
  return TissueVolume(haptics::read_solids(Json::parse(json, "tissue")));
}

/// Returns a block whose hardness increases by one byte per voxel along z.
haptics::DenseTissue graded_block() {
  haptics::DenseTissue dense = haptics::read_solids(Json::parse(block("0.5"), "tissue"));
  for_each_voxel(dense.size,
                 [&](int x, int y, int z) { dense.hardness[dense.at(x, y, z)] = static_cast<std::uint8_t>(10 + z); });
  return dense;
}

ServoSettings probe() {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 1.0_mm;
  s.tool.cuts = false;
  s.friction = false;
  s.damping = 0;
  return s;
}

ServoSettings drill() {
  ServoSettings s;
  s.tool.diameter = s.tool.length = 1.2_mm;
  s.spindle.free_speed = 300.0_krpm;
  return s;
}

/// Returns the force on a ball that is pressed 0.3 mm deep into a face, from `from` in the direction `toward`.
double felt(const std::string& tissue, const dvec3& from = {0, 0, 3.2_mm}, const dvec3& toward = {0, 0, -1}) {
  HapticBench bench(tissue, probe());
  for (double way = 0; way < 0.5_mm; way += 2e-6) bench.tick({from + way * toward});
  for (int i = 0; i < 300; ++i) bench.tick({from + 0.5_mm * toward});
  EXPECT_NEAR(bench.last.depth, 0.3_mm, 2e-6);
  return glm::length(bench.last.f_T_W);
}

TEST(Hardness, ScalesTheStiffnessOfTheTissue) {
  const double whole = felt(block());
  EXPECT_NEAR(whole, 500 * 0.3e-3, 1e-3 * whole);
  for (const double hardness : {0.1, 0.5, 0.8, 1.0}) {
    const double fraction = hardness_fraction(hardness_byte(hardness));
    EXPECT_NEAR(fraction, hardness, 0.5 / 255);
    EXPECT_NEAR(felt(block(fmt::format("{}", hardness))) / whole, fraction, 1e-3) << hardness;
  }
}

/// Volume that a hand removes when it pushes straight down with 1 N, and the work of the spindle, while the bur's
/// lowest point is between two heights (m).
struct Drilled {
  double volume = 0, work = 0;
};
Drilled drilled(const std::string& tissue, double top, double bottom, double seconds) {
  HapticBench bench(tissue, drill());
  test::DrillingHand hand{bench, {0, 0, 3.12_mm}};
  Drilled run;
  for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
    const double before = total(bench.last.removed);
    const ServoTick& tick = hand.move({0, 0, -1});
    const double lowest = tick.X_WG.p.z - 0.6_mm;
    if (lowest > top || lowest < bottom) continue;
    run.volume += total(tick.removed) - before;
    run.work += tick.cutting_power * bench.settings.tick;
  }
  return run;
}

/// Felt stiffness, N/m, of a ball of 1.2 mm whose hand presses it 0.3 mm deep into the top (z = 0) of these solids at
/// x.
std::vector<double> felt_stiffness(const char* model, const std::string& solids, const std::vector<double>& at) {
  std::vector<double> stiffness;
  for (const double x : at) {
    HapticBench bench(R"({"voxel_mm": 0.05, "solids": )" + solids + "}", test::probe_settings(model));
    for (int i = 0; i < 300; ++i) bench.tick({{x, 0, 0.6e-3 - 2e-6 * std::min(i, 150)}});
    stiffness.push_back(glm::length(bench.last.f_T_W) / glm::distance(bench.last.X_WG.p, bench.last.X_WT.p));
  }
  return stiffness;
}

constexpr const char* kMean = R"({"offset": {"mean_stiffness": true}})";

TEST(MeanStiffness, ChangesOverTheWidthOfTheContactAtABorderWhereTheContactPointsJumps) {
  const std::string border =
      R"([{"tissue": "enamel", "solid": {"box": {"center_mm": [-1.5, 0, -1], "size_mm": [3, 4, 2]}}},
    {"tissue": "dentin", "solid": {"box": {"center_mm": [1.5, 0, -1], "size_mm": [3, 4, 2]}}}])";
  const std::vector<double> at{-0.8_mm, -0.25_mm, -0.06_mm, 0.06_mm, 0.25_mm, 0.8_mm};
  const std::vector<double> mean = felt_stiffness(kMean, border, at), point = felt_stiffness("offset", border, at);
  EXPECT_NEAR(point[2] - point[3], 500, 5) << "within 0.12 mm";
  EXPECT_NEAR(mean.front(), 1000, 1);
  EXPECT_NEAR(mean.back(), 500, 1);
  EXPECT_LT(mean[2] - mean[3], 130);
  EXPECT_NEAR(mean[2] + mean[3], 1500, 50);
  EXPECT_GT(mean[1], mean[2]);
  EXPECT_GT(mean[3], mean[4]);
}

TEST(MeanStiffness, OfAThinSheetOfEnamelIsThatOfTheLayersInTheHead) {
  const std::string sheet = R"([{"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -1], "size_mm": [4, 4, 2]}}},
    {"tissue": "enamel", "solid": {"box": {"center_mm": [0, 0, -0.05], "size_mm": [4, 4, 0.1]}}}])";
  const auto cap = [](double depth) { return depth * depth * (3 * 0.6 - depth); };  // mm³ · 3 / π
  const double enamel = 1 - cap(0.2) / cap(0.3);
  EXPECT_NEAR(felt_stiffness("offset", sheet, {0}).front(), 1000, 1);
  EXPECT_NEAR(felt_stiffness(kMean, sheet, {0}).front(), 500 + 500 * enamel, 70) << "the points are 0.1 mm apart";
}

TEST(Hardness, TheVolumePerJouleInThreeLayersIsInverselyProportionalToTheirHardness) {
  // Drills through all layers in one run. While the bur's end is in the middle of a layer, the bur cuts nearly only
  // this layer. Only its flank, which reaches at most 0.6 mm up, also cuts the layer above.
  double last = 1e300;
  for (std::size_t i = 0; i < kLayers.size(); ++i) {
    const double top = 2.5_mm - 1.2_mm * static_cast<double>(i);
    const Drilled run = drilled(layered(), top - 0.75_mm, top - 1.15_mm, 20);
    ASSERT_GT(run.volume, 0.1_mm3) << i;
    const double per_joule = run.volume / run.work;
    EXPECT_NEAR(per_joule * kDentinEnergy * hardness_fraction(hardness_byte(kLayers[i])), 1, 0.02) << i;
    EXPECT_LT(per_joule, last);
    last = per_joule;
  }
}

TEST(Hardness, IsSampledWithTheTrilinearWeightsOfTheLabels) {
  haptics::Carver carver(TissueVolume(graded_block()), std::array{probe().tool});
  TissuePatch patch;
  patch.resize(41);
  carver.take_snapshot({0, 0, 0}, patch);
  ASSERT_EQ(patch.hardness.size(), patch.tissue.size());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(-1.5, 1.5);
  const VoxelFrame& frame = carver.volume().frame();
  for (int i = 0; i < 1000; ++i) {
    const dvec3 p_V = frame.to_voxels(dvec3(within(random), within(random), within(random)) * kMillimetre);
    // Trilinear interpolation reproduces a linear hardness exactly.
    EXPECT_NEAR(sample_hardness(patch, p_V)[kDentin], (10 + p_V.z) / 255, 1e-12);
    EXPECT_EQ(sample_tissue(patch, p_V)[kDentin], 1);
    EXPECT_NEAR(hardness_at(patch, p_V), (10 + std::floor(p_V.z + 0.5)) / 255, 1e-12);
  }
}

/// Returns the volume that each tissue lost, in which each sample's fraction is multiplied by its hardness. Computed
/// sample by sample.
PerTissue hardened_one_by_one(const std::vector<float>& before, const std::vector<Tissue>& labels,
                              const TissuePatch& patch) {
  std::array<std::int64_t, kTissueCount> sums{};
  for (std::size_t at = 0; at < before.size(); ++at) {
    const std::int64_t lost = haptics::inside_units(before[at]) - haptics::inside_units(patch.distance[at]);
    const int hardness = haptics::is_filled(labels[at]) ? kOwnHardness : patch.hardness[at];
    sums[static_cast<std::size_t>(haptics::shown(labels[at]))] += lost * hardness;
  }
  PerTissue hardened{};
  for (std::size_t t = 1; t < sums.size(); ++t)
    hardened[t] = static_cast<double>(sums[t]) * haptics::kFractionUnit / kOwnHardness;
  return hardened;
}

TEST(Hardness, TheCostOfACutIsTheSumOverAllSamplesForEveryHeadPathAndFilling) {
  using haptics::HeadShape;
  std::mt19937_64 random(28);
  std::uniform_real_distribution<double> within(-1, 1);
  std::uniform_int_distribution<int> byte(1, 255);
  const TissueVolume volume(graded_block());
  for (const HeadShape shape : {HeadShape::kSphere, HeadShape::kCylinder, HeadShape::kFlame}) {
    Tool bur;
    bur.shape = shape;
    bur.diameter = 1.2_mm;
    bur.length = shape == HeadShape::kSphere ? 1.2_mm : 2.4_mm;
    for (const bool listed : {false, true}) {
      haptics::Carver carver(volume.clone(), std::array{bur});
      TissuePatch patch;
      patch.resize(75);
      carver.take_snapshot({0, 0, 2.0_mm}, patch);
      for (std::size_t at = 0; at < patch.tissue.size(); ++at) {
        patch.hardness[at] = static_cast<std::uint8_t>(byte(random));
        if (patch.tissue[at] != Tissue::kAir && byte(random) < 40)
          patch.tissue[at] = haptics::filled(patch.tissue[at], Tissue::kComposite);
      }
      patch.filled_lo = patch.lo, patch.filled_hi = patch.lo + patch.n - 1;
      haptics::CutFront front(std::array{bur}, volume.frame().voxel);
      Pose at{{0, 0, 2.5_mm + bur.half()}};
      double most = 0;
      for (int i = 0; i < 60; ++i) {
        // First makes slow cuts, which use the lists of active samples; then fast cuts that rotate the head.
        const double step = i < 30 ? 0.003_mm : i < 45 ? 0.03_mm : 0.3_mm;
        Pose to = at;
        to.p += step * dvec3(within(random), within(random), within(random) - (i < 45 ? 0.6 : 0));
        if (i >= 45) to.R = glm::normalize(to.R * glm::angleAxis(0.1 * within(random), dvec3(0.6, 0, 0.8)));
        const std::vector<float> before(patch.distance.data(), patch.distance.data() + patch.distance.size());
        const std::vector<Tissue> labels(patch.tissue.data(), patch.tissue.data() + patch.tissue.size());
        bool changed;
        PerTissue hardened;
        carve(patch, Sweep(bur, at, to, volume.frame(), i > 0), &changed, listed ? &front : nullptr, &hardened);
        ASSERT_EQ(hardened, hardened_one_by_one(before, labels, patch)) << static_cast<int>(shape) << ", cut " << i;
        most = std::max(most, hardened[kDentin]);
        at = to;
      }
      EXPECT_GT(most, 1);
    }
  }
}

TEST(Hardness, IsFeltByAShankInItsCoarserPatch) {
  const auto leant = [](const std::string& hardness) {
    ServoSettings s = probe();
    s.tool.shank_length = 8.0_mm;
    s.tool.shank_diameter = 1.6_mm;
    s.tool.neck_diameter = 0.6_mm;
    s.tool.neck_length = 2.0_mm;
    HapticBench bench(fmt::format(R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "enamel"{}, "solid": {{"box":
      {{"center_mm": [2.5, 0, 6], "size_mm": [5, 8, 6]}}}}}}]}})",
                                  hardness),
                      s);
    for (double x = -1.2_mm; x < -0.6_mm; x += 20e-6) bench.tick({{x, 0, 0}});
    for (int i = 0; i < 200; ++i) bench.tick({{-0.6_mm, 0, 0}});
    return glm::length(bench.last.f_T_W);
  };
  EXPECT_NEAR(leant(R"(, "hardness": 0.4)") / leant(""), 0.4, 0.01);
}

TEST(Hardness, UniformHardnessGivesTheSameTicksAndNeedsNoMemory) {
  HapticBench plain(block(), drill()), own(block("1"), drill());
  EXPECT_FALSE(own.carver.volume().graded());
  for (int i = 0; i < 1500; ++i) {
    const Pose hand{{0.3_mm * std::sin(0.01 * i), 0, 3.2_mm - 0.8e-6 * i}};
    const ServoTick &a = plain.tick(hand, 1), &b = own.tick(hand, 1);
    ASSERT_EQ(a.f_T_W, b.f_T_W);
    ASSERT_EQ(a.removed, b.removed);
  }
  EXPECT_GT(total(plain.last.removed), 0);
  EXPECT_EQ(plain.carver.volume().hash(), own.carver.volume().hash());
  EXPECT_EQ(plain.patch().hardness.size(), 0u);
}

/// Labels, hardness and colours of a box around all tissue.
struct Bytes {
  std::vector<Tissue> labels;
  std::vector<std::uint8_t> hardness;
  std::vector<VoxelColor> colors;
  bool operator==(const Bytes&) const = default;
};
Bytes bytes_of(const TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  const auto count = static_cast<std::size_t>(size.x * size.y * size.z);
  Bytes bytes{std::vector<Tissue>(count), std::vector<std::uint8_t>(count), std::vector<VoxelColor>(count)};
  volume.copy_for_patch(lo, size, nullptr, bytes.labels.data(), bytes.hardness.data());
  volume.copy_colors(lo, size, bytes.colors.data());
  return bytes;
}

struct HardnessFile : testing::Test {
  const test::Folder folder;
  const std::filesystem::path file = folder / "block.vdb";
};

TEST_F(HardnessFile, StoresEveryValueAlsoDeepInside) {
  struct Case {
    std::string json;
    dvec3 deep_W;  // m, far inside
    double hardness;
  };
  const Case cases[] = {{layered(), {0, 0, 0}, 1},
                        // Some leaves are within one tile of the volume, others beside it.
                        {R"({"voxel_mm": 0.1, "band_mm": 0.4, "solids": [
          {"tissue": "dentin", "hardness": 0.7, "solid": {"box": {"size_mm": [10, 10, 10]}}},
          {"tissue": "caries", "hardness": 0.2, "solid": {"sphere": {"radius_mm": 0.35}}}]})",
                         {0, 0, 0},
                         0.2},
                        // 128³ voxels below a surface at x = 14 mm. The volume stores them as a single tile.
                        {R"({"voxel_mm": 0.1, "band_mm": 0.4, "domain_mm": [[0, 0, 0], [14.4, 12.7, 12.7]], "solids": [
          {"tissue": "dentin", "hardness": 0.7, "solid": {"halfspace": {"normal": [1, 0, 0], "offset_mm": 14}}}]})",
                         {6.0_mm, 6.0_mm, 6.0_mm},
                         0.7}};
  for (const Case& each : cases) {
    const TissueVolume volume = sampled(each.json);
    volume.save(file);
    const TissueVolume loaded = TissueVolume::load(file);
    EXPECT_TRUE(loaded.graded());
    EXPECT_TRUE(bytes_of(loaded) == bytes_of(volume));
    for (std::size_t i = 0; i < kTissueCount; ++i)
      EXPECT_NEAR(loaded.hardness_volumes()[i], volume.hardness_volumes()[i], 1e-6 * volume.volumes()[i]);
    std::uint8_t deep = 0;
    loaded.copy(glm::ivec3(glm::round(loaded.frame().to_voxels(each.deep_W))), glm::ivec3(1), nullptr, nullptr, &deep);
    EXPECT_EQ(deep, hardness_byte(each.hardness));
  }
}

TEST_F(HardnessFile, OfTissueThatIsNotGradedNamesNoHardnessAndTheHashCoversIt) {
  const TissueVolume plain = sampled(block()), graded = sampled(block("0.5"));
  plain.save(file);
  EXPECT_EQ(test::read_text(file).find("hardness"), std::string::npos);
  const TissueVolume loaded = TissueVolume::load(file);
  EXPECT_FALSE(loaded.graded());
  graded.save(file);
  EXPECT_NE(test::read_text(file).find("hardness"), std::string::npos);
  EXPECT_NE(TissueVolume::load(file).hash(), loaded.hash());
  EXPECT_NE(graded.hash(), plain.hash());
  EXPECT_EQ(plain.volumes(), graded.volumes());
}

TEST_F(HardnessFile, AValueOutOfRangeIsRefusedWithItsPlace) {
  haptics::DenseTissue dense = graded_block();
  dense.hardness[dense.at(dense.size.x / 2, dense.size.y / 2, dense.size.z / 2)] = 0;
  TissueVolume(dense).save(file);
  EXPECT_THAT(test::refusal([&] { (void)TissueVolume::load(file); }),
              testing::HasSubstr("hardness: found 0, expected 1 to 255"));
}

TEST(Hardness, ValuesOutOfRangeAreRefusedAndZeroBecomesTheSmallestValue) {
  for (const char* wrong : {"-0.1", "1.01", "\"soft\""}) EXPECT_THROW(sampled(block(wrong)), Error) << wrong;
  EXPECT_EQ(hardness_byte(0), 1);
  EXPECT_EQ(hardness_byte(1), kOwnHardness);
}

TEST(Hardness, AndColourAreUndoneAndRedoneWithTheirStrokeAndTheColourIsKeptByCuts) {
  TissueVolume volume = sampled(block());
  Tool bur;
  bur.diameter = bur.length = 1.2_mm;
  std::vector<std::uint64_t> hashes{volume.hash()};
  std::vector<Bytes> bytes{bytes_of(volume)};
  for (int i = 0; i < 6; ++i) {
    volume.begin_stroke();
    if (i % 2 == 0) {
      volume.paint(Tissue::kCaries, *haptics::capsule({0, 0, 2.2_mm}, {0.3_mm * i, 0, 2.0_mm}, 0.8_mm),
                   static_cast<std::uint8_t>(40 * (i + 1)), static_cast<VoxelColor>(0x9001 + 4000 * i));
    } else {
      const Pose a{{0, 0.1_mm * i, 2.8_mm}}, b{{0.5_mm, 0, 2.2_mm}};
      volume.carve(Sweep(bur, a, b, volume.frame()));
    }
    hashes.push_back(volume.hash());
    bytes.push_back(bytes_of(volume));
    ASSERT_NE(hashes[hashes.size() - 2], hashes.back());
    EXPECT_EQ(bytes.back().colors == bytes[bytes.size() - 2].colors, i % 2 == 1);
  }
  test::expect_undone_and_redone(volume, hashes, bytes, bytes_of);
}

TEST(Hardness, AFillingHasItsOwnHardnessAndColourAndCuttingItOutRestoresTheTissues) {
  Tool plugger;
  plugger.shape = haptics::HeadShape::kRoundEndCylinder;
  plugger.diameter = 1.0_mm;
  plugger.length = 3.0_mm;
  plugger.cuts = false;
  plugger.fill = Tissue::kComposite;
  plugger.fill_rate = 2 * kCubicMillimetre;
  plugger.fill_reach = 0.6_mm;
  Tool bur;
  bur.diameter = bur.length = 1.4_mm;
  TissueVolume volume = sampled(block(R"(0.4, "color": [0.2, 0.3, 0.9])"));
  const Pose hole{{0, 0, 2.3_mm}};
  volume.carve(Sweep(bur, hole, hole, volume.frame()));
  const Bytes before = bytes_of(volume);

  haptics::Carver carver(volume.clone(), std::array{plugger, bur});
  Cut cut;
  cut.index = 1;
  cut.X_WA.p = {0, 0, 1.8_mm};
  cut.X_WB.p = {0, 0, 9.0_mm};
  cut.fill_radius = 0.5_mm;
  carver.apply(cut);
  TissuePatch patch;
  patch.resize(41);
  carver.take_snapshot({0, 0, 2.0_mm}, patch);
  const dvec3 in_filling = volume.frame().to_voxels({0, 0, 1.9_mm});
  ASSERT_EQ(tissue_at(patch, in_filling), Tissue::kComposite);
  EXPECT_EQ(hardness_at(patch, in_filling), 1);
  EXPECT_EQ(sample_hardness(patch, in_filling), sample_tissue(patch, in_filling));
  std::uint8_t filled = 0;
  carver.volume().copy(glm::ivec3(glm::round(in_filling)), glm::ivec3(1), nullptr, nullptr, &filled);
  EXPECT_EQ(filled, kOwnHardness);
  EXPECT_EQ(carver.volume().color_at(in_filling), glm::vec4(0));

  // The volume comes from a file. It is then cut, in the patch and in the volume.
  const test::Folder folder;
  carver.volume().save(folder / "filled.vdb");
  TissueVolume loaded = TissueVolume::load(folder / "filled.vdb");
  EXPECT_TRUE(bytes_of(loaded) == bytes_of(carver.volume()));
  EXPECT_FALSE(bytes_of(loaded) == before);
  for (TissueVolume* each : {&carver.volume(), &loaded}) {
    each->carve(Sweep(bur, hole, hole, volume.frame()));
    EXPECT_TRUE(bytes_of(*each) == before);
  }
  carve(patch, Sweep(bur, hole, hole, volume.frame()));
  const dvec3 wall = volume.frame().to_voxels({0, 0, 1.55_mm});
  EXPECT_EQ(tissue_at(patch, wall), Tissue::kDentin);
  EXPECT_EQ(hardness_at(patch, wall), hardness_fraction(hardness_byte(0.4)));
}

}  // namespace
}  // namespace typodont
