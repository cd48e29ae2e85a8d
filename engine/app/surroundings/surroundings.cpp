#include "engine/app/surroundings/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/field/field_mesh.h"
#include "engine/app/field/plane_face.h"
#include "engine/app/field/tooth_field.h"

namespace typodont {

namespace {

constexpr double kToothVoxel = 0.15e-3, kGumVoxel = 0.36e-3;  // m, voxel sizes of bodies that are only drawn
// Mesh tolerances in voxels, of the fine and the coarse mesh.
constexpr std::array<float, 2> kToothTolerance{0.15f, 0.45f}, kGumTolerance{0.12f, 0.30f};
constexpr double kCoarseFrom = 45e-6;  // m, surface error above which the coarse mesh is used
constexpr double kRootShown = 2.5e-3;  // m, depth below the gum's edge at which the drawn neighbours end
constexpr double kReach = 3e-3;        // m, distance around the tooth up to which its distance field is computed
constexpr double kGumInside = 0.4e-3;  // m, depth to which the gum enters the working tooth, so that no gap is visible
constexpr double kJawDepth = 9e-3;     // m, least depth of the jaw below the gum's edge
constexpr double kCoveredBelow = 0.6e-3;                    // m below the gum's edge, where the gum hides the root
constexpr double kCollarBlend = 1.0e-3;                     // m, blending length of the collar
constexpr double kToothFace = 0.15e-3, kGumFace = 0.30e-3;  // m, cell sizes of the section's faces
// m, overlap of the gum's face with the faces of the teeth, so that no gap is visible.
constexpr double kFaceOverlap = 0.05e-3;
constexpr double kFaceUnder = 10e-6;  // m, distance by which the gum's face lies behind the faces of the teeth

/// Smooth minimum (Quilez): rounds the edge between two solids over a width of k.
double smooth_min(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}
double smooth_max(double a, double b, double k) {
  return -smooth_min(-a, -b, k);
}

/// Transforms points of a neighbour to the tooth from which it is copied.
struct ToothCopy {
  NeighbourTooth place;
  dvec3 arch, crown, across;
  double least_scale;

  ToothCopy(const NeighbourTooth& n, const SurroundingsPlan& plan)
      : place(n),
        arch(plan.arch),
        crown(plan.crown),
        across(glm::cross(plan.crown, plan.arch)),
        least_scale(std::min({n.scale.x, n.scale.y, n.scale.z})) {}

  /// Transforms a point of the neighbour to the original tooth; from_tooth() is the inverse.
  dvec3 to_tooth(const dvec3& p_W) const {
    const dvec3 r = p_W - place.contact;
    const double c = std::cos(place.turn), s = std::sin(place.turn);
    const double u = glm::dot(r, arch), v = glm::dot(r, across), w = glm::dot(r, crown);
    return place.contact - arch * ((c * u + s * v) / place.scale.x) + across * ((c * v - s * u) / place.scale.y) +
           crown * (w / place.scale.z);
  }
  dvec3 from_tooth(const dvec3& p_W) const {
    const dvec3 r = p_W - place.contact;
    const double u = -glm::dot(r, arch) * place.scale.x, v = glm::dot(r, across) * place.scale.y;
    const double c = std::cos(place.turn), s = std::sin(place.turn);
    return place.contact + arch * (c * u - s * v) + across * (s * u + c * v) +
           crown * (glm::dot(r, crown) * place.scale.z);
  }
  double distance(const ToothField& tooth, const dvec3& p_W) const {
    return tooth.distance(to_tooth(p_W)) * least_scale;
  }
};

struct Box {
  dvec3 lo, hi;  // m, bounds in W
};
void grow(dvec3& lo, dvec3& hi, const dvec3& p) {
  lo = glm::min(lo, p);
  hi = glm::max(hi, p);
}

}  // namespace

struct SurroundingsShape::Impl {
  SurroundingsPlan plan;
  ToothField tooth;
  std::vector<ToothCopy> copies;
  dvec3 across, middle;
  double jaw_depth = kJawDepth, half_width = 0;

  explicit Impl(const SurroundingsPlan& p)
      : plan(p),
        tooth(haptics::TissueVolume::load(p.volume), kReach),
        across(glm::cross(p.crown, p.arch)),
        middle(0.5 * (tooth.low() + tooth.high())) {
    for (const NeighbourTooth& n : plan.neighbours) copies.emplace_back(n, plan);
    if (!plan.gum) return;
    // Make the jaw deep enough for the roots.
    for (int corner = 0; corner < 8; ++corner)
      jaw_depth = std::max(jaw_depth, 1.5e-3 + below_plane({corner & 1 ? tooth.high().x : tooth.low().x,
                                                            corner & 2 ? tooth.high().y : tooth.low().y,
                                                            corner & 4 ? tooth.high().z : tooth.low().z}));
    // Find half the width of the row of teeth at the gum; the jaw is slightly wider.
    for (double v = 0; v < 12e-3; v += 0.1e-3)
      for (const double side : {-1.0, 1.0}) {
        const dvec3 q = middle + across * (side * v) - plan.crown * glm::dot(middle - plan.margin, plan.crown);
        if (tooth.distance(q) < 0) half_width = std::max(half_width, v);
      }
  }

