#include "engine/debris/debris.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine/base/fnv.h"
#include "engine/base/units.h"
#include "engine/debris/motion/motion.h"
#include "tests/support/no_alloc.h"

namespace typodont::debris {
namespace {

using namespace typodont::literals;

MaterialTable table() {
  MaterialTable materials{};
  materials[static_cast<int>(Tissue::kEnamel)].density = 2950;
  materials[static_cast<int>(Tissue::kDentin)].density = 2150;
  return materials;
}

// Returns a cut by a head at the origin with its shank up. It cuts a floor below it at 300 krpm.
Cut cut_of(std::uint64_t index, double enamel_mm3, double dentin_mm3 = 0) {
  Cut cut;
  cut.index = index;
  cut.removed[static_cast<int>(Tissue::kEnamel)] = enamel_mm3 * kCubicMillimetre;
  cut.removed[static_cast<int>(Tissue::kDentin)] = dentin_mm3 * kCubicMillimetre;
  cut.n_C_W = {0, 0, 1};
  cut.spindle = 300 * kKrpm;
  return cut;
}

// A floor that is solid below z = −2 mm. Its samples are half a millimetre apart.
class Floor {
 public:
  Floor() : samples_(41 * 41 * 41) {
    for (int i = 0; i < 41 * 41; ++i) {
      for (int z = 0; z < 41; ++z) {
        samples_[static_cast<std::size_t>(i * 41 + z)] = static_cast<float>(-0.01 + 5e-4 * z + 0.002);
      }
    }
    field.origin = dvec3(-0.01);
    field.spacing = 5e-4;
    field.size = glm::ivec3(41);
    field.distance = samples_.data();
  }
  CoarseField field;

