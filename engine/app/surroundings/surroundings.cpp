#include "engine/app/surroundings/surroundings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "engine/app/surroundings/dam.h"
#include "engine/app/surroundings/jaw.h"
#include "engine/app/tissue/blend.h"
#include "engine/app/tissue/field_mesh.h"
#include "engine/app/tissue/plane_face.h"
#include "engine/app/tissue/split_edges.h"
#include "engine/app/tissue/tooth_field.h"
#include "engine/render/drawn_matter.h"

namespace typodont {

namespace {

// Voxel sizes for meshing, m. A name with "Far" is for bodies farther than kNear from the working tooth.
constexpr double kToothVoxel = 0.15e-3, kFarToothVoxel = 0.36e-3, kGumVoxel = 0.36e-3, kFarGumVoxel = 0.8e-3;
constexpr double kDamVoxel = 0.36e-3, kFarDamVoxel = 0.8e-3, kClampVoxel = 0.18e-3, kMouthVoxel = 1.1e-3;
constexpr double kNear = 15e-3, kMouthReach = 38e-3;
// Largest distances of the triangles from the true surface, for the fine and the coarse mesh, voxels.
constexpr std::array<float, 2> kToothTolerance{0.15f, 0.45f}, kGumTolerance{0.12f, 0.30f};
// The cheek has small triangles in both meshes: a long triangle with a vertex behind the gum would be too dark.
constexpr std::array<float, 2> kCheekTolerance{0.12f, 0.12f};
// Where a fine mesh overlaps the coarse mesh: depth of the coarse mesh below the surface, m.
constexpr double kCoarseBelow = 0.5e-3;
// Width of the strip in which fine and coarse mesh overlap, m.
constexpr double kOverlap = 1.2e-3;
// If the picture allows larger surface errors than this, m, the coarse mesh is drawn.
constexpr double kCoarseFrom = 45e-6;
// Roots are drawn to this depth below the gum's edge, m.
constexpr double kRootShown = 2.5e-3;
// Height above the plane of the gum's edge from which on there is no root, m.
constexpr double kCrownFrom = 4e-3;
// Box in which light between bodies is computed, m: half its edge lengths, and height of its middle above the gum.
constexpr double kLitAlong = 15e-3, kLitAcross = 15e-3, kLitUp = 12e-3, kLitMiddle = 0.5e-3;
// Edges in the lit box (kLitAlong …) longer than this are split, m (fine, coarse mesh): light is computed per vertex.
constexpr std::array<float, 2> kLightEdge{1.6e-3f, 3.0e-3f};
constexpr double kReach = 3e-3;  // m, distance from a tooth up to which the computed distance is exact
// Depth to which the gum extends into the tooth, so that there is no gap, m.
constexpr double kGumInside = 0.4e-3;
// Roots deeper than this below the gum's edge are hidden by the gum, m.
constexpr double kCoveredBelow = 0.6e-3;
// Width of the blend between the gum around a tooth and the ridge, m.
constexpr double kCollarBlend = 1.0e-3;
constexpr double kCollarFrom = 4e-3;  // m, the gum forms a collar up to this distance from a tooth
// The fornix, where gum becomes cheek, m: size of its rounding, and depth of its end inside the cheek, which is more
// than the error of the cheek's mesh.
constexpr double kFornix = 4.5e-3, kFornixInside = 0.15e-3;
// Cell sizes of section faces, m.
constexpr double kToothFace = 0.15e-3, kGumFace = 0.30e-3;
// Overlap of the gum's section face over the teeth's section faces, m.
constexpr double kFaceOverlap = 0.05e-3;
// Depth of the gum's section face behind the teeth's section faces, m.
constexpr double kFaceUnder = 10e-6;

/// Keeps only triangles for which wanted(p) is true at a corner p. `lo`: origin of the vertices, m, frame W.
template <class Wanted>
void keep_triangles(std::vector<render::MeshUpdate>& mesh, const dvec3& lo, const Wanted& wanted) {
  for (render::MeshUpdate& brick : mesh) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(brick.vertices.size(), kUnused), indices;
    std::vector<render::Vertex> vertices;
    for (std::size_t i = 0; i + 2 < brick.indices.size(); i += 3) {
      const std::span<const std::uint32_t, 3> corners(&brick.indices[i], 3);
      const auto is_wanted = [&](std::uint32_t v) { return wanted(lo + dvec3(brick.vertices[v].p)); };
      if (std::none_of(corners.begin(), corners.end(), is_wanted)) continue;
      for (const std::uint32_t v : corners) {
        if (number[v] == kUnused) {
          number[v] = static_cast<std::uint32_t>(vertices.size());
          vertices.push_back(brick.vertices[v]);
        }
        indices.push_back(number[v]);
      }
    }
    brick.vertices = std::move(vertices), brick.indices = std::move(indices);
  }
  std::erase_if(mesh, [](const render::MeshUpdate& brick) { return brick.indices.empty(); });
}

struct Box {
  dvec3 lo{1e9}, hi{-1e9};  // m, frame W, lower and upper corner of the box
  void grow(const dvec3& p) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  template <class Map>
  static Box of(const dvec3& low, const dvec3& high, Map&& map) {
    Box box;
    for (int corner = 0; corner < 8; ++corner)
      box.grow(map(dvec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z)));
    return box;
  }
};

