// Tests of undo and redo of strokes. The tissue is the same to the last bit, in the volume and in the servo's patch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "engine/base/units.h"
#include "haptics/cutting/carve.h"
#include "tests/support/haptic_bench.h"

namespace typodont::haptics {
namespace {

constexpr std::string_view kBlock =
    R"({"voxel_mm": 0.15, "band_mm": 1.2, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [8, 8, 5]}}}]})";

Tool round_bur(double diameter) {
  Tool tool;
  tool.diameter = diameter;
  return tool;
}

/// Cuts along random paths through the block, in strokes of 5 to 40 cuts. `stroke` is the number of the present stroke.
class Walks {
 public:
  explicit Walks(std::uint64_t seed) : random_(seed) {}

  void make_stroke(Carver& carver) {
    t_ += kNanosPerSecond;
    dvec3 at(uniform(-4, 4), uniform(-4, 4), uniform(0, 3));
    const int count = static_cast<int>(uniform(5, 40));
    for (int i = 0; i < count; ++i) {
      const dvec3 next = at + dvec3(uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-0.12, 0.06));
      Cut cut;
      cut.index = carver.cuts() + 1, cut.t = t_ += 1'000'000;
      cut.X_WA.p = at * kMillimetre, cut.X_WB.p = next * kMillimetre;
      carver.apply(cut);
      at = next;
    }
  }
  Nanos t() const { return t_; }  // time of the last cut

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::mt19937_64 random_;
  Nanos t_ = 0;
};

TissueVolume block() {
  return TissueVolume(read_solids(Json::parse(std::string(kBlock), "block")));
}

TEST(Undo, ARedoInMidStrokeChangesNothingAndTheStrokeIsUndoneAsAWholeInEveryModel) {
  for (const char* model : {"offset", "voxel_penalty", "packing", "mesh_lod", "vertex"}) {
    const Tool bur = round_bur(1.2e-3);
    Carver steady(block(), {&bur, 1}, contact_method(model, "model")),
        asked(block(), {&bur, 1}, contact_method(model, "model"));
    const auto sink = [](Carver& carver, double y) {
      for (int i = 0; i < 60; ++i) {
        Cut cut;
        cut.index = carver.cuts() + 1, cut.t = from_seconds(1000 * y) + i * 1'000'000;
        cut.X_WA.p = {1e-3, y, 3.15e-3 - i * 1e-5}, cut.X_WB.p = cut.X_WA.p - dvec3(0, 0, 1e-5);
        carver.apply(cut);
        if (i % 20 == 10) carver.redo();
      }
    };
    sink(steady, 0), sink(asked, 0);
    EXPECT_FALSE(asked.redo());
    const std::uint64_t first = asked.volume().hash();
    EXPECT_EQ(first, steady.volume().hash()) << model;
    sink(asked, 1e-3);
    EXPECT_NE(asked.volume().hash(), first) << model;
    EXPECT_EQ(asked.strokes().done, 2u) << model;
    ASSERT_TRUE(asked.undo());
    EXPECT_EQ(asked.volume().hash(), first) << model;
    ASSERT_TRUE(asked.redo());
    ASSERT_TRUE(asked.undo());
    EXPECT_EQ(asked.volume().hash(), first) << model;
  }
}

TEST(ChangeOfTool, ARefusedRequestChangesNoBitInAnyModel) {
  // A recording contains only the tool in the hand, so a replay asks for no change that was refused.
  for (const char* model : {"offset", "voxel_penalty", "packing", "mesh_lod", "vertex"}) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    ServoSettings settings = test::drill_settings(model);
    settings.tools = {round_bur(1.2e-3), round_bur(1.0e-3), round_bur(1.0e-3)};
    settings.tools[1].shape = HeadShape::kCylinder, settings.tools[1].length = 2.5e-3;
    settings.tools[2].cuts = false;
    test::HapticBench asks(kBlock, settings), replay(kBlock, settings);
    dvec3 p(0, 0, 4e-3), to = p;
    int refused = 0, changed = 0;
    std::uint32_t wanted = 0;
    for (int i = 0; i < 6000; ++i) {
      if (i % 150 == 0) to = 1e-3 * dvec3(2 * unit(random), 2 * unit(random), 3.6 + 1.2 * unit(random));
      if (i % 400 == 200) wanted = static_cast<std::uint32_t>(random() % 3);
      if (glm::distance(p, to) > 0) p += std::min(1.0, 8e-6 / glm::distance(p, to)) * (to - p);
      const double pedal = i % 400 < 200 ? 1 : 0;
      const std::uint32_t before = asks.last.tool;
      asks.tick({p}, pedal, wanted);
      replay.tick({p}, pedal, asks.last.tool);
      refused += asks.last.tool != wanted, changed += asks.last.tool != before;
      ASSERT_EQ(replay.last.f_T_W, asks.last.f_T_W) << model << ", tick " << i;
      ASSERT_EQ(replay.last.X_WG.p, asks.last.X_WG.p) << model << ", tick " << i;
      ASSERT_EQ(replay.last.removed, asks.last.removed) << model << ", tick " << i;
    }
    EXPECT_GT(refused, 200) << model;
    EXPECT_GE(changed, 2) << model;
  }
}