  Box box(const ToothCopy& copy) const {
    Box b{dvec3(1e9), dvec3(-1e9)};
    for (int corner = 0; corner < 8; ++corner)
      grow(b.lo, b.hi,
           copy.from_tooth({corner & 1 ? tooth.high().x : tooth.low().x, corner & 2 ? tooth.high().y : tooth.low().y,
                            corner & 4 ? tooth.high().z : tooth.low().z}));
    return b;
  }
  Box gum_box() const {
    const dvec3 reach = glm::abs(plan.arch) * (plan.length / 2 + 1e-3) + glm::abs(across) * (half_width + 4e-3);
    const dvec3 edge = middle - plan.crown * glm::dot(middle - plan.margin, plan.crown);
    Box b{edge - reach, edge + reach};
    grow(b.lo, b.hi, edge + reach + plan.crown * (plan.papilla + 3e-3));
    grow(b.lo, b.hi, edge - reach + plan.crown * (plan.papilla + 3e-3));
    grow(b.lo, b.hi, edge + reach - plan.crown * (jaw_depth + 3e-3));
    grow(b.lo, b.hi, edge - reach - plan.crown * (jaw_depth + 3e-3));
    return b;
  }

  /// Depth of p below the plane of the gum's edge, along the crown's axis.
  double below_plane(const dvec3& p) const {
    return glm::dot(plan.margin - p, plan.margin_normal) / glm::dot(plan.crown, plan.margin_normal);
  }
  double neighbour(const ToothCopy& copy, const dvec3& p) const {
    const double d = copy.distance(tooth, p);
    return plan.gum ? std::max(d, below_plane(p) - kRootShown) : d;
  }
  double gum(const dvec3& p) const {
    const double own = tooth.distance(p);
    double teeth = own, raise = 0;
    for (const ToothCopy& copy : copies) {
      teeth = smooth_min(teeth, copy.distance(tooth, p), 1.8e-3);
      // Between two teeth the gum rises towards their contact point and fills the gap below it.
      const double away = glm::dot(p - copy.place.contact, plan.arch) / 2.0e-3;
      raise = std::max(raise, plan.papilla * std::exp(-away * away));
    }
    const double deep = below_plane(p) + raise;  // depth below the gum's edge at this point
    // The collar has zero thickness at its edge and becomes thicker on the root below.
    const double swell = plan.thickness * 1.5;
    const double thick = deep > 0 ? plan.thickness * (1 - std::exp(-deep / swell)) : deep / 1.5;
    const double collar = teeth - thick;
    // The jaw below the collar: a bar along the arch with rounded edges, wider at the bottom.
    const dvec3 r = p - middle;
    const double depth = below_plane(p), down = std::max(depth, 0.0);
    const double side = std::abs(glm::dot(r, across)) - (half_width + 0.6e-3 + 0.9e-3 * (1 - std::exp(-down / 3e-3)));
    const double end = std::abs(glm::dot(r, plan.arch)) - plan.length / 2;
    double jaw = smooth_max(side, 1.4e-3 - depth, 4e-3);
    jaw = smooth_max(jaw, end, 4e-3);
    jaw = smooth_max(jaw, depth - jaw_depth, 2e-3);
    const double body = smooth_max(smooth_min(jaw, collar, kCollarBlend), depth - jaw_depth, 0.5e-3);
    return std::max(body, -own - kGumInside);  // hollow at the working tooth: a bur in the tooth meets no gum
  }
};

SurroundingsShape::SurroundingsShape(const SurroundingsPlan& plan) : impl_(std::make_unique<const Impl>(plan)) {}
SurroundingsShape::~SurroundingsShape() = default;
SurroundingsShape::SurroundingsShape(SurroundingsShape&&) noexcept = default;
SurroundingsShape& SurroundingsShape::operator=(SurroundingsShape&&) noexcept = default;
bool SurroundingsShape::has_neighbours() const {
  return !impl_->copies.empty();
}
bool SurroundingsShape::has_gum() const {
  return impl_->plan.gum;
}
double SurroundingsShape::neighbour(const dvec3& p_W) const {
  double nearest = 1.0;
  for (const ToothCopy& copy : impl_->copies) nearest = std::min(nearest, impl_->neighbour(copy, p_W));
  return nearest;
}
double SurroundingsShape::gum(const dvec3& p_W) const {
  return impl_->plan.gum ? impl_->gum(p_W) : 1.0;
}
double SurroundingsShape::tooth(const dvec3& p_W) const {
  return impl_->tooth.distance(p_W);
}

std::vector<render::MeshUpdate> SurroundingsShape::section_face(const dvec3& normal, double offset,
                                                                const dvec3& origin) const {
  const Impl& shape = *impl_;
  std::vector<render::MeshUpdate> face;
  std::uint64_t body = 0;
  const auto add = [&](std::vector<render::MeshUpdate> of_body) {
    for (render::MeshUpdate& update : of_body) {
      update.brick |= body << 60;  // each body has brick numbers of its own
      face.push_back(std::move(update));
    }
    ++body;
  };
  // The surface of a neighbour ends shortly below the gum, where it is invisible; but the neighbour's face in a section
  // shows the root within the gum.
  const auto with_root = [&](const ToothCopy& copy, const dvec3& p) {
    const double whole = copy.distance(shape.tooth, p);
    return shape.plan.gum && whole < kToothFace ? std::min(shape.neighbour(copy, p), std::max(whole, shape.gum(p)))
                                                : whole;
  };
  for (const ToothCopy& copy : shape.copies) {
    const auto [lo, hi] = shape.box(copy);
    add(plane_face(
        {normal, offset}, lo, hi, kToothFace, origin, [&](const dvec3& p) { return with_root(copy, p); },
        [&](const dvec3& p) { return shape.tooth.fractions(copy.to_tooth(p)); }));
  }
  if (!shape.plan.gum) return face;
  const auto [lo, hi] = shape.gum_box();
  add(plane_face(
      {normal, offset, kFaceUnder}, lo, hi, kGumFace, origin,
      [&](const dvec3& p) {
        double d = shape.gum(p);
        if (d > kGumFace) return d;
        d = std::max(d, -shape.tooth.distance(p) - kFaceOverlap);
        for (const ToothCopy& copy : shape.copies) d = std::max(d, -copy.distance(shape.tooth, p) - kFaceOverlap);
        return d;
      },
      [](const dvec3&) {
        std::array<double, kTissueCount> all{};
        all[static_cast<std::size_t>(Tissue::kGingiva)] = 1;
        return all;
      }));
  return face;
}

Surroundings make_surroundings(const SurroundingsPlan& plan) {
  const SurroundingsShape whole(plan);
  const SurroundingsShape::Impl& shape = *whole.impl_;
  const ToothField& tooth = shape.tooth;

  Surroundings result;
  result.coarse_from = kCoarseFrom;
  std::vector<SurroundingMesh>& meshes = result.meshes;
  render::MeshId id = render::kWorkingTooth + 1;
  for (const ToothCopy& copy : shape.copies) {
    const auto [lo, hi] = shape.box(copy);
    auto [fine, coarse] = meshes_of_field<2>(
        lo, hi, kToothVoxel, kToothTolerance, [&](const dvec3& p) { return shape.neighbour(copy, p); },
        [&](const dvec3& p) {
          // Show dentin instead of pulp at the cut end of the root: the end is hidden in the gum, but a section shows
          // it from inside.
          const Tissue found = tooth.tissue_at_surface(copy.to_tooth(p));
          return found == Tissue::kPulp ? Tissue::kDentin : found;
        });
    shade_by_slope(coarse, lo, 0.5 * kToothVoxel, [&](const dvec3& p) { return shape.neighbour(copy, p); });
    meshes.push_back({id++, lo, std::move(fine), std::move(coarse)});
  }
  if (!plan.gum) return result;

  const auto [lo, hi] = shape.gum_box();
  auto [fine, coarse] = meshes_of_field<2>(
      lo, hi, kGumVoxel, kGumTolerance, [&](const dvec3& p) { return shape.gum(p); },
      [](const dvec3&) { return Tissue::kGingiva; });
  shade_by_slope(coarse, lo, 0.5 * kGumVoxel, [&](const dvec3& p) { return shape.gum(p); });
  meshes.push_back({id, lo, std::move(fine), std::move(coarse)});
  result.covered = glm::dvec4(plan.margin_normal, kCoveredBelow - glm::dot(plan.margin_normal, plan.margin));
  return result;
}

Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan) {
  return plan ? make_surroundings(*plan) : Surroundings{};
}

std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan) {
  if (!plan) return std::nullopt;
  return SurroundingsShape(*plan);
}

}  // namespace typodont
