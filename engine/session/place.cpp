#include "engine/session/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont::session {

namespace {

// Largest allowed |cosine| between the mesial and buccal directions.
constexpr double kSquare = 0.05;
// If the cosine between normal and axis is larger than this, the place is floor, occlusal surface or shoulder;
// otherwise wall.
constexpr double kLevel = 0.7;
// If the cosine between the task's axis and the occlusal direction is less than this, the work is done from the side.
constexpr double kUpright = 0.8;
// Fraction of Work::half_width within which the place is "central".
constexpr double kCentral = 0.25;
// m; a place within kMarginDepth of the old surface and within kMarginWidth of the planned cut is at the margin.
constexpr double kMarginDepth = 0.3e-3, kMarginWidth = 0.5e-3;

/// Extent of all tissue that the user changed or should have changed.
struct Work {
  dvec3 middle_W{0};         // m, frame W, centre of the tissue's extent
  double low = 0, high = 0;  // m, lowest and highest point along the task's axis
  double half_width = 0;     // m, radius of the extent around the axis through its middle
  // True: the target shape has tissue in the middle, for example a crown's stump or a filling.
  bool around_tissue = false;
};

Work work_of(const Preparation& in) {
  const DenseField& wanted = in.ideal.distance.empty() ? in.after : in.ideal;
  const auto each = [&](const auto& visit) {
    const glm::ivec3& n = in.before.size;
    for_each_voxel(n, [&](int x, int y, int z) {
      const std::size_t i = in.before.at(x, y, z);
      const bool was = in.before.distance[i] < 0;
      if (was != (in.after.distance[i] < 0) || was != (wanted.distance[i] < 0))
        visit(in.frame.to_world(dvec3(x, y, z)));
    });
  };
  Work work;
  double count = 0;
  each([&](const dvec3& p) { work.middle_W += p, ++count; });
  if (count == 0) return work;
  work.middle_W /= count;
  work.low = 1e9, work.high = -1e9;
  each([&](const dvec3& p) {
    const dvec3 off = p - work.middle_W;
    const double height = glm::dot(p, in.axis_W);
    work.low = std::min(work.low, height);
    work.high = std::max(work.high, height);
    work.half_width = std::max(work.half_width, glm::length(off - glm::dot(off, in.axis_W) * in.axis_W));
  });
  work.around_tissue = in.contour || wanted.sample(in.frame.to_voxels(work.middle_W)) < 0;
  return work;
}

/// True if p_W is just below the surface before the work, beside tissue that the ideal shape removes.
bool at_margin(const Preparation& in, const dvec3& p_W) {
  const dvec3 p = in.frame.to_voxels(p_W);
  if (in.contour || in.ideal.distance.empty() || in.ideal.sample(p) > -0.5 ||
      std::abs(in.before.sample(p)) * in.frame.voxel > kMarginDepth)
    return false;
  const auto reach = static_cast<int>(std::ceil(kMarginWidth / in.frame.voxel));
  const glm::ivec3 v(glm::round(p)), lo = glm::max(v - reach, glm::ivec3(0)),
                                     hi = glm::min(v + reach, in.before.size - 1);
  for (int x = lo.x; x <= hi.x; ++x)
    for (int y = lo.y; y <= hi.y; ++y)
      for (int z = lo.z; z <= hi.z; ++z) {
        const std::size_t i = in.before.at(x, y, z);
        if (in.before.distance[i] < -1 && in.ideal.distance[i] > 0) return true;
      }
  return false;
}

/// Sides every 45° from mesial; 90°: buccal, or occlusal if the work is done from the buccal or lingual side.
using Sides = std::array<std::string_view, 8>;
constexpr Sides kFromAbove = {"mesial", "mesiobuccal",  "buccal",  "distobuccal",
                              "distal", "distolingual", "lingual", "mesiolingual"};
constexpr Sides kFromTheSide = {"mesial", "mesioocclusal", "occlusal", "distoocclusal",
                                "distal", "distocervical", "cervical", "mesiocervical"};

}  // namespace