/// Maps points between a neighbour and the working tooth, whose mirror image it is.
struct ToothCopy {
  NeighbourTooth place;
  dvec3 arch, crown, across;
  double min_scale;

  ToothCopy(const NeighbourTooth& n, const SurroundingsPlan& plan)
      : place(n),
        arch(plan.arch),
        crown(plan.crown),
        across(glm::cross(plan.crown, plan.arch)),
        min_scale(std::min({n.scale.x, n.scale.y, n.scale.z})) {}

  /// Maps a point near the neighbour to the corresponding point near the working tooth; from_tooth() is the inverse.
  dvec3 to_tooth(const dvec3& p_W) const {
    const dvec3 r = glm::reflect(p_W - place.contact, place.normal);
    return place.contact + arch * (glm::dot(r, arch) / place.scale.x) + across * (glm::dot(r, across) / place.scale.y) +
           crown * (glm::dot(r, crown) / place.scale.z);
  }
  dvec3 from_tooth(const dvec3& p_W) const {
    const dvec3 r = p_W - place.contact;
    const dvec3 scaled = arch * (glm::dot(r, arch) * place.scale.x) + across * (glm::dot(r, across) * place.scale.y) +
                         crown * (glm::dot(r, crown) * place.scale.z);
    return place.contact + glm::reflect(scaled, place.normal);
  }
  double distance(const ToothField& tooth, const dvec3& p_W) const { return tooth.distance(to_tooth(p_W)) * min_scale; }
};

}  // namespace

struct SurroundingsShape::Impl {
  /// A neighbouring tooth: a copy of the working tooth, or a tooth of the row.
  struct Neighbour {
    std::optional<ToothCopy> copy;
    const RowTooth* row = nullptr;
    Box box;
    dvec3 middle{0, 0, 0};
    double radius = 0;  // m, radius of a ball that contains the tooth
  };

  SurroundingsPlan plan;
  ToothField tooth;
  dvec3 across, middle;
  double half_width = 0;
  Jaw jaw;
  std::vector<Neighbour> neighbours;
  std::optional<DamClamp> clamp;

  explicit Impl(const SurroundingsPlan& p)
      : plan(p),
        tooth(haptics::TissueVolume::load(p.volume), kReach),
        across(glm::cross(p.crown, p.arch)),
        middle(0.5 * (tooth.low() + tooth.high())),
        half_width(measured_half_width()),
        jaw(plan, middle, half_width, occlusal(), roots()) {
    const auto add = [&](Neighbour n) {
      n.middle = 0.5 * (n.box.lo + n.box.hi);
      n.radius = 0.5 * glm::length(n.box.hi - n.box.lo);
      neighbours.push_back(n);
    };
    for (const NeighbourTooth& n : plan.neighbours) {
      const ToothCopy copy(n, plan);
      add({copy, nullptr, Box::of(tooth.low(), tooth.high(), [&](const dvec3& q) { return copy.from_tooth(q); })});
    }
    if (plan.dam && plan.dam->clamp) clamp.emplace(jaw.to_row(middle), glm::dot(plan.margin, plan.crown), half_width);
    if (plan.row)
      for (const RowTooth& t : plan.row->teeth)
        add({{}, &t, Box::of(t.form.low(), t.form.high(), [&](const dvec3& q) {
               return jaw.from_row(t.from_form(q));
             })});
  }

