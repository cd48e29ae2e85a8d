// Tests of pieces that cuts separate from the tissue. They are found, removed and counted in the volumes. The remaining
// tissue is one connected body.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "engine/base/units.h"
#include "tests/support/haptic_bench.h"

namespace typodont::haptics {
namespace {

using test::HapticBench;

constexpr std::string_view kMushroom = R"({"voxel_mm": 0.1, "band_mm": 1.2, "solids": [
  {"tissue": "dentin", "solid": {"union": [
    {"box": {"center_mm": [0, 0, -2], "size_mm": [8, 6, 2]}},
    {"cylinder": {"center_mm": [0, 0, 0], "radius_mm": 0.4, "height_mm": 3}},
    {"box": {"center_mm": [0, 0, 1.6], "size_mm": [2, 2, 1]}}]}}]})";

Tool round_bur(double diameter) {
  Tool tool;
  tool.diameter = diameter;
  return tool;
}

TissueVolume tissue(std::string_view json) {
  return TissueVolume(read_solids(Json::parse(std::string(json), "tissue")));
}
std::size_t bodies(const TissueVolume& volume) {
  return LoosePieces(volume).bodies();
}

/// Makes a straight cut in steps of 0.1 mm. Returns the pieces that the carver removed in addition.
std::vector<LoosePiece> saw(Carver& carver, const dvec3& from_mm, const dvec3& to_mm) {
  std::vector<LoosePiece> pieces;
  const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(to_mm - from_mm) / 0.1)));
  for (int i = 0; i < steps; ++i) {
    Cut cut;
    cut.index = carver.cuts() + 1;
    cut.t = static_cast<Nanos>(cut.index) * 1'000'000;
    cut.X_WA.p = glm::mix(from_mm, to_mm, static_cast<double>(i) / steps) * kMillimetre;
    cut.X_WB.p = glm::mix(from_mm, to_mm, static_cast<double>(i + 1) / steps) * kMillimetre;
    carver.apply(cut);
    for (const LoosePiece& piece : carver.take_pieces()) pieces.push_back(piece);
  }
  return pieces;
}

TEST(LoosePieces, ACapWhoseStemIsCutThroughIsRemovedCompletely) {
  const Tool bur = round_bur(0.8e-3);
  Carver carver(tissue(kMushroom), {&bur, 1});
  EXPECT_TRUE(saw(carver, {-1.5, 0, 0}, {-0.2, 0, 0}).empty()) << "half the stem still holds it";
  const double before = total(carver.volume().volumes());
  const std::vector<LoosePiece> pieces = saw(carver, {-0.2, 0, 0}, {1.5, 0, 0});
  ASSERT_EQ(pieces.size(), 1u);
  // The box of 4 mm³ and the rest of the stem below it.
  EXPECT_NEAR(total(pieces[0].removed), 4e-9 + kPi * 0.16e-6 * 0.7e-3, 0.2e-9);
  EXPECT_LT(total(carver.volume().volumes()), before - 4e-9);
  EXPECT_EQ(bodies(carver.volume()), 1u);
  EXPECT_NEAR(pieces[0].center_W.z, 1.3e-3, 0.5e-3);
  glm::ivec3 lo(-12, -12, 8), size(25, 25, 20);
  std::vector<float> distance(static_cast<std::size_t>(size.x) * 25 * 20);
  lo -= glm::ivec3(glm::round(carver.volume().frame().origin / 1e-4));
  carver.volume().copy(lo, size, distance.data(), nullptr);
  EXPECT_GT(*std::min_element(distance.begin(), distance.end()), 0.4f) << "nothing that could be felt is left there";
}

TEST(LoosePieces, VolumeIsConserved) {
  ServoSettings settings;
  settings.tool = round_bur(1e-3);  // wider than the stem, at every position to which the push moves it
  settings.spindle.free_speed = 300 * kKrpm;
  settings.stiffness = 3000;
  HapticBench bench(kMushroom, settings);
  const double before = total(bench.carver.volume().volumes());
  // The hand moves along a straight line through the stem, forwards and backwards.
  for (int i = 0; i < 3000; ++i) {
    bench.tick({dvec3(-1.2e-3 + 2.4e-3 * std::abs(std::sin(i * 2e-3)), 0, 0), {1, 0, 0, 0}}, 1);
  }
  for (int i = 0; i < 20; ++i) bench.tick({dvec3(-1.2e-3, 0, 0), {1, 0, 0, 0}}, 0);
  const double after = total(bench.carver.volume().volumes());
  EXPECT_GT(total(bench.last.removed), 4.2e-9) << "the cap is among it";
  EXPECT_NEAR(before - after, total(bench.last.removed), 1e-5 * before);
  EXPECT_EQ(bodies(bench.carver.volume()), 1u);
}