void describe_tooth(Keys& keys, ToothSides& sides) {
  keys(must("mesial"), sides.mesial_W, read_direction, "mesial");
  keys(must("buccal"), sides.buccal_W, read_direction, "buccal");
  const auto occlusal = keys("occlusal", kDirection, "occlusal; default: the task's `axis`");
  if (!keys.json()) return;
  const double along = glm::dot(sides.mesial_W, sides.buccal_W);
  if (std::abs(along) > kSquare) (*keys.json())["buccal"].fail("a direction square to \"mesial\"");
  sides.buccal_W = glm::normalize(sides.buccal_W - along * sides.mesial_W);
  if (!occlusal) return;
  const dvec3 across = glm::normalize(glm::cross(sides.mesial_W, sides.buccal_W));
  const double up = glm::dot(read_direction(*occlusal), across);
  if (std::abs(up) < 1 - kSquare) occlusal->fail("a direction square to \"mesial\" and \"buccal\"");
  sides.occlusal_W = up > 0 ? across : -across;
}

std::optional<ToothSides> tooth_sides(const Json& scene) {
  const auto tooth = scene.find("tooth");
  if (!tooth) return std::nullopt;
  return read_keys(*tooth, describe_tooth);
}

PlaceName place_name(const Preparation& in, const ToothSides& tooth, const dvec3& p_W) {
  const Work work = work_of(in);
  const dvec3 off = p_W - work.middle_W;
  const bool from_the_side = tooth.occlusal_W && glm::dot(*tooth.occlusal_W, in.axis_W) < kUpright;
  const dvec3& across_W = from_the_side ? *tooth.occlusal_W : tooth.buccal_W;
  const double mesial = glm::dot(off, tooth.mesial_W), across = glm::dot(off, across_W);
  PlaceName name;
  if (std::hypot(mesial, across) < kCentral * work.half_width) {
    name.side = "central";
  } else {
    const double eighths = std::round(std::atan2(across, mesial) / (kPi / 4));
    name.side =
        (from_the_side ? kFromTheSide : kFromAbove)[static_cast<std::size_t>(static_cast<int>(eighths + 8) % 8)];
  }
  // 0 at the cervical end, 1 at the occlusal end.
  const double height = work.high > work.low ? (glm::dot(p_W, in.axis_W) - work.low) / (work.high - work.low) : 0.5;
  const std::string_view third = height > 2.0 / 3 ? "occlusal" : height > 1.0 / 3 ? "middle" : "cervical";
  if (at_margin(in, p_W)) {
    name.part = "margin";
    return name;
  }
  const dvec3 out = in.after.gradient(in.frame.to_voxels(p_W), 1.0);
  const bool level = glm::length(out) > 0 && glm::dot(out, in.axis_W) > kLevel * glm::length(out);
  if (!level) {
    name.part = work.around_tissue ? "axial" : "wall";
    if (!from_the_side) name.third = third;
  } else if (!work.around_tissue) {
    name.part = "floor";
  } else if (from_the_side) {
    name.part = glm::dot(tooth.buccal_W, in.axis_W) > 0 ? "buccal" : "lingual";
  } else {
    name.part = third == "occlusal" ? "occlusal" : "shoulder";
  }
  return name;
}

std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W) {
  // A side is seen if the cosine between the viewing direction and the side's direction is larger than this.
  constexpr double kSquarely = 0.95;
  const dvec3 to_eye = -glm::normalize(look_W);
  const auto along = [&](const dvec3& side) { return glm::dot(to_eye, side); };
  if (along(tooth.occlusal_W.value_or(axis_W)) > kSquarely) return "occlusal";
  if (along(tooth.mesial_W) > kSquarely) return "mesial";
  if (along(tooth.mesial_W) < -kSquarely) return "distal";
  if (along(tooth.buccal_W) > kSquarely) return "buccal";
  if (along(tooth.buccal_W) < -kSquarely) return "lingual";
  return "";
}

std::string place_text(const PlaceName& place, Language language) {
  const auto say = [&](std::string_view kind, std::string_view key) {
    return std::string(text(fmt::format("place.{}.{}", kind, key), language));
  };
  const std::string where =
      fmt::format(fmt::runtime(text("place.part_and_side", language)), fmt::arg("part", say("part", place.part)),
                  fmt::arg("side", say("side", place.side)));
  if (place.third.empty()) return where;
  return fmt::format(fmt::runtime(text("place.and_third", language)), where, say("third", place.third));
}

}  // namespace typodont::session