  /// Half the tooth's width at the gum, measured in the volume, m.
  double measured_half_width() const {
    double half = 0;
    for (double v = 0; plan.gum && v < 12e-3; v += 0.1e-3)
      for (const double side : {-1.0, 1.0}) {
        const dvec3 q = middle + across * (side * v) - plan.crown * glm::dot(middle - plan.margin, plan.crown);
        if (tooth.distance(q) < 0) half = std::max(half, v);
      }
    return half;
  }
  /// Height of the tooth's chewing surface along the crown's axis, m.
  double occlusal() const {
    const Box box = Box::of(tooth.low(), tooth.high(), [](const dvec3& q) { return q; });
    return glm::dot(middle, plan.crown) + 0.5 * glm::dot(glm::abs(plan.crown), box.hi - box.lo) - 0.5e-3;
  }
  /// Depth of the tooth's roots below the gum's edge, m.
  double roots() const {
    double depth = 0;
    Box::of(tooth.low(), tooth.high(), [&](const dvec3& q) {
      depth = std::max(depth, below_plane(q));
      return q;
    });
    return depth;
  }
  /// Depth of the point p below the plane of the gum's edge, along the crown's axis, m.
  double below_plane(const dvec3& p) const {
    return glm::dot(plan.margin - p, plan.margin_normal) / glm::dot(plan.crown, plan.margin_normal);
  }

  /// Box in which gum and dam are meshed finely.
  Box near_box() const {
    const double side = plan.row ? kNear : half_width + 4e-3;
    const double along = plan.row ? kNear : plan.length / 2 + 4e-3;
    const dvec3 reach = glm::abs(plan.arch) * along + glm::abs(across) * side;
    const dvec3 edge = middle - plan.crown * glm::dot(middle - plan.margin, plan.crown);
    Box b;
    for (const double sign : {-1.0, 1.0}) {
      b.grow(edge + sign * reach + plan.crown * (plan.papilla + 3e-3));
      b.grow(edge + sign * reach - plan.crown * (jaw.depth() + 3e-3));
    }
    return b;
  }
  /// Box around the arch: `side` beyond its curve, and `up` above the chewing plane, m.
  Box arch_box(double side, double up) const {
    Box b;
    const double low = glm::dot(plan.margin, plan.crown) - jaw.depth() - 2e-3;
    for (const glm::dvec2& q : jaw.curve().points())
      for (const double s : {-side, side}) {
        b.grow(jaw.from_row({q.x + s, q.y + s, low}));
        b.grow(jaw.from_row({q.x + s, q.y + s, jaw.occlusal() + up}));
      }
    return b;
  }

