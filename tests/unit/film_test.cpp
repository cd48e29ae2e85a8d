#include "engine/debris/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "engine/base/fnv.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/debris/debris.h"
#include "engine/debris/spray.h"

namespace typodont::debris {
namespace {

using namespace typodont::literals;

constexpr double kSpacing = 0.3e-3;  // m

/// Tissue that is given by a distance function, sampled on a cube about the origin.
class Body {
 public:
  explicit Body(std::function<double(const dvec3&)> distance, int side = 41)
      : distance_(std::move(distance)), samples_(static_cast<std::size_t>(side) * side * side) {
    field.spacing = kSpacing;
    field.origin = dvec3(-kSpacing * (side - 1) / 2);
    field.size = glm::ivec3(side);
    field.distance = samples_.data();
    fill(glm::ivec3(0), field.size - 1);
  }
  void fill(const glm::ivec3& lo, const glm::ivec3& hi) {
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      samples_[static_cast<std::size_t>((x * field.size.y + y) * field.size.z + z)] =
          static_cast<float>(distance_(field.origin + kSpacing * dvec3(x, y, z)));
    });
  }
  CoarseField field;

 private:
  std::function<double(const dvec3&)> distance_;
  std::vector<float> samples_;
};

std::function<double(const dvec3&)> plane(const dvec3& normal) {
  return [n = glm::normalize(normal)](const dvec3& p) { return glm::dot(n, p) - 0.01e-3; };
}

MaterialTable table() {
  MaterialTable materials{};
  for (Material& material : materials) material.density = 2500;
  return materials;
}

/// Every cell of a film, by its sample.
std::vector<FilmCell> cells_of(const Film& film, const CoarseField& field) {
  std::vector<FilmCell> out;
  for_each_voxel(field.size, [&](int x, int y, int z) {
    const glm::ivec3 s(x, y, z);
    if (film.has_cell(s)) out.push_back(film.cell(s));
  });
  return out;
}

double sum_of(const Load& load) {
  return load.water + total(load.solids);
}

/// Expects that both sides of the film's balance agree, for the water and for every tissue.
void expect_balance(const FilmLedger& l) {
  const double scale = sum_of(l.deposited) + 1e-30;
  EXPECT_NEAR(l.on_surface.water + l.sucked.water + l.run_off.water + l.dried + l.flung.water, l.deposited.water,
              1e-12 * scale);
  for (std::size_t t = 0; t < kTissueCount; ++t)
    EXPECT_NEAR(l.on_surface.solids[t] + l.sucked.solids[t] + l.run_off.solids[t] + l.flung.solids[t],
                l.deposited.solids[t], 1e-12 * scale)
        << t;
}

TEST(Film, CellsOfAPlaneHaveTheAreaOfThePlane) {
  for (const dvec3 n : {dvec3(0, 0, 1), dvec3(0.3, 0, 1), dvec3(0.5, 0.4, 1), dvec3(1, 0.9, 0.8)}) {
    const Body body(plane(n));
    const Film film(body.field, table());
    // Counts only cells within a ball that the cube contains completely.
    constexpr double kRadius = 5e-3;
    double area = 0;
    for (const FilmCell& cell : cells_of(film, body.field)) {
      if (glm::length(cell.p_W) < kRadius) area += cell.area;
      EXPECT_NEAR(glm::dot(glm::normalize(n), dvec3(cell.p_W)), 0.01e-3, 1e-8);
    }
    EXPECT_NEAR(area, kPi * kRadius * kRadius, 0.02 * kPi * kRadius * kRadius) << n.x << " " << n.y;
  }
}