 private:
  std::vector<float> samples_;
};

TEST(Debris, LedgerBalancesThroughDecaySuctionAndOverflow) {
  Debris debris({.capacity = 2000, .lifetime = 0.5});
  const Floor floor;
  const Suction suction{{0, 0, 0.01}, 5e-3, 4e-3};
  bool lost_some_each_way = false;
  for (std::uint64_t i = 1; i <= 400; ++i) {
    debris.emit(cut_of(i, 0.02, 0.01), {.head_radius = 0.6_mm}, table());
    debris.step(0.005, floor.field, i % 2 ? &suction : nullptr);
    const DebrisLedger l = debris.ledger();
    const double born = total(l.born);
    EXPECT_NEAR(l.alive + l.decayed + l.sucked + l.dropped, born, 1e-6 * born);
    lost_some_each_way = l.decayed > 0 && l.sucked > 0 && l.dropped > 0;
  }
  EXPECT_TRUE(lost_some_each_way);
}

TEST(Debris, StartsAtTheRimsVelocityInTheSenseOfRotation) {
  for (const double sense : {1.0, -1.0}) {
    Debris debris({.scatter = 0});
    Cut cut = cut_of(1, 0.1);
    cut.spindle *= sense;
    cut.n_C_W = {-1, 0, 0};  // cutting on its +x side
    debris.emit(cut, {.head_radius = 0.6_mm}, table());
    std::vector<DebrisPoint> points(debris.alive());
    ASSERT_EQ(debris.write_points(points), debris.alive());
    ASSERT_GT(points.size(), 10u);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const dvec3 p = points[i].p_W;
      EXPECT_NEAR(glm::length(p), 0.6_mm, 1e-9);
      dvec3 rim = glm::cross(dvec3(0, 0, cut.spindle), p);
      if (rim.x > 0) rim.x = -rim.x;  // it leaves the tissue it was cut from
      EXPECT_LT(glm::length(dvec3(debris.velocity(i)) - rim), 1e-4 * glm::length(rim) + 1e-4);
      EXPECT_GT(debris.velocity(i).y * sense, 0);
    }
  }
}

TEST(Debris, ChipsGrowWithTheRemovalAndShrinkWithAreaAndSpeed) {
  const auto chip = [](double mm3, double mm2, double krpm) {
    Debris debris;
    Cut cut = cut_of(1, mm3);
    cut.spindle = krpm * kKrpm;
    debris.emit(cut, {.head_radius = 0.6_mm, .area = mm2 * 1e-6, .duration = 0.01}, table());
    std::vector<DebrisPoint> point(1);
    debris.write_points(point);
    return static_cast<double>(point[0].chip);
  };
  const double reference = chip(1e-3, 1, 300);
  EXPECT_NEAR(chip(2e-3, 1, 300), std::cbrt(2) * reference, 1e-6 * reference);
  EXPECT_NEAR(chip(1e-3, 2, 300), std::cbrt(0.5) * reference, 1e-6 * reference);
  EXPECT_NEAR(chip(1e-3, 1, 150), std::cbrt(2) * reference, 1e-6 * reference);
  EXPECT_NEAR(chip(1, 0.01, 1) / chip(1e-9, 9, 300), 4 / 0.4, 1e-4) << "the limits";
}

TEST(Debris, ChipsLeaveTheAreaOfTheContact) {
  const auto widest = [](double mm2) {
    Debris debris({.scatter = 0});
    debris.emit(cut_of(1, 0.1), {.head_radius = 0.6_mm, .area = mm2 * 1e-6, .duration = 0.01}, table());
    std::vector<DebrisPoint> points(debris.alive());
    debris.write_points(points);
    double most = 0;
    for (const DebrisPoint& p : points) most = std::max(most, std::hypot<double>(p.p_W.x, p.p_W.y));
    return most;
  };
  EXPECT_LT(widest(0.02), 0.09_mm);
  EXPECT_GT(widest(0.3), 0.15_mm);
  EXPECT_GT(widest(1.0), 0.4_mm);
}

TEST(Drag, IsSchillerAndNaumanns) {
  // For 50 µm of enamel in air at rest, Stokes' law gives the relaxation time ρd²/18μ = 22 ms.
  EXPECT_NEAR(1 / drag_rate(0, 50e-6, 2900, 1.2, 1.8e-5), 0.0224, 1e-4);
  for (double re = 1e-3; re < 999; re *= 1.013) {
    EXPECT_NEAR(drag_factor(re), 1 + 0.15 * std::pow(re, 0.687), 1e-4 * drag_factor(re)) << re;
  }
}

TEST(Debris, FallsAtTheSpeedWhereDragEqualsWeight) {
  Debris debris({.min_chip = 40e-6, .max_chip = 40e-6, .lifetime = 60});
  debris.emit(cut_of(1, 1e-4), {.head_radius = 0.6_mm}, table());
  for (int i = 0; i < 3000; ++i) debris.step(1e-3, {});
  const double v = -debris.velocity(0).z;
  EXPECT_NEAR(v * drag_rate(v, 40e-6, 2950, 1.2, 1.8e-5), 9.81, 0.05);
}

TEST(Debris, FlightFollowsTheEquationOfMotion) {
  // Compares the motion of one chip with a fine integration of dv/dt = g − rate(|v|) v.
  Debris debris({.scatter = 0});
  Cut cut = cut_of(1, 1e-4);
  cut.n_C_W = {1, 0, 0};
  debris.emit(cut, {.head_radius = 0.6_mm}, table());
  dvec3 v = debris.velocity(0), p(0);
  std::vector<DebrisPoint> point(1);
  debris.write_points(point);
  const dvec3 start = point[0].p_W;
  const double chip = point[0].chip, dt = 1e-4;
  for (int i = 0; i < 500; ++i) {
    debris.step(dt, {});
    for (int k = 0; k < 20; ++k) {
      v += (dvec3(0, 0, -9.81) - drag_rate(glm::length(v), chip, 2950, 1.2, 1.8e-5) * v) * (dt / 20);
      p += v * (dt / 20);
    }
  }
  debris.write_points(point);
  EXPECT_LT(glm::length(dvec3(point[0].p_W) - start - p), 0.05 * glm::length(p));
}

TEST(Debris, StaysOutOfTheTissueAndComesToRestOnIt) {
  Debris debris({.min_chip = 20e-6, .lifetime = 100});
  const Floor floor;
  Cut cut = cut_of(1, 0.3);
  for (std::uint64_t i = 1; i <= 20; ++i) {
    cut.index = i;
    cut.spindle = 20 * kKrpm;
    debris.emit(cut, {.head_radius = 0.6_mm}, table());
  }
  std::vector<DebrisPoint> points(debris.alive());
  for (int i = 0; i < 4000; ++i) {
    debris.step(1e-3, floor.field);
    if (i % 50) continue;
    for (std::size_t k = 0; k < debris.write_points(points); ++k) {
      if (std::abs(points[k].p_W.x) < 0.009f && std::abs(points[k].p_W.y) < 0.009f) {
        EXPECT_GT(points[k].p_W.z, -0.002f - 3e-4f);
      }
    }
  }
  int resting = 0;
  for (std::size_t k = 0; k < debris.alive(); ++k) resting += debris.velocity(k) == glm::vec3(0);
  EXPECT_GT(resting, 10);
}

TEST(Debris, SuctionDoesNotDependOnTheTimeStep) {
  // Air near a nozzle is so fast that a chip would miss the nozzle if one step took as long as one picture.
  const Floor floor;
  const Suction suction{{0, 0.009, 0.003}, 5e-3, 2e-3};
  double sucked[2];
  for (const int tiny : {0, 1}) {
    Debris debris;
    Cut cut = cut_of(1, 0.5);
    cut.spindle = 100 * kKrpm;
    debris.emit(cut, {.head_radius = 0.6_mm}, table());
    for (int i = 0; i < 5; ++i) debris.step(1.0 / 60, floor.field);
    for (int i = 0; i < (tiny ? 600 : 6); ++i) debris.step(tiny ? 1.0 / 3600 : 1.0 / 36, floor.field, &suction);
    sucked[tiny] = debris.ledger().sucked / total(debris.ledger().born);
  }
  // The first long step still uses the drag of air at rest, so the results may differ.
  EXPECT_GT(sucked[1], 0.1);
  EXPECT_NEAR(sucked[0], sucked[1], 0.25 * sucked[1]);
}

TEST(Debris, DragIsRelativeToTheSuctionFlow) {
  // Far from tissue, suction draws air sideways. Light dust must then have the speed of the air.
  Debris debris({.min_chip = 6e-6, .max_chip = 6e-6, .gravity_W = {0, 0, 0}, .scatter = 0});
  Cut cut = cut_of(1, 1e-4);
  cut.spindle = 0;
  debris.emit(cut, {.head_radius = 0.6_mm}, table());
  const Suction suction{{0.1, 0, 0}, 5e-3, 4e-3};
  for (int i = 0; i < 40; ++i) debris.step(1e-3, {}, &suction);
  std::vector<DebrisPoint> point(1);
  ASSERT_EQ(debris.write_points(point), 1u);
  const dvec3 way = suction.p_W - dvec3(point[0].p_W);
  const double air = suction.flow / (4 * kPi * glm::dot(way, way));
  EXPECT_NEAR(glm::length(dvec3(debris.velocity(0))), air, 0.02 * air);
}

TEST(Debris, MassDecaysAndVanishesAfterItsLifetime) {
  Debris debris({.decay_time = 0.5, .lifetime = 2});
  debris.emit(cut_of(1, 0.1), {.head_radius = 0.6_mm}, table());
  const double start = debris.ledger().alive;
  for (int i = 0; i < 100; ++i) debris.step(0.01, {});
  EXPECT_NEAR(debris.ledger().alive / start, std::exp(-2.0), 1e-6);
  for (int i = 0; i < 101; ++i) debris.step(0.01, {});
  EXPECT_EQ(debris.alive(), 0u);
}

std::uint64_t hash_of(const Debris& debris) {
  std::vector<DebrisPoint> points(debris.alive());
  points.resize(debris.write_points(points));
  Fnv1a hash;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::vec3 v = debris.velocity(i);
    for (int a = 0; a < 3; ++a) hash.add(points[i].p_W[a]), hash.add(v[a]);
    hash.add(points[i].diameter);
  }
  return hash.value;
}