  /// Distance from the point p to a neighbouring tooth including its root, m.
  double whole(const Neighbour& n, const dvec3& p) const {
    return n.copy ? n.copy->distance(tooth, p) : n.row->distance(jaw.to_row(p));
  }
  double below_edge(const dvec3& p) const { return plan.row ? jaw.place(p).depth : below_plane(p); }
  double neighbour(const Neighbour& n, const dvec3& p) const {
    const double d = whole(n, p);
    const bool low = glm::dot(p - plan.margin, plan.crown) < kCrownFrom;
    return plan.gum && low && d < 1e-3 ? std::max(d, below_edge(p) - kRootShown) : d;
  }
  Tissue tissue_at_surface(const Neighbour& n, const dvec3& p) const {
    if (n.row) return n.row->form.tissue(n.row->to_form(jaw.to_row(p)));
    switch (const Tissue found = tooth.tissue_at_surface(n.copy->to_tooth(p))) {
      // At the cut end of the root, pictures show dentin in place of the pulp.
      case Tissue::kPulp:
        return Tissue::kDentin;
      // A neighbour is sound, although the tooth that it copies is not.
      case Tissue::kCaries:
      case Tissue::kAmalgam:
      case Tissue::kComposite:
        return Tissue::kEnamel;
      default:
        return found;
    }
  }
  std::array<double, kTissueCount> fractions(const Neighbour& n, const dvec3& p) const {
    if (n.copy) {
      auto sound = tooth.fractions(n.copy->to_tooth(p));
      for (const Tissue defect : {Tissue::kCaries, Tissue::kAmalgam, Tissue::kComposite})
        sound[static_cast<std::size_t>(Tissue::kEnamel)] += std::exchange(sound[static_cast<std::size_t>(defect)], 0);
      return sound;
    }
    std::array<double, kTissueCount> all{};
    all[static_cast<std::size_t>(n.row->form.tissue(n.row->to_form(jaw.to_row(p))))] = 1;
    return all;
  }
  bool far(const Neighbour& n) const { return n.row && glm::length(n.middle - middle) > kNear; }

  double gum(const dvec3& p) const { return gum(p, jaw.place(p)); }
  double gum(const dvec3& p, const Jaw::Place& at) const {
    const double own = tooth.distance(p);
    double teeth = own;
    for (const Neighbour& n : neighbours)
      if (glm::length(p - n.middle) < n.radius + kCollarFrom) teeth = smooth_min(teeth, whole(n, p), 1.8e-3);
    // The papilla fills the gap below two teeth's contact.
    const double deep = at.depth + jaw.papilla(at);  // m, depth below the gum's edge at this point
    // The gum's edge is rounded, and thicker towards the root.
    const double edge = std::min(0.45e-3, 0.5 * plan.thickness), swell = plan.thickness * 2;
    const double collar = teeth - gum_thickness(deep, edge, plan.thickness, swell);
    const double body = smooth_max(smooth_min(jaw.ridge(at), collar, kCollarBlend), at.depth - jaw.depth(), 0.5e-3);
    // The gum ends inside the tooth, so that a bur inside the tooth does not touch it.
    return std::max(body, -own - kGumInside);
  }
  /// As gum(); in a patient's mouth, the drawn gum rises in a rounded fornix to the cheek.
  double drawn_gum(const dvec3& p) const {
    const Jaw::Place at = jaw.place(p);
    const double d = gum(p, at);
    if (plan.mouth != Mouth::kPatient) return d;
    return std::max(smooth_min(d, jaw.cheek(at) + kFornixInside, kFornix), d - kFornix);
  }
  /// Signed distance to the dam and everything below, m.
  double dam(const dvec3& p) const {
    const double own = tooth.distance(p);
    double teeth = 1;
    for (const Neighbour& n : neighbours)
      if (glm::length(p - n.middle) < n.radius + 2 * kCollarFrom) teeth = std::min(teeth, whole(n, p));
    return dam_sheet(jaw, jaw.place(p), teeth, own, plan.dam->gap);
  }
};

