#include "tests/support/model_tissues.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/solid.h"

namespace typodont::test {

using haptics::read_solids;
namespace mesh_lod = haptics::mesh_lod;

namespace {

using namespace literals;

constexpr double kTick = 1e-3;  // s, period of the servo
constexpr int kDescent = 60;    // number of ticks in which the hand moves from the air to the surface
constexpr int kTurn = 60;       // on a tooth or jaw mesh: number of ticks after which the hand turns

/// Makes a prism along y with the cross-section `xz` (counter-clockwise, with x to the right and z up). Each end is a
/// fan of triangles around the first point.
TissueMesh prism(std::initializer_list<glm::dvec2> xz, double half_length) {
  TissueMesh mesh;
  const auto n = static_cast<std::uint32_t>(xz.size());
  for (const double y : {-half_length, half_length})
    for (const glm::dvec2& p : xz) mesh.vertices.push_back({p.x, y, p.y});
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, n + j, j});
    mesh.triangles.push_back({i, n + i, n + j});
    if (i == 0 || j == 0) continue;
    mesh.triangles.push_back({0, i, j});
    mesh.triangles.push_back({n, n + j, n + i});
  }
  mesh.tissue.assign(mesh.triangles.size(), Tissue::kDentin);
  return mesh;
}

TissueMesh box(double half_x, double half_y, double half_z) {
  return prism({{-half_x, -half_z}, {half_x, -half_z}, {half_x, half_z}, {-half_x, half_z}}, half_y);
}

std::function<TissueVolume(double)> sampled(std::string solid) {
  return [solid = std::move(solid)](double voxel_mm) {
    return TissueVolume(read_solids(Json::parse(
        fmt::format(R"({{"voxel_mm": {:g}, "solids": [{{"tissue": "dentin", "solid": {}}}]}})", voxel_mm, solid),
        "tissue")));
  };
}

/// Returns the direction of a motion around a body. The direction turns about an oblique axis, so that the hand crosses
/// faces and edges.
dvec3 around(int, const dvec3&, const dvec3& n) {
  return glm::cross(dvec3(0.1, 1, 0.25), n);
}

}  // namespace

std::vector<ModelTissue> analytic_tissues() {
  std::vector<ModelTissue> all;
  all.push_back({"ball", ExactShape::ball(4.0_mm), sampled(R"({"sphere": {"radius_mm": 4}})"),
                 5.0_mm * glm::normalize(dvec3(0.3, 0.1, 1)), around});
  all.push_back({"torus", ExactShape::torus(4.0_mm, 1.5_mm),
                 sampled(R"({"torus": {"axis": [0, 0, 1], "major_mm": 4, "minor_mm": 1.5}})"), dvec3(4.0_mm, 0, 2.5_mm),
                 [](int, const dvec3& c, const dvec3& n) {
                   const dvec3 along = glm::normalize(dvec3(-c.y, c.x, 0));  // unit vector along the tube of the torus
                   return glm::cross(along, n) + 0.4 * along;
                 }});
  all.push_back({"box edges", ExactShape::triangles(box(3.0_mm, 3.0_mm, 2.0_mm)),
                 sampled(R"({"box": {"size_mm": [6, 6, 4]}})"), dvec3(0.2_mm, 0.1_mm, 3.0_mm), around});
  all.push_back({"thin sheet", ExactShape::triangles(box(3.0_mm, 3.0_mm, 0.15_mm)),
                 sampled(R"({"box": {"size_mm": [6, 6, 0.3]}})"), dvec3(0.2_mm, 0.1_mm, 1.2_mm), around, false});
  // The tissue is a block with a groove in its top. The groove is 2 mm deep and has an angle of 60 degrees.
  const double mouth = 2.0_mm * std::tan(30 * kDegree);
  all.push_back(
      {"groove",
       ExactShape::triangles(prism(
           {{0, -2.0_mm}, {-mouth, 0}, {-4.0_mm, 0}, {-4.0_mm, -3.0_mm}, {4.0_mm, -3.0_mm}, {4.0_mm, 0}, {mouth, 0}},
           3.0_mm)),
       sampled(R"({"difference": [{"box": {"center_mm": [0, 0, -1.5], "size_mm": [8, 6, 3]}},
                   {"intersection": [{"box": {"size_mm": [8, 8, 8]}},
                     {"halfspace": {"normal": [0.8660254037844387, 0, -0.5], "offset_mm": 1}},
                     {"halfspace": {"normal": [-0.8660254037844387, 0, -0.5], "offset_mm": 1}}]}]})"),
       dvec3(-2.0_mm, -1.0_mm, 1.0_mm), [](int i, const dvec3& c, const dvec3&) {
         // The hand moves back and forth across the groove, and slowly along the groove.
         const bool there = (i / 250) % 2 == 0;
         return dvec3(there ? 1 : -1, c.y < 1.5_mm ? 0.15 : 0, 0);
       }});
  return all;
}

ModelTissue sheet_tissue(double thickness_mm, double width_mm) {
  const double half = 0.5 * thickness_mm * kMillimetre;
  return {fmt::format("sheet of {:g} mm", thickness_mm),
          ExactShape::triangles(box(0.5 * width_mm * kMillimetre, 0.5 * width_mm * kMillimetre, half)),
          sampled(fmt::format(R"({{"box": {{"size_mm": [{0:g}, {0:g}, {1:g}]}}}})", width_mm, thickness_mm)),
          dvec3(0, 0, half + kProbeRadius + 0.5_mm),
          around,
          false};
}