TEST(Undo, AStrokeWithoutChangesIsNotUndoneAndTheNextOneIs) {
  const Tool bur = round_bur(1.2e-3);
  Carver carver(block(), {&bur, 1});
  const std::uint64_t untouched = carver.volume().hash();
  const auto cut_at = [&](double z) {
    Cut cut;
    cut.index = carver.cuts() + 1, cut.t = static_cast<Nanos>(carver.cuts()) * 1'000'000;
    cut.X_WA.p = cut.X_WB.p = {0, 0, z};
    carver.apply(cut);
  };
  cut_at(8e-3);  // in the air
  EXPECT_FALSE(carver.undo());
  cut_at(2.6e-3);
  EXPECT_NE(carver.volume().hash(), untouched);
  ASSERT_TRUE(carver.undo());
  EXPECT_EQ(carver.volume().hash(), untouched);
}

TEST(Undo, UndoOfAllStrokesRestoresTheOriginalAndRedoEveryState) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Tool bur = round_bur(1.2e-3);
    Carver carver(block(), {&bur, 1});
    const PerTissue untouched = carver.volume().volumes();
    std::vector<std::uint64_t> hashes{carver.volume().hash()};
    Walks walks(seed);
    for (int stroke = 0; stroke < 12; ++stroke) {
      walks.make_stroke(carver);
      hashes.push_back(carver.volume().hash());
      EXPECT_NE(hashes.back(), hashes[hashes.size() - 2]) << "a stroke through tissue cuts";
    }
    ASSERT_EQ(carver.volume().strokes().done, 12u);
    for (int stroke = 11; stroke >= 0; --stroke) {
      ASSERT_TRUE(carver.undo());
      EXPECT_EQ(carver.volume().hash(), hashes[static_cast<std::size_t>(stroke)]) << seed << " " << stroke;
    }
    EXPECT_FALSE(carver.undo());
    EXPECT_EQ(carver.volume().volumes(), untouched);
    glm::ivec3 lo, hi;
    carver.volume().bounds(lo, hi);
    glm::ivec3 cut_lo, cut_hi;
    carver.volume().cut_box(lo, hi, cut_lo, cut_hi);
    EXPECT_GT(cut_lo.x, cut_hi.x) << "distances are true again";
    for (std::size_t stroke = 1; stroke <= 12; ++stroke) {
      ASSERT_TRUE(carver.redo());
      EXPECT_EQ(carver.volume().hash(), hashes[stroke]) << seed << " " << stroke;
    }
    EXPECT_FALSE(carver.redo());
  }
}

