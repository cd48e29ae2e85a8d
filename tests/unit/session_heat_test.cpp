// Conduction against exact solutions.
#include <gmock/gmock.h>

#include <cmath>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "engine/session/heat.h"
#include "tests/support/folder.h"

namespace typodont::session {
namespace {

using namespace literals;

constexpr ThermalMaterial kEnamel{0.93, 2.2e6}, kDentin{0.58, 2.5e6};

ThermalTable materials() {
  ThermalTable table{};
  table[static_cast<std::size_t>(Tissue::kEnamel)] = kEnamel;
  table[static_cast<std::size_t>(Tissue::kDentin)] = kDentin;
  return table;
}
HeatGrid block(const glm::ivec3& size, double h, double temperature) {
  return {{dvec3(0), h},
          size,
          std::vector<Tissue>(static_cast<std::size_t>(size.x * size.y * size.z), Tissue::kEnamel),
          materials(),
          temperature};
}

/// K at p after t seconds of a source of one watt that started at `from` with the velocity v, in an infinite body.
double moving_source(const dvec3& p, const dvec3& from, const dvec3& v, double t) {
  const double alpha = kEnamel.conductivity / kEnamel.heat_capacity;
  double sum = 0;
  constexpr int kParts = 2000;
  for (int i = 0; i < kParts; ++i) {
    const double ago = t * (i + 0.5) / kParts, r2 = glm::dot(p - from - v * (t - ago), p - from - v * (t - ago));
    sum += std::exp(-r2 / (4 * alpha * ago)) / std::pow(4 * kPi * alpha * ago, 1.5);
  }
  return sum * t / kParts / kEnamel.heat_capacity;
}

TEST(Heat, OfAMovingSourceAgreesWithTheExactSolutionWithinOnePercent) {
  constexpr double kCell = 0.2_mm, kTime = 3, kTick = 0.02, kNear = 5 * kCell, kFar = 15 * kCell;
  const dvec3 from(5.0_mm, 5.0_mm, 5.0_mm), v(0.6_mm, 0.2_mm, 0);
  HeatGrid grid = block({60, 54, 50}, kCell, 0);
  const int ticks = static_cast<int>(std::lround(kTime / kTick));
  for (int i = 0; i < ticks; ++i) {
    grid.step(kTick / 2, {}, {}, {}, 0);
    grid.heat(from + v * ((i + 0.5) * kTick), kTick);
    grid.step(kTick / 2, {}, {}, {}, 0);
  }
  double off = 0, all = 0;
  for (int x = 0; x < 60; x += 2)
    for (int y = 0; y < 54; y += 2)
      for (int z = 0; z < 50; z += 2) {
        const dvec3 p = dvec3(x, y, z) * kCell;
        const double away = glm::length(p - from - v * kTime);
        if (away < kNear || away > kFar) continue;
        const double exact = moving_source(p, from, v, kTime), found = grid.temperature(grid.at(x, y, z));
        off += (found - exact) * (found - exact), all += exact * exact;
      }
  EXPECT_GT(all, 1000);
  EXPECT_LT(std::sqrt(off / all), 0.01);
}

TEST(Heat, FlowsThroughTwoTissuesAsThroughResistancesInSeries) {
  constexpr double kCell = 0.25_mm, kPower = 0.01, kTick = 0.002;
  constexpr int kEach = 8;
  std::vector<Tissue> tissue;
  for (int z = 0; z < 2 * kEach; ++z) tissue.push_back(z < kEach ? Tissue::kDentin : Tissue::kEnamel);
  HeatGrid grid({dvec3(0), kCell}, {1, 1, 2 * kEach}, tissue, materials(), 37);
  for (int i = 0; i < 100000; ++i) {
    grid.heat(std::size_t{0}, kPower * kTick);
    grid.step(kTick, {}, {5000, 10}, dvec3(0, 0, (2 * kEach - 1) * kCell), kCell / 2);
  }
  const double way = (kEach - 0.5) * kCell / kDentin.conductivity + (kEach - 0.5) * kCell / kEnamel.conductivity;
  EXPECT_NEAR((grid.temperature(0) - grid.temperature(2 * kEach - 1)) / (kPower / (kCell * kCell) * way), 1, 0.001);
}

TEST(Heat, LeavesASmallBodyAtTheRateOfItsFilm) {
  constexpr double kCell = 0.1_mm, kFilm = 5, kTime = 20;
  HeatGrid grid = block({4, 4, 4}, kCell, 37);
  for (int i = 0; i < 100; ++i) grid.step(kTime / 100, {kFilm, 17}, {}, {}, 0);
  const double rate = kFilm * 6 / (kEnamel.heat_capacity * 4 * kCell);
  EXPECT_NEAR((grid.temperature(grid.at(2, 2, 2)) - 17) / (20 * std::exp(-rate * kTime)), 1, 0.002);
}

TEST(Heat, OfAnInsulatedBodyIsTheHeatThatItGotLessThatOfRemovedCells) {
  constexpr double kCell = 0.3_mm;
  HeatGrid grid = block({10, 9, 8}, kCell, 0);
  const auto held = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < 720; ++i)
      if (grid.tissue(i) != Tissue::kAir) sum += grid.temperature(i);
    return sum * kEnamel.heat_capacity * kCell * kCell * kCell;
  };
  grid.heat(dvec3(1.3_mm, 1.1_mm, 0.77_mm), 0.2);
  for (int i = 0; i < 50; ++i) grid.step(0.02, {}, {}, {}, 0);
  EXPECT_NEAR(held(), 0.2, 1e-9);
  const std::size_t gone = grid.at(4, 4, 3);
  const double taken = grid.temperature(gone) * kEnamel.heat_capacity * kCell * kCell * kCell;
  grid.remove(gone);
  for (int i = 0; i < 50; ++i) grid.step(0.02, {}, {}, {}, 0);
  EXPECT_NEAR(held(), 0.2 - taken, 1e-9);
}

TEST(Heat, SettingsOutsideOfPhysicsAreRefusedWithKeyAndRange) {
  const auto refused = [](const char* text) {
    return test::refusal([&] { (void)read_keys(Json::parse(text, "scene"), describe_heat); });
  };
  using testing::AllOf, testing::HasSubstr;
  EXPECT_THAT(refused(R"({"coolant_C": 80})"), AllOf(HasSubstr("coolant_C"), HasSubstr("60")));
  EXPECT_THAT(refused(R"({"water_C": 20})"), HasSubstr("water_C"));
  EXPECT_EQ(read_keys(Json::parse("{}", "scene"), describe_heat).coolant, 23);
}

}  // namespace
}  // namespace typodont::session