ModelTissue mesh_tissue(const std::string& name, const TissueMesh& mesh, std::function<TissueVolume(double)> make,
                        const dvec3& start, std::vector<double> voxels_mm) {
  return {name,
          ExactShape::triangles(mesh),
          std::move(make),
          start + dvec3(0, 0, kProbeRadius + 0.5_mm),
          [](int i, const dvec3&, const dvec3&) {
            // rad; the angle is a multiple of the golden angle, so that the direction never repeats
            const double turn = 2.4 * (i / kTurn);
            return dvec3(std::cos(turn), std::sin(turn), 0);
          },
          true,
          std::move(voxels_mm)};
}

Course slide_course(const ModelTissue& tissue, int ticks, const Slide& slide) {
  ReferenceContact contact(tissue.shape, slide.radius);
  contact.place(tissue.start);
  const ExactShape::Nearest below = tissue.shape.nearest(tissue.start, 5.0_mm);
  dvec3 n = glm::normalize(tissue.start - below.p);
  const dvec3 deepest = below.p + (slide.radius - slide.depth) * n;
  Course course;
  for (int i = 0; i < ticks; ++i) {
    dvec3 hand;
    if (i < kDescent) {
      hand = glm::mix(tissue.start, deepest, static_cast<double>(i) / (kDescent - 1));
    } else {
      const dvec3 wanted = tissue.ahead(i - kDescent, contact.center(), n);
      const dvec3 along = wanted - glm::dot(wanted, n) * n;
      const double length = glm::length(along);
      hand = contact.center() - slide.depth * n + (length > 0 ? slide.speed * kTick / length * along : dvec3(0));
    }
    const dvec3& center = contact.follow(hand);
    if (glm::distance(center, hand) > 1e-6) n = glm::normalize(center - hand);
    course.hand.push_back(hand);
    course.truth.push_back(center);
  }
  return course;
}

Course tap_course(const ModelTissue& tissue) {
  ReferenceContact contact(tissue.shape, kProbeRadius);
  contact.place(tissue.start);
  const ExactShape::Nearest below = tissue.shape.nearest(tissue.start, 5.0_mm);
  const dvec3 n = glm::normalize(tissue.start - below.p);
  const double from = glm::distance(tissue.start, below.p) - kProbeRadius;
  Course course;
  const auto go_to = [&](double height) {
    const dvec3 hand = below.p + (kProbeRadius + height) * n;
    course.hand.push_back(hand);
    course.truth.push_back(contact.follow(hand));
  };
  for (int i = 0; i < 30; ++i) go_to(from);
  for (const double speed : {10e-3, 30e-3, 100e-3, 200e-3}) {
    const int steps = static_cast<int>((from + kHandDepth) / (speed * kTick)) + 1;
    for (int i = 1; i <= steps; ++i) go_to(from - (from + kHandDepth) * i / steps);
    for (int i = 0; i < 40; ++i) go_to(-kHandDepth);
    for (int i = steps - 1; i >= 0; --i) go_to(from - (from + kHandDepth) * i / steps);
    for (int i = 0; i < 40; ++i) go_to(from);
  }
  return course;
}

PressingHand::PressingHand(const ModelTissue& tissue) {
  const ExactShape::Nearest below = tissue.shape.nearest(tissue.start, 5e-3);
  n_ = glm::normalize(tissue.start - below.p);
  side_ = glm::normalize(glm::cross(n_, std::abs(n_.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0)));
  rest_ = below.p + (kProbeRadius + 2e-5) * n_;
  x_ = rest_;
}

const dvec3& PressingHand::next(const dvec3& force, double dt) {
  const dvec3 center = rest_ + 0.5e-3 * std::sin(2 * kPi * 1e-3 * tick_++) * side_;
  dvec3 pull = 2000.0 * (center - x_);
  pull -= glm::dot(pull, n_) * n_;
  v_ += dt * (pull - 1.0 * n_ - 5.0 * v_ + force) / 0.15;
  x_ += dt * v_;
  return x_;
}

double swept_volume(const ExactShape& shape, const std::vector<std::pair<dvec3, dvec3>>& segments, double radius,
                    double step) {
  if (segments.empty()) return 0;
  dvec3 lo(1e9), hi(-1e9);
  for (const auto& [a, b] : segments) lo = glm::min(lo, glm::min(a, b)), hi = glm::max(hi, glm::max(a, b));
  lo -= radius + step, hi += radius + step;
  const glm::ivec3 size = glm::ivec3((hi - lo) / step) + 1;
  std::vector<char> covered(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                            static_cast<std::size_t>(size.z));
  const auto at = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(z);
  };
  for (const auto& [a, b] : segments) {
    const glm::ivec3 first = glm::max(glm::ivec3((glm::min(a, b) - radius - lo) / step), 0);
    const glm::ivec3 last = glm::min(glm::ivec3((glm::max(a, b) + radius - lo) / step) + 1, size - 1);
    for_each_voxel_between(first, last, [&](int x, int y, int z) {
      char& c = covered[at(x, y, z)];
      if (c) return;
      const dvec3 p = lo + step * dvec3(x, y, z);
      const dvec3 off = p - nearest_on_segment(a, b, p);
      c = glm::dot(off, off) <= radius * radius;
    });
  }
  std::size_t count = 0;
  for_each_voxel(size, [&](int x, int y, int z) {
    if (covered[at(x, y, z)] && shape.nearest(lo + step * dvec3(x, y, z), 4 * radius).distance < 0) ++count;
  });
  return static_cast<double>(count) * step * step * step;
}

}  // namespace typodont::test