SurroundingsShape::SurroundingsShape(const SurroundingsPlan& plan) : impl_(std::make_unique<const Impl>(plan)) {}
SurroundingsShape::~SurroundingsShape() = default;
SurroundingsShape::SurroundingsShape(SurroundingsShape&&) noexcept = default;
SurroundingsShape& SurroundingsShape::operator=(SurroundingsShape&&) noexcept = default;
bool SurroundingsShape::has_neighbours() const {
  return !impl_->neighbours.empty();
}
bool SurroundingsShape::has_gum() const {
  return impl_->plan.gum;
}
double SurroundingsShape::neighbour(const dvec3& p_W) const {
  double nearest = 1.0;
  for (const Impl::Neighbour& n : impl_->neighbours) {
    // `least` is a lower bound of the distance, with which most exact distances are skipped.
    const double least = 0.7 * (glm::length(p_W - n.middle) - n.radius);
    if (least > kReach || least > nearest) {
      nearest = std::min(nearest, least);
      continue;
    }
    nearest = std::min(nearest, impl_->neighbour(n, p_W));
  }
  return nearest;
}
double SurroundingsShape::gum(const dvec3& p_W) const {
  return impl_->plan.gum ? impl_->gum(p_W) : 1.0;
}
double SurroundingsShape::tooth(const dvec3& p_W) const {
  return impl_->tooth.distance(p_W);
}
double SurroundingsShape::dam(const dvec3& p_W) const {
  return impl_->plan.dam ? impl_->dam(p_W) : 1.0;
}
double SurroundingsShape::clamp(const dvec3& p_W) const {
  return impl_->clamp ? impl_->clamp->distance(impl_->jaw.to_row(p_W)) : 1.0;
}
double SurroundingsShape::mouth(const dvec3& p_W) const {
  const Impl& shape = *impl_;
  if (shape.plan.mouth == Mouth::kNone) return 1.0;
  const Jaw::Place at = shape.jaw.place(p_W);
  const double rim = std::min({shape.jaw.cheek(at), shape.jaw.lip(at), shape.jaw.face(at)});
  return shape.plan.mouth == Mouth::kPatient ? std::min(rim, shape.jaw.tongue(at)) : rim;
}

std::vector<render::MeshUpdate> SurroundingsShape::section_face(const dvec3& normal, double offset,
                                                                const dvec3& origin) const {
  const Impl& shape = *impl_;
  std::vector<render::MeshUpdate> face;
  std::uint64_t body = 0;
  const auto add = [&](std::vector<render::MeshUpdate> of_body) {
    for (render::MeshUpdate& update : of_body) {
      // Includes the body's number, so that brick numbers differ between bodies.
      update.brick |= body << 60;
      face.push_back(std::move(update));
    }
    ++body;
  };
  // Pictures hide the root; sections show it.
  const auto with_root = [&](const Impl::Neighbour& n, const dvec3& p) {
    const double whole = shape.whole(n, p);
    return shape.plan.gum && whole < kToothFace ? std::min(shape.neighbour(n, p), std::max(whole, shape.gum(p)))
                                                : whole;
  };
  for (const Impl::Neighbour& n : shape.neighbours) {
    const auto [lo, hi] = n.box;
    if (std::abs(glm::dot(normal, n.middle) - offset) > n.radius) continue;
    add(plane_face(
        {normal, offset}, lo, hi, kToothFace, origin, [&](const dvec3& p) { return with_root(n, p); },
        [&](const dvec3& p) { return shape.fractions(n, p); }));
  }
  if (!shape.plan.gum) return face;
  const auto [lo, hi] = shape.plan.row ? shape.arch_box(12e-3, 0) : shape.near_box();
  add(plane_face(
      {normal, offset, kFaceUnder}, lo, hi, kGumFace, origin,
      [&](const dvec3& p) {
        double d = shape.gum(p);
        if (d > kGumFace) return d;
        d = std::max(d, -shape.tooth.distance(p) - kFaceOverlap);
        for (const Impl::Neighbour& n : shape.neighbours)
          if (glm::length(p - n.middle) < n.radius) d = std::max(d, -shape.whole(n, p) - kFaceOverlap);
        return d;
      },
      [](const dvec3&) {
        std::array<double, kTissueCount> all{};
        all[static_cast<std::size_t>(Tissue::kGingiva)] = 1;
        return all;
      }));
  return face;
}

namespace {

/// Gives all vertices the material `matter`. The tissue `under` shines through by the fraction (0 to 1) beneath(p).
template <class Beneath>
void paint(std::vector<render::MeshUpdate>& bricks, const dvec3& lo, Tissue matter, Tissue under, Beneath&& beneath) {
  for (render::MeshUpdate& brick : bricks)
    for (render::Vertex& v : brick.vertices) {
      v.tissue = {matter, matter};
      v.second = 0;
      v.under = under;
      v.shows = static_cast<float>(beneath(lo + dvec3(v.p)));
    }
}
void paint(std::vector<render::MeshUpdate>& bricks, Tissue matter) {
  paint(bricks, dvec3(0), matter, Tissue::kAir, [](const dvec3&) { return 0.0; });
}

}  // namespace

