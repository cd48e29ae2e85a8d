// Presses of a resting head at places where the exact contact is known: edges, rims, corners, cusps and thin walls.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/haptic_bench.h"

namespace typodont::test {

using namespace literals;

inline constexpr double kPressDepth = 0.2_mm;

/// The head is pressed at a point of a crease against the direction n; its surface normal there is -n.
struct Press {
  dvec3 p{0}, n{0};  // m and unit vector, W
  dquat R{1, 0, 0, 0};
};

struct PressErrors {
  std::vector<double> direction, force, position;  // degrees; relative; voxels

  static double quantile(std::vector<double> v, double q) {
    std::ranges::sort(v);
    return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
  }
  double median_direction() const { return quantile(direction, 0.5); }
  void print(const std::string& name) const {
    fmt::print("{:40} {} presses: direction {:.1e}/{:.1e} deg, force {:.1e}, position {:.1e} voxel\n", name,
               direction.size(), median_direction(), quantile(direction, 1), quantile(force, 1), quantile(position, 1));
  }
};

/// Moves the tool on a large sphere to a place above each press, and then along its normal. `r`: distance from the
/// head's centre to the contact.
inline PressErrors press_all(HapticBench& bench, double voxel, double r, const std::vector<Press>& presses,
                             std::uint32_t tool) {
  double far = 0;
  for (const Press& press : presses) far = std::max(far, glm::length(press.p));
  far += 2 * r + 4.0_mm;
  dvec3 above(0, 0, 1);
  PressErrors errors;
  for (const Press& press : presses) {
    const double along = glm::dot(press.p, press.n);
    const double way = std::sqrt(along * along - glm::dot(press.p, press.p) + far * far) - along;
    const dvec3 next = (press.p + way * press.n) / far;
    const auto hold = [&](const dvec3& p) { bench.tick({p, press.R}, 0, tool); };
    const auto go = [&](const dvec3& from, const dvec3& to) {
      for (int i = 1; i <= 40; ++i) hold(far * glm::normalize(glm::mix(from, to, i / 40.0)));
    };
    const dvec3 across = glm::normalize(glm::cross(above, dvec3(0.3, 0.5, 0.8)));
    if (glm::dot(above, next) < -0.5) go(std::exchange(above, across), across);  // around the solid
    go(above, next);
    above = next;
    for (double height = way; height > r + 0.05_mm; height -= 0.1_mm) hold(press.p + height * press.n);
    for (double height = r + 0.05_mm; height > r - kPressDepth; height -= 4e-6) hold(press.p + height * press.n);
    for (int i = 0; i < 60; ++i) hold(press.p + (r - kPressDepth) * press.n);
    const dvec3 f = bench.last.f_T_W;
    errors.direction.push_back(std::atan2(glm::length(glm::cross(f, press.n)), glm::dot(f, press.n)) / kDegree);
    errors.force.push_back(std::abs(glm::length(f) / (bench.settings.stiffness * kPressDepth) - 1));
    errors.position.push_back(glm::length(bench.last.X_WG.p - press.p - r * press.n) / voxel);
    for (double height = r; height < way; height += 0.1_mm) hold(press.p + height * press.n);
  }
  return errors;
}

struct PressCase {
  std::string name, solid;
  double diameter;  // m, of the ball
  std::vector<Press> presses;
};

inline constexpr int kPresses = 40;
using Random = std::mt19937;

inline double uniform(Random& random, double a, double b) {
  return std::uniform_real_distribution(a, b)(random);
}

/// Presses on the rim of a bore along z, at angles to the axis between `from` and `to`; negative: towards the axis.
inline std::vector<Press> on_rim(Random& random, const dvec3& center, double radius, double from, double to) {
  std::vector<Press> presses;
  for (int i = 0; i < kPresses; ++i) {
    const double a = uniform(random, 0, 2 * kPi), w = uniform(random, from, to);
    const dvec3 out(std::cos(a), std::sin(a), 0);
    presses.push_back({center + radius * out, std::sin(w) * out + dvec3(0, 0, std::cos(w))});
  }
  return presses;
}

inline std::vector<Press> on_corner(Random& random, const dvec3& corner) {
  std::normal_distribution<double> normal;
  std::vector<Press> presses;
  for (int i = 0; i < kPresses; ++i) {
    const dvec3 n = glm::normalize(glm::abs(dvec3(normal(random), normal(random), normal(random))));
    presses.push_back({corner, glm::normalize(glm::max(n, dvec3(0.08)))});
  }
  return presses;
}

inline constexpr double kBoreInBall = 0.24;  // rad; the rim's radius is a quarter of the ball's
inline const std::string kBore =
    R"({"difference": [{"sphere": {"radius_mm": 4}},
                       {"cylinder": {"center_mm": [0, 0, 4], "radius_mm": 1, "height_mm": 6}}]})";