TEST(Film, FlowsDownAnInclineAtTheSpeedOfAViscousFilm) {
  constexpr double kHeight = 40e-6;  // m
  for (const double degrees : {10.0, 25.0, 40.0}) {
    for (const double turn : {0.0, 45.0}) {
      const double a = degrees * kPi / 180, b = turn * kPi / 180;
      const Body body(plane({std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)}));
      Film film(body.field, table(), {.clinging = 0, .drying = 0, .max_substeps = 1000});
      for (const FilmCell& cell : cells_of(film, body.field))
        if (glm::length(cell.p_W) < 3.5e-3) film.deposit(cell.p_W, {.water = 1000 * kHeight * cell.area, .solids = {}});
      // The speed of the centre of mass of a laminar film (Nusselt 1916): the flux per width, divided by the film's
      // height.
      const double speed = 1000 * 9.81 * std::sin(a) * kHeight * kHeight / (3 * 1e-3);
      const dvec3 down = glm::normalize(dvec3(std::cos(a) * std::cos(b), std::cos(a) * std::sin(b), -std::sin(a)));
      const auto centre = [&] {
        double sum = 0, weight = 0;
        for (const FilmCell& cell : cells_of(film, body.field)) {
          sum += cell.water * cell.area * glm::dot(dvec3(cell.p_W), down);
          weight += cell.water * cell.area;
        }
        return sum / weight;
      };
      const double before = centre(), time = 0.1e-3 / speed;
      for (int i = 0; i < 20; ++i) film.step(time / 20);
      EXPECT_NEAR((centre() - before) / time, speed, 0.05 * speed) << degrees << "° turned by " << turn << "°";
    }
  }
}

TEST(Film, FillsAPitToOneLevel) {
  // A floor with a round pit of 1.2 mm radius, whose bottom slopes.
  const Body body([](const dvec3& p) {
    const double floor = p.z, hole = std::max(std::hypot(p.x, p.y) - 1.2e-3, -1.2e-3 - p.z + 0.2 * p.x);
    return std::max(floor, -hole);
  });
  Film film(body.field, table(), {.drying = 0});
  film.deposit({0.5e-3, 0.3e-3, -1.1e-3}, {.water = 1000 * 1.0 * kCubicMillimetre, .solids = {}});
  for (int i = 0; i < 600; ++i) film.step(1.0 / 60);
  double lowest = 1, highest = -1;
  int deep = 0;
  for (const FilmCell& cell : cells_of(film, body.field)) {
    if (cell.water < 50e-6 || cell.n_W.z < 0.9f) continue;
    const double level = cell.p_W.z + cell.water * cell.n_W.z;
    lowest = std::min(lowest, level), highest = std::max(highest, level);
    ++deep;
  }
  EXPECT_GT(deep, 20);
  EXPECT_LT(highest - lowest, 25e-6);
}

TEST(Film, EveryBalanceIsExactForRandomLoadsCutsSuctionAndFling) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(0, 1);
    double radius = 4e-3;
    Body body([&radius](const dvec3& p) { return glm::length(p) - radius; });
    Film film(body.field, table(), {.drain = {0, 0, 1, 1.5e-3}});
    for (int i = 0; i < 60; ++i) {
      for (int k = 0; k < 4; ++k) {
        const dvec3 p(5e-3 * (u(random) - 0.5), 5e-3 * (u(random) - 0.5), 6e-3 * u(random));
        Load load{.water = u(random) < 0.7 ? 2e-7 * u(random) : 0, .solids = {}};
        load.solids[1 + static_cast<std::size_t>(3 * u(random))] = 1e-7 * u(random);
        film.deposit(p, load);
      }
      if (i % 10 == 9) {
        radius -= 0.1e-3;
        body.fill(glm::ivec3(0), body.field.size - 1);
        film.update(glm::ivec3(0), body.field.size - 1);
      }
      if (i % 7 == 3) film.fling({0, 0, radius}, 1.5e-3, 0.5);
      const Suction suction{{1e-3, 0, 7e-3}, 5e-3, 2e-3};
      film.step(0.02 * u(random), i % 3 == 0 ? &suction : nullptr);
      expect_balance(film.ledger());
    }
    const FilmLedger l = film.ledger();
    for (const double part : {l.on_surface.water, l.sucked.water, l.run_off.water, l.dried, l.flung.water,
                              total(l.on_surface.solids), total(l.sucked.solids), total(l.run_off.solids)})
      EXPECT_GT(part, 0) << seed;
    for (const FilmCell& cell : cells_of(film, body.field)) {
      EXPECT_GE(cell.water, 0);
      for (const double height : cell.solids) EXPECT_GE(height, 0);
    }
  }
}