TEST(Undo, ANewStrokeDiscardsTheUndoneStrokes) {
  const Tool bur = round_bur(1.2e-3);
  Carver carver(block(), {&bur, 1});
  Walks walks(7);
  for (int stroke = 0; stroke < 3; ++stroke) walks.make_stroke(carver);
  const std::uint64_t three = carver.volume().hash();
  carver.undo(), carver.undo();
  const std::uint64_t one = carver.volume().hash();
  walks.make_stroke(carver);
  EXPECT_FALSE(carver.redo());
  EXPECT_NE(carver.volume().hash(), three);
  EXPECT_TRUE(carver.undo());
  EXPECT_EQ(carver.volume().hash(), one);
  EXPECT_EQ(carver.volume().strokes().done, 1u);
  EXPECT_EQ(carver.volume().strokes().undone, 1u);
}

TEST(Undo, WorkInThePausesChangesNeitherStrokesNorUndo) {
  const Tool bur = round_bur(1.2e-3);
  Carver rested(block(), {&bur, 1}), other(block(), {&bur, 1});
  Walks walks(11), same_walks(11);
  for (int stroke = 1; stroke <= 6; ++stroke) {
    walks.make_stroke(rested), same_walks.make_stroke(other);
    rested.rest(walks.t() + 200'000'000);  // too early: the same stroke may continue
    Cut cut;
    cut.index = rested.cuts() + 1, cut.t = walks.t() + 250'000'000;
    cut.X_WA.p = dvec3(0, 0, 2.6) * kMillimetre, cut.X_WB.p = dvec3(0.3 * stroke, 0.2, 2.5) * kMillimetre;
    rested.apply(cut), other.apply(cut);
    rested.rest(walks.t() + 600'000'000);
    EXPECT_EQ(rested.volume().strokes().done, static_cast<std::size_t>(stroke));
  }
  const PerTissue before = other.volume().volumes();
  for (int stroke = 0; stroke < 6; ++stroke) {
    ASSERT_TRUE(rested.undo() && other.undo());
    EXPECT_EQ(rested.volume().hash(), other.volume().hash());
    EXPECT_EQ(rested.volume().taken_back(), other.volume().taken_back());
    for (std::size_t tissue = 1; tissue < before.size(); ++tissue)
      EXPECT_NEAR(rested.volume().taken_back()[tissue], other.volume().volumes()[tissue] - before[tissue], 1e-15)
          << "m³";
  }
  EXPECT_EQ(rested.volume().strokes().bytes, other.volume().strokes().bytes);
}

TEST(Undo, MemoryGrowsWithTheChangesOfAStrokeNotWithTheTissue) {
  const auto bytes_after = [](double block_mm, double length_mm) {
    const std::string json = fmt::format(
        R"({{"voxel_mm": 0.15, "band_mm": 1.2, "solids": [{{"tissue": "dentin", "solid": {{"box": {{"size_mm": [{0}, {0}, 5]}}}}}}]}})",
        block_mm);
    const Tool bur = round_bur(1.2e-3);
    Carver carver(TissueVolume(read_solids(Json::parse(json, "block"))), {&bur, 1});
    Cut cut;
    for (double x = 0; x < length_mm; x += 0.1) {
      cut.index = carver.cuts() + 1, cut.t += 1'000'000;
      cut.X_WA.p = dvec3(x, 0, 2.4) * kMillimetre, cut.X_WB.p = dvec3(x + 0.1, 0, 2.4) * kMillimetre;
      carver.apply(cut);
    }
    carver.undo();  // completes the stroke
    return static_cast<double>(carver.volume().strokes().bytes);
  };
  const double small = bytes_after(10, 1.5);
  EXPECT_NEAR(bytes_after(20, 1.5) / small, 1, 0.15) << "four times the tissue, the same stroke";
  const double longer = bytes_after(20, 9);
  EXPECT_GT(longer, 2 * small);
  EXPECT_LT(longer, 6.5 * small);
  // A 1.2 mm bur and its margin touch at most 5 × 4 leaves across its path. A leaf is 1.2 mm wide and has 2 KB.
  EXPECT_LT(small, 60 * 2600.0);
}

}  // namespace
}  // namespace typodont::haptics