inline const double kBoreTop = std::sqrt(15.0) * 1.0_mm;  // height of the bore's rim

/// Cases of a ball.
inline std::vector<PressCase> press_cases(Random& random) {
  std::vector<PressCase> cases;
  std::vector<Press> edge;
  for (int i = 0; i < kPresses; ++i) {
    const double a = uniform(random, 0.05, kPi / 2 - 0.05);
    edge.push_back({dvec3(3, uniform(random, -1.8, 1.8), 2) * 1.0_mm, {std::sin(a), 0, std::cos(a)}});
  }
  const std::string box = R"({"box": {"size_mm": [6, 5, 4]}})";
  cases.push_back({"edge of a box", box, 1.0_mm, edge});
  cases.push_back({"corner of a box", box, 1.0_mm, on_corner(random, dvec3(3, 2.5, 2) * 1.0_mm)});
  cases.push_back({"corner of a box between voxels", R"({"box": {"size_mm": [2.8, 1.9, 2.06]}})", 2.3_mm,
                   on_corner(random, dvec3(1.4, 0.95, 1.03) * 1.0_mm)});
  cases.push_back(
      {"rim of a bore, ball of 1 mm", kBore, 1.0_mm, on_rim(random, {0, 0, kBoreTop}, 1.0_mm, -1.2, kBoreInBall)});
  cases.push_back(
      {"rim of a bore, ball of 0.5 mm", kBore, 0.5_mm, on_rim(random, {0, 0, kBoreTop}, 1.0_mm, -1.2, kBoreInBall)});
  cases.push_back(
      {"rim of a bore, ball of 2 mm", kBore, 2.0_mm, on_rim(random, {0, 0, kBoreTop}, 1.0_mm, -1.2, kBoreInBall)});
  cases.push_back({"end of a cylinder", R"({"cylinder": {"radius_mm": 1.5, "height_mm": 4}})", 1.0_mm,
                   on_rim(random, {0, 0, 2.0_mm}, 1.5_mm, 0.05, kPi / 2 - 0.05)});
  // Between two bores, 0.4 mm apart.
  std::vector<Press> wall;
  for (int i = 0; i < kPresses; ++i) {
    const double a = uniform(random, -0.5, 0.5), w = uniform(random, -1.2, -0.03);
    const dvec3 out(std::cos(a), std::sin(a), 0);
    wall.push_back({dvec3(-1.2_mm, 0, 2.0_mm) + 1.0_mm * out, std::sin(w) * out + dvec3(0, 0, std::cos(w))});
  }
  cases.push_back({"wall between two bores",
                   R"({"difference": [{"box": {"size_mm": [8, 5, 4]}},
                       {"cylinder": {"center_mm": [-1.2, 0, 2], "radius_mm": 1, "height_mm": 3}},
                       {"cylinder": {"center_mm": [1.2, 0, 2], "radius_mm": 1, "height_mm": 3}}]})",
                   1.0_mm, wall});
  return cases;
}

inline std::string press_tissue(const std::string& solid, double voxel) {
  return fmt::format(R"({{"voxel_mm": {}, "solids": [{{"tissue": "enamel", "solid": {}}}]}})", voxel / 1.0_mm, solid);
}

inline haptics::ServoSettings press_probe(double diameter, const haptics::SharedContactMethod& method = nullptr) {
  haptics::ServoSettings s = probe_settings("offset");
  if (method) s.method = method;
  s.tool.diameter = s.tool.length = diameter;
  s.passivity = s.boundary_walls = false;
  return s;
}