TEST(Film, SuctionTakesItAtTheStatedRateForEveryStepLength) {
  const Body body(plane({0, 0, 1}));
  const FilmOptions options{.clinging = 1e-3, .drying = 0};  // a film that does not flow
  const Suction suction{{0, 0, 8e-3}, 5e-3, 2e-3};
  for (const double dt : {0.001, 0.02, 0.25}) {
    Film film(body.field, table(), options);
    Load load{.water = 1e-8, .solids = {}};
    load.solids[1] = 2e-9;
    film.deposit({0, 0, 0.01e-3}, load);
    for (int i = 0; i < std::lround(0.5 / dt); ++i) film.step(dt, &suction);
    // At 7.99 mm from the nozzle, the air has the speed v = Q/(4π r²). The mass decays with the rate suction_rate ·
    // (v/suction_speed)².
    const double r = 8e-3 - 0.01e-3, v = 5e-3 / (4 * kPi * r * r);
    const double left = std::exp(-options.suction_rate * v * v / (options.suction_speed * options.suction_speed) * 0.5);
    EXPECT_NEAR(film.ledger().on_surface.water, 1e-8 * left, 1e-4 * 1e-8 * left) << dt;
    EXPECT_NEAR(film.ledger().on_surface.solids[1], 2e-9 * left, 1e-4 * 2e-9 * left) << dt;
  }
}

TEST(Film, DrySolidsLieUntilWaterRinsesThemAway) {
  const Body body(plane({0.6, 0, 1}));
  Film film(body.field, table(), {.drain = {-1, 0, 0, 4e-3}});
  Load dust;
  dust.solids[2] = 2e-9;
  film.deposit({-1e-3, 0, 0.6e-3}, dust);
  for (int i = 0; i < 600; ++i) film.step(1.0 / 60);
  EXPECT_DOUBLE_EQ(film.ledger().on_surface.solids[2], 2e-9);
  EXPECT_EQ(film.cells_stepped(), 0u) << "dust alone is not computed";
  for (int i = 0; i < 240; ++i) {
    for (int k = -3; k <= 3; ++k) film.deposit({-2e-3, 0.3e-3 * k, 1.2e-3}, {.water = 3e-8, .solids = {}});
    film.step(1.0 / 60);
  }
  EXPECT_LT(film.ledger().on_surface.solids[2], 0.05 * 2e-9);
  EXPECT_GT(film.ledger().run_off.solids[2], 0.95 * 2e-9);
}

TEST(Film, ThickFilmDripsFromAnOverhangAndAThinOneDriesUp) {
  const Body body(plane({0, 0, -1}));
  Film film(body.field, table());
  film.deposit({0, 0, -0.01e-3}, {.water = 1e-6, .solids = {}});
  film.step(0.01);
  const FilmOptions usual;
  EXPECT_NEAR(film.ledger().on_surface.water, 1000 * usual.hanging * kSpacing * kSpacing, 0.05 * 1e-6 * usual.hanging);
  for (int i = 0; i < 1300; ++i) film.step(0.1);  // 60 µm at 0.5 µm/s
  EXPECT_EQ(film.ledger().on_surface.water, 0);
  EXPECT_EQ(film.loaded(), 0u);
  const std::uint64_t work = film.cells_stepped();
  film.step(0.1);
  EXPECT_EQ(film.cells_stepped(), work);
}

TEST(Film, TheChangesOfACellAreReportedOnce) {
  const Body body(plane({0, 0, 1}));
  Film film(body.field, table(), {.clinging = 1e-3});
  std::vector<glm::ivec3> changed;
  film.take_changed(changed);
  EXPECT_TRUE(changed.empty());
  for (int i = 0; i < 3; ++i) film.deposit({0, 0, 0}, {.water = 1e-9, .solids = {}});
  film.step(0.01);
  film.take_changed(changed);
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_GT(film.cell(changed[0]).water, 0);
}

constexpr Nozzles kFourNozzles{.flow = 50e-6 / 60, .count = 4};

SpraySource bur_at(const dvec3& p, double water = 1) {
  SpraySource source;
  source.X_WT.p = p;
  source.head_radius = 0.6_mm;
  source.head_half = 0.6_mm;
  source.spindle = 300 * kKrpm;
  source.water = water;
  return source;
}