TEST(Debris, TheSameSeedGivesTheSameBitsAndAnotherSeedGivesOthers) {
  const Floor floor;
  std::uint64_t hashes[3];
  for (int run = 0; run < 3; ++run) {
    Debris debris({.capacity = 3000, .seed = run == 2 ? 5u : 4u, .lifetime = 0.3});
    for (std::uint64_t i = 1; i <= 200; ++i) {
      debris.emit(cut_of(i, 0.02), {.head_radius = 0.6_mm}, table());
      debris.step(1.0 / 300, floor.field);
    }
    EXPECT_GT(debris.alive(), 500u);
    hashes[run] = hash_of(debris);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_NE(hashes[0], hashes[2]);
}

TEST(Debris, NeverAllocatesAndDoesNothingWhenNoneAreAlive) {
  Debris debris({.capacity = 1000});
  const Floor floor;
  const MaterialTable materials = table();
  std::vector<DebrisPoint> points(1000);
  test::NoAlloc guard;
  debris.step(0.01, floor.field);
  const bool untouched = debris.write_points(points) == 0;
  for (std::uint64_t i = 1; i <= 100; ++i) {
    debris.emit(cut_of(i, 0.05), {.head_radius = 0.6_mm}, materials);
    debris.step(0.01, floor.field);
    debris.write_points(points);
  }
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(untouched);
}

}  // namespace
}  // namespace typodont::debris