/// Cases of balls from 1 to 10 mm on a cusp and on the corner of a small box.
inline std::vector<PressCase> large_ball_cases(Random& random) {
  std::normal_distribution<double> normal;
  std::vector<PressCase> cases;
  for (const double diameter : {1.0_mm, 4.0_mm, 10.0_mm}) {
    std::vector<Press> cusp;
    for (int i = 0; i < kPresses; ++i) {
      const dvec3 n = glm::normalize(dvec3(normal(random), normal(random), std::abs(normal(random))));
      cusp.push_back({0.8_mm * n, n});
    }
    const std::string ball = fmt::format("ball of {:g} mm", diameter / 1.0_mm);
    cases.push_back({"cusp, " + ball, R"({"sphere": {"radius_mm": 0.8}})", diameter, cusp});
    cases.push_back({"corner of a small box, " + ball, R"({"box": {"size_mm": [2.8, 1.9, 2.06]}})", diameter,
                     on_corner(random, dvec3(1.4, 0.95, 1.03) * 1.0_mm)});
  }
  return cases;
}
inline std::vector<PressCase> all_press_cases(Random& random) {
  std::vector<PressCase> cases = press_cases(random);
  for (PressCase& c : large_ball_cases(random)) cases.push_back(std::move(c));
  return cases;
}

/// Presses a ball at all places of a case.
inline PressErrors press_ball(const PressCase& c, double voxel, const haptics::SharedContactMethod& method = nullptr) {
  HapticBench bench(press_tissue(c.solid, voxel), press_probe(c.diameter, method));
  return press_all(bench, voxel, c.diameter / 2, c.presses, 0);
}

/// Drills the bore with a cylinder, and presses a ball of 1 mm on its rim.
inline PressErrors press_drilled_rim(Random& random, double voxel) {
  haptics::ServoSettings s = drill_settings("offset");
  s.tool.shape = haptics::HeadShape::kCylinder;
  s.tool.diameter = 2.0_mm, s.tool.length = 4.0_mm;
  s.passivity = s.boundary_walls = false;
  haptics::Tool ball;
  ball.diameter = ball.length = 1.0_mm;
  ball.cuts = false;
  s.tools = {s.tool, ball};
  MaterialTable materials = plain_materials();
  materials[static_cast<std::size_t>(Tissue::kEnamel)].specific_energy = 0.05e9;
  const Json tissue = Json::parse(press_tissue(R"({"sphere": {"radius_mm": 4}})", voxel), "tissue");
  HapticBench bench(haptics::TissueVolume(haptics::read_solids(tissue)), s, materials);
  for (double z = 7.0_mm; z > 3.3_mm; z -= 1e-6) bench.tick({{0, 0, z}}, 1);
  for (double z = 3.3_mm; z < 9.0_mm; z += 5e-6) bench.tick({{0, 0, z}}, z < 8.0_mm ? 1 : 0, z < 8.0_mm ? 0 : 1);
  for (int i = 0; i < 2000; ++i) bench.tick({{0, 0, 9.0_mm}}, 0, 1);
  return press_all(bench, voxel, 0.5_mm, on_rim(random, {0, 0, kBoreTop}, 1.0_mm, -1.2, kBoreInBall), 1);
}

/// Fills around a ball of 0.8 mm up to a radius of 2 mm, below the plane z = 1 mm, and presses a ball of 1 mm on the
/// rim where the filling's sphere meets this plane.
inline PressErrors press_filled_rim(Random& random, double voxel) {
  haptics::TissueVolume volume(
      haptics::read_solids(Json::parse(press_tissue(R"({"sphere": {"radius_mm": 0.8}})", voxel), "tissue")));
  haptics::Tool plugger;
  plugger.shape = haptics::HeadShape::kRoundEndCylinder;
  plugger.diameter = 0.5_mm, plugger.length = 1.0_mm;
  plugger.cuts = false;
  plugger.fill = Tissue::kComposite;
  plugger.fill_within =
      haptics::read_solid(Json::parse(R"({"halfspace": {"normal": [0, 0, 1], "offset_mm": 1}})", "limit"));
  const Pose away{{0, 0, 9.0_mm}};
  volume.fill(haptics::Fill(plugger, dvec3(0), 2.0_mm, away, volume.frame()));
  HapticBench bench(std::move(volume), press_probe(1.0_mm));
  const double steepest = std::acos(0.5) - 0.05;  // the sphere's normal at the rim, less a margin
  return press_all(bench, voxel, 0.5_mm, on_rim(random, {0, 0, 1.0_mm}, std::sqrt(3.0) * 1.0_mm, 0.05, steepest), 0);
}

}  // namespace typodont::test