Surroundings make_surroundings(const SurroundingsPlan& plan) {
  const SurroundingsShape whole(plan);
  const SurroundingsShape::Impl& shape = *whole.impl_;

  Surroundings result;
  result.coarse_from = kCoarseFrom;
  render::MeshId id = render::kWorkingTooth + 1;
  const dvec3 work = shape.middle + plan.crown * (glm::dot(plan.margin - shape.middle, plan.crown) + kLitMiddle);
  const dvec3 reach =
      glm::abs(plan.arch) * kLitAlong + glm::abs(shape.across) * kLitAcross + glm::abs(plan.crown) * kLitUp;
  const auto is_lit = [&](const dvec3& p) { return glm::all(glm::lessThan(glm::abs(p - work), reach)); };
  const auto gum_label = [](const dvec3&) { return Tissue::kGingiva; };
  // Far bodies have only the coarse mesh. Not a template, because it would be compiled for each body.
  const auto add = [&](const Box& box, double voxel, const std::array<float, 2>& tolerances, bool fine,
                       const std::function<double(const dvec3&)>& distance,
                       const std::function<Tissue(const dvec3&)>& label,
                       const std::function<bool(const dvec3&, const dvec3&)>& wanted,
                       const std::function<void(std::vector<render::MeshUpdate>&)>& paint_mesh) {
    std::array<std::vector<render::MeshUpdate>, 2> meshes;
    if (fine)
      meshes = meshes_of_field<2>(box.lo, box.hi, voxel, tolerances, distance, label, wanted);
    else
      meshes[1] = meshes_of_field<1>(box.lo, box.hi, voxel, {tolerances[1]}, distance, label, wanted)[0];
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      for (render::MeshUpdate& brick : meshes[i])
        while (split_edges(brick, [&](const render::Vertex& a, const render::Vertex& b) {
          return glm::length(a.p - b.p) > kLightEdge[i] && is_lit(box.lo + dvec3(0.5f * (a.p + b.p)));
        })) {
        }
      paint_mesh(meshes[i]);
    }
    shade_by_slope(meshes[1], box.lo, 0.5 * voxel, distance);
    if (!fine) meshes[0] = meshes[1];
    result.meshes.push_back({id++, box.lo, std::move(meshes[0]), std::move(meshes[1])});
  };
  const auto everywhere = [](const dvec3&, const dvec3&) { return true; };
  const bool phantom = plan.mouth == Mouth::kPhantom;
  for (const auto& n : shape.neighbours) {
    if (plan.dam) break;  // the dam hides the neighbours
    const double voxel = shape.far(n) ? kFarToothVoxel : kToothVoxel;
    const auto distance = [&](const dvec3& p) { return shape.neighbour(n, p); };
    add(
        n.box, voxel, kToothTolerance, !shape.far(n), distance,
        [&](const dvec3& p) { return shape.tissue_at_surface(n, p); }, everywhere,
        [&](auto& mesh) {
          if (phantom) paint(mesh, render::kPlastic);
        });
  }
  if (!plan.gum) return result;
  result.covered = glm::dvec4(plan.margin_normal, kCoveredBelow - glm::dot(plan.margin_normal, plan.margin));

  // The gum, or the dam in its place, has a fine mesh near the working tooth.
  const auto distance = [&](const dvec3& p) { return plan.dam ? shape.dam(p) : shape.drawn_gum(p); };
  const auto soft = [&](const Box& box, double voxel, bool fine, const auto& surface, const auto& wanted,
                        const auto& trim) {
    add(box, voxel, kGumTolerance, fine, surface, gum_label, wanted, [&](auto& mesh) {
      trim(mesh, box.lo);
      if (plan.dam)
        paint(mesh, render::kRubber);
      else if (phantom)
        paint(mesh, render::kAcrylic);
      else
        paint(mesh, box.lo, Tissue::kGingiva, render::kMucosa,
              [&](const dvec3& p) { return plan.row ? shape.jaw.mucosa(shape.jaw.place(p)) : 0.0; });
    });
  };
  const Box near = [&] {
    Box box = shape.near_box();
    if (plan.dam) box.grow(box.hi + plan.crown * 8e-3);
    return box;
  }();
  soft(near, plan.dam ? kDamVoxel : kGumVoxel, true, distance, everywhere, [](auto&, const dvec3&) {});
  if (plan.row) {
    const double voxel = plan.dam ? kFarDamVoxel : kFarGumVoxel;
    // The coarse surface is lowered below the fine one and removed except for a strip. Otherwise it would block light
    // that the gum reflects.
    const auto inside_near = [&](const dvec3& p) {
      const dvec3 inside = glm::min(p - near.lo, near.hi - p);
      return std::min({inside.x, inside.y, inside.z});
    };
    const auto below = [&](const dvec3& p) {
      return distance(p) + kCoarseBelow * smooth_step(0, 2e-3, inside_near(p));
    };
    soft(
        plan.dam ? shape.arch_box(14e-3, 3e-3) : shape.arch_box(14e-3, -3e-3), voxel, false, below,
        [&](const dvec3& lo, const dvec3& hi) {
          return glm::any(glm::lessThan(lo, near.lo)) || glm::any(glm::greaterThan(hi, near.hi));
        },
        [&](auto& mesh, const dvec3& lo) {
          keep_triangles(mesh, lo, [&](const dvec3& p) { return inside_near(p) < kOverlap; });
        });
  }
  if (shape.clamp) {
    const DamClamp& clamp = *shape.clamp;
    const auto steel = [&](const dvec3& p) { return clamp.distance(shape.jaw.to_row(p)); };
    const Box box = Box::of(clamp.low(), clamp.high(), [&](const dvec3& q) { return shape.jaw.from_row(q); });
    add(box, kClampVoxel, kGumTolerance, true, steel, gum_label, everywhere,
        [](auto& mesh) { paint(mesh, Tissue::kAmalgam); });
  }
  if (plan.mouth == Mouth::kNone) return result;
  const Box box = shape.arch_box(kMouthReach, 9e-3);
  const auto body = [&](Tissue matter, Tissue under, double (Jaw::*field)(const Jaw::Place&) const,
                        const auto& beneath) {
    const auto at = [&](const dvec3& p) { return (shape.jaw.*field)(shape.jaw.place(p)); };
    // Fine mesh for the cheek, which is the tooth's background.
    const bool fine = field == &Jaw::cheek;
    add(box, kMouthVoxel, fine ? kCheekTolerance : kGumTolerance, fine, at, gum_label, everywhere,
        [&](auto& mesh) { paint(mesh, box.lo, matter, under, beneath); });
  };
  const auto plain = [](const dvec3&) { return 0.0; };
  // Near the jaw, the cheek has the colour of the gum's mucosa, so that no edge is visible between the two meshes.
  const auto near_jaw = [&](const dvec3& p) {
    const Jaw::Place at = shape.jaw.place(p);
    return 0.3 * smooth_step(8e-3, 18e-3, shape.jaw.rim(at) - at.z);
  };
  if (phantom) {
    body(render::kSkin, render::kPlastic, &Jaw::cheek, [](const dvec3&) { return 0.8; });
    body(render::kRubber, Tissue::kAir, &Jaw::lip, plain);
  } else {
    body(render::kMucosa, Tissue::kGingiva, &Jaw::cheek, near_jaw);
    body(render::kMucosa, render::kSkin, &Jaw::lip, [](const dvec3&) { return 0.45; });
    if (!plan.dam) body(render::kTongue, Tissue::kAir, &Jaw::tongue, plain);
  }
  body(render::kSkin, Tissue::kAir, &Jaw::face, plain);
  result.lit = {work - reach, work + reach};
  return result;
}

std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan) {
  if (!plan) return std::nullopt;
  return SurroundingsShape(*plan);
}

std::optional<SurroundingsShape> monitored_shape(const std::optional<SurroundingsPlan>& plan) {
  return plan && plan->monitored ? surroundings_shape(plan) : std::nullopt;
}

}  // namespace typodont