TEST(Spray, ItsWaterIsTheFlowOfTheNozzlesAndEveryDropIsAccountedFor) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Body body([](const dvec3& p) { return glm::length(p) - 4e-3; });
    Film film(body.field, table());
    Spray spray(kFourNozzles, {.seed = seed});
    Debris chips({.seed = seed});
    const Suction suction{{3e-3, 3e-3, 5e-3}, 5e-3, 2e-3};
    constexpr double kStep = 1.0 / 60;
    constexpr int kSteps = 90;
    for (int i = 0; i < kSteps; ++i) {
      const SpraySource source = bur_at({0, 0, 4.5e-3});
      Cut cut;
      cut.index = static_cast<std::uint64_t>(i + 1);
      cut.removed[1] = 0.01 * kCubicMillimetre;
      cut.X_WA.p = cut.X_WB.p = source.X_WT.p;
      cut.n_C_W = {0, 0, 1};
      cut.spindle = source.spindle;
      chips.emit(cut, {.head_radius = 0.6_mm}, table());
      spray.step(kStep, &source, body.field, film, i > 60 ? &suction : nullptr);
      chips.step(kStep, body.field, i > 60 ? &suction : nullptr, &film);
      film.step(kStep, i > 60 ? &suction : nullptr);
    }
    const SprayLedger s = spray.ledger();
    const FilmLedger f = film.ledger();
    const DebrisLedger d = chips.ledger();
    const double sprayed = kFourNozzles.flow * 1000 * kStep * kSteps;
    EXPECT_NEAR(s.sprayed.water, sprayed, 1e-12 * sprayed);
    EXPECT_NEAR(s.in_air.water + s.deposited.water + s.sucked.water + s.left.water + s.dropped.water,
                s.sprayed.water + s.flung.water, 1e-12 * sprayed);
    EXPECT_NEAR(s.flung.water, f.flung.water, 1e-12 * sprayed);
    EXPECT_NEAR(s.deposited.water, f.deposited.water, 1e-12 * sprayed);
    expect_balance(f);
    // The solids are chips that the film took; some were thrown off as slurry and landed again.
    const double born = total(d.born);
    EXPECT_NEAR(d.alive + d.decayed + d.sucked + d.dropped + d.deposited, born, 1e-6 * born);
    EXPECT_GT(d.deposited, 0);
    EXPECT_NEAR(total(f.deposited.solids), d.deposited + total(s.deposited.solids), 1e-9 * born);
    EXPECT_GT(total(s.flung.solids), 0);
    EXPECT_GT(f.on_surface.water, 0);
    EXPECT_GT(f.sucked.water, 0);
    EXPECT_GT(s.left.water, 0);
  }
}

std::uint64_t hash_of(const Spray& spray) {
  std::vector<DebrisPoint> points(spray.alive());
  points.resize(spray.write_points(points));
  Fnv1a hash;
  for (const DebrisPoint& point : points)
    for (int a = 0; a < 3; ++a) hash.add(point.p_W[a]), hash.add(point.streak_W[a]);
  return hash.value;
}
std::uint64_t hash_of(const Film& film, const glm::ivec3& size) {
  Fnv1a hash;
  for_each_voxel(size, [&](const glm::ivec3& sample) {
    if (film.has_cell(sample)) hash.add(film.cell(sample).water);
  });
  return hash.value;
}

TEST(Spray, TheSameSeedGivesTheSameBits) {
  std::uint64_t hashes[3][2];
  for (int run = 0; run < 3; ++run) {
    const Body body([](const dvec3& p) { return glm::length(p) - 4e-3; });
    Film film(body.field, table());
    Spray spray(kFourNozzles, {.seed = run == 2 ? 9u : 8u});
    const SpraySource source = bur_at({0, 0, 5e-3});
    for (int i = 0; i < 40; ++i) {
      spray.step(1.0 / 50, &source, body.field, film);
      film.step(1.0 / 50);
    }
    hashes[run][0] = hash_of(spray), hashes[run][1] = hash_of(film, body.field.size);
  }
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(hashes[0][k], hashes[1][k]);
    EXPECT_NE(hashes[0][k], hashes[2][k]);
  }
}

}  // namespace
}  // namespace typodont::debris