/// Saws a ball into pieces, and returns a hash of the pieces and of the remaining tissue, which must be one body. Adds
/// the number of pieces to `found`.
std::uint64_t hash_of_sawing(double voxel_mm, std::uint64_t seed, std::size_t& found) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  ServoSettings settings;
  settings.tool = round_bur(0.7e-3);
  Carver carver(
      tissue(fmt::format(
          R"({{"voxel_mm": {}, "band_mm": 0.8, "solids": [{{"tissue": "dentin", "solid": {{"sphere": {{"radius_mm": 2}}}}}}]}})",
          voxel_mm)),
      settings);
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](std::uint64_t value) { hash = (hash ^ value) * 0x100000001b3u; };
  for (int k = 0; k < 40; ++k) {
    const dvec3 from(uniform(-2.4, 2.4), uniform(-2.4, 2.4), uniform(-2.4, 2.4)),
        to(uniform(-2.4, 2.4), uniform(-2.4, 2.4), uniform(-2.4, 2.4));
    for (const LoosePiece& piece : saw(carver, from, to)) {
      add(piece.cut);
      for (const double volume : piece.removed) add(std::bit_cast<std::uint64_t>(volume));
      ++found;
    }
  }
  add(carver.volume().hash());
  EXPECT_EQ(bodies(carver.volume()), 1u) << seed;
  return hash;
}

TEST(LoosePieces, TheForceLawGivesTheBitsOfItsVersion) {
  std::size_t found = 0;
  EXPECT_EQ(hash_of_sawing(0.1, 1, found), 0xdf79cb2c4e65bf98u) << "raise kForceLaw with this hash";
  EXPECT_EQ(hash_of_sawing(0.05, 2, found), 0x5543cf3408bb3f60u);
  EXPECT_EQ(found, 67u + 179u);
}

TEST(LoosePieces, BodiesThatWereSeparateFromTheStartAreNotLoose) {
  const Tool bur = round_bur(0.8e-3);
  Carver carver(tissue(R"({"voxel_mm": 0.1, "band_mm": 0.8, "solids": [{"tissue": "enamel", "solid": {"union": [
                  {"box": {"center_mm": [-1.1, 0, 0], "size_mm": [2, 2, 2]}}, {"box": {"center_mm": [1.6, 0, 0], "size_mm": [3, 2, 2]}}]}}]})"),
                {&bur, 1});
  ASSERT_EQ(bodies(carver.volume()), 2u);
  EXPECT_TRUE(saw(carver, {0, -1.5, 0.8}, {0, 1.5, 0.8}).empty()) << "a bur between two teeth touches both";
  EXPECT_EQ(bodies(carver.volume()), 2u);
}

TEST(LoosePieces, UndoRestoresALoosePieceBitForBit) {
  const Tool bur = round_bur(0.8e-3);
  Carver carver(tissue(kMushroom), {&bur, 1});
  const std::uint64_t whole = carver.volume().hash();
  ASSERT_EQ(saw(carver, {-1.5, 0, 0}, {1.5, 0, 0}).size(), 1u);
  const std::uint64_t cut = carver.volume().hash();
  ASSERT_TRUE(carver.undo());
  EXPECT_EQ(carver.volume().hash(), whole);
  ASSERT_TRUE(carver.redo());
  EXPECT_EQ(carver.volume().hash(), cut);
  ASSERT_TRUE(carver.undo());
  EXPECT_EQ(saw(carver, {-1.5, 0, 0.2}, {1.5, 0, 0.2}).size(), 1u) << "and falls off again when cut off again";
  EXPECT_EQ(bodies(carver.volume()), 1u);
}

TEST(LoosePieces, TheNextPatchLacksTheLoosePiece) {
  const Tool bur = round_bur(0.8e-3);
  Carver carver(tissue(kMushroom), {&bur, 1});
  TissuePatch patch;
  patch.resize(45);
  ServoTick at;
  carver.take_snapshot({0, 0, 0.8e-3}, patch);
  at.X_WT.p = at.X_WG.p = {0, 0, 0.8e-3};
  ASSERT_FALSE(carver.snapshot_due(at));
  saw(carver, {-1.5, 0, 0}, {1.5, 0, 0});
  EXPECT_TRUE(carver.snapshot_due(at));
  carver.take_snapshot({0, 0, 0.8e-3}, patch);
  EXPECT_EQ(patch.pieces, 1u);
  EXPECT_GT(total(patch.loose), 4e-9);
  EXPECT_GT(sample_linear(patch, carver.volume().frame().to_voxels({0, 0, 1.6e-3})), 1.0);
}

}  // namespace
}  // namespace typodont::haptics
