#include "haptics/import/fuse.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/arch.h"
#include "haptics/import/distance.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/triangle_tree.h"

namespace typodont::haptics {

namespace {

using importing::ArchSurface;
using importing::Grid;
using importing::Triangle;
using importing::TriangleTree;

// Smallest cosine of the angle between the normals of scan and CT on a crown.
constexpr double kSameSide = 0.7;
constexpr double kGapArea = 10e-6;  // m², smaller gaps that a crown encloses count as crown
// Smaller pieces do not count as crown, m².
constexpr double kMinPiece = 5e-6;
constexpr double kLabelDepth = 0.75;  // voxels below the surface at which tissue is read
// Smallest slope of a distance near a surface; a true distance has slope 1.
constexpr double kMinGradient = 0.1;

bool is_of_tooth(Tissue t) {
  return t == Tissue::kEnamel || t == Tissue::kDentin || t == Tissue::kCaries || t == Tissue::kPulp ||
         t == Tissue::kAmalgam || t == Tissue::kComposite;
}

double smooth_step(double low, double high, double x) {
  const double s = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// Signed distance (m) from tissue and its gradient (m per voxel) at a position in voxels; Catmull–Rom interpolation.
importing::Jet distance_at(const DenseTissue& t, const dvec3& place) {
  const dvec3 at = glm::clamp(place, dvec3(1), dvec3(t.size) - 3.001);
  const glm::ivec3 base(glm::floor(at));
  const dvec3 f = at - dvec3(base);
  std::array<double, 4> weight[3], slope[3];
  for (int a = 0; a < 3; ++a) weight[a] = importing::cubic_weights(f[a]), slope[a] = importing::cubic_slopes(f[a]);
  importing::Jet jet{0, dvec3(0)};
  for_each_voxel(glm::ivec3(4), [&](int x, int y, int z) {
    const auto v = static_cast<double>(t.distance[t.at(base.x + x - 1, base.y + y - 1, base.z + z - 1)]);
    const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y), k = static_cast<std::size_t>(z);
    jet.value += weight[0][i] * weight[1][j] * weight[2][k] * v;
    jet.gradient += v * dvec3(slope[0][i] * weight[1][j] * weight[2][k], weight[0][i] * slope[1][j] * weight[2][k],
                              weight[0][i] * weight[1][j] * slope[2][k]);
  });
  return jet;
}

/// Index of the sample nearest to a position, which is given in voxels.
std::size_t nearest_sample(const DenseTissue& t, const dvec3& place) {
  const glm::ivec3 i = glm::clamp(glm::ivec3(glm::round(place)), glm::ivec3(0), t.size - 1);
  return t.at(i.x, i.y, i.z);
}

/// Index of a sample with a label: the nearest one inside, or the one just below the surface point nearest to the
/// position.
std::size_t labelled_sample(const DenseTissue& t, const dvec3& place, const importing::Jet& jet) {
  const double slope = glm::length(jet.gradient);  // gradient of the distance in m per voxel
  if (jet.value <= 0 || !(slope > kMinGradient * t.frame.voxel)) return nearest_sample(t, place);
  return nearest_sample(t, place - (jet.value / t.frame.voxel + kLabelDepth) / slope * jet.gradient);
}

/// Blocks within `reach` of the CT's surface. `reach`: m.
std::shared_ptr<const importing::BlockSet> blocks_near_surface(const DenseTissue& ct, const DenseTissue& out,
                                                               double reach) {
  const glm::ivec3 count = importing::BlockSet::blocks_of(out.size);
  const double scale = out.frame.voxel / ct.frame.voxel;
  Grid<std::uint8_t> wanted(count, 0), solid(count, 0);
  importing::for_each_voxel_in_parallel(count, [&](int bx, int by, int bz) {
    const dvec3 first = dvec3(importing::BlockSet::kEdge * glm::ivec3(bx, by, bz)) * scale;
    const glm::ivec3 lo = glm::min(glm::ivec3(first), ct.size - 1);
    const glm::ivec3 hi = glm::min(glm::ivec3(first + importing::BlockSet::kEdge * scale) + 1, ct.size - 1);
    solid(bx, by, bz) = ct.distance[ct.at(lo.x, lo.y, lo.z)] < 0;
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
      if (std::abs(static_cast<double>(ct.distance[ct.at(x, y, z)])) < reach) wanted(bx, by, bz) = 1;
    });
  });
  auto set = std::make_shared<importing::BlockSet>(out.size, wanted.v);
  for (std::size_t b = 0; b < set->slot.size(); ++b) {
    if (set->slot[b] == importing::BlockSet::kOutside && solid.v[b]) set->slot[b] = importing::BlockSet::kInside;
  }
  return set;
}

/// The scan's surface in the CT's frame C. Determines which of its triangles belong to crowns.
class Crowns {
 public:
  Crowns(const ArchSurface& scan, const Pose& X_CS, const ToothField& ct, const FuseOptions& options)
      : options_(options), mesh_(scan.mesh), scanned_(scan.scanned) {
    for (dvec3& p : mesh_.points) p = X_CS * p;
    std::vector<Triangle> all;
    for (std::size_t t = 0; t < mesh_.corners.size(); ++t) all.push_back(mesh_.triangle(t));
    skin_.emplace(std::vector<Triangle>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(scanned_)));
    closed_.emplace(std::move(all));
    find_edges();
    find_covered(ct);
    weigh_points();
  }

  const FuseReport& report() const { return report_; }
  /// Largest distance between the crowns and the CT's surface, m.
  double largest() const { return largest_; }

  struct Near {
    dvec3 point, normal;
    double distance = 0;  // m, distance from the scan, without sign
    // Weight of the scan's surface in the fused surface: 1 inside a crown, 0 at its rim and outside it.
    double weight = 0;
  };
  /// Nearest point on the scan within `reach`; p and `reach` in m; p in the CT's frame C.
  std::optional<Near> nearest(const dvec3& p, double reach) const {
    const auto found = skin_->nearest(p, reach);
    if (!found) return std::nullopt;
    Near near{found->point, normal(found->triangle), std::sqrt(found->distance_squared), 0};
    if (!covered_[found->triangle]) return near;
    const auto& c = mesh_.corners[found->triangle];
    // Computes the barycentric coordinates of the nearest point.
    const dvec3 a = mesh_.point(c[0]), u = mesh_.point(c[1]) - a, v = mesh_.point(c[2]) - a, q = near.point - a;
    const dvec3 n = glm::cross(u, v);
    const double nn = glm::dot(n, n);
    if (!(nn > 0)) return near;
    const double y = glm::dot(glm::cross(q, v), n) / nn, z = glm::dot(glm::cross(u, q), n) / nn;
    near.weight = std::clamp((1 - y - z) * weight(c[0]) + y * weight(c[1]) + z * weight(c[2]), 0.0, 1.0);
    return near;
  }
  bool inside(const dvec3& p) const { return closed_->winding(p) > 0; }

 private:
  double weight(int i) const { return weights_[static_cast<std::size_t>(i)]; }
  dvec3 normal(std::size_t t) const {
    const dvec3 n = mesh_.triangle(t).area_vector();
    const double length = glm::length(n);
    return length > 0 ? n / length : dvec3(0);
  }
  double area(std::size_t t) const { return glm::length(mesh_.triangle(t).area_vector()); }

  /// Finds the scan's border: edges with only one triangle.
  void find_edges() {
    std::map<std::pair<int, int>, std::vector<std::size_t>> edges;
    for (std::size_t t = 0; t < scanned_; ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = mesh_.corners[t][k], b = mesh_.corners[t][(k + 1) % 3];
        edges[{std::min(a, b), std::max(a, b)}].push_back(t);
      }
    }
    neighbours_.resize(scanned_);
    at_border_.assign(scanned_, false);
    for (const auto& [edge, triangles] : edges) {
      for (const std::size_t t : triangles) {
        if (triangles.size() == 1) at_border_[t] = true;
        for (const std::size_t other : triangles) {
          if (other != t) neighbours_[t].push_back(other);
        }
      }
    }
  }

  /// Calls change(area, at_border) for each connected piece of crown triangles (`covered` true) or of other triangles
  /// (false). If change() returns true, crown triangles of the piece become other triangles, or the reverse.
  template <class Change>
  void change_pieces(bool covered, Change change) {
    std::vector<bool> seen(scanned_, false);
    for (std::size_t first = 0; first < scanned_; ++first) {
      if (seen[first] || covered_[first] != covered) continue;
      std::vector<std::size_t> piece{first};
      seen[first] = true;
      double sum = 0;
      bool at_border = false;
      for (std::size_t k = 0; k < piece.size(); ++k) {
        sum += area(piece[k]);
        at_border = at_border || at_border_[piece[k]];
        for (const std::size_t next : neighbours_[piece[k]]) {
          if (seen[next] || covered_[next] != covered) continue;
          seen[next] = true;
          piece.push_back(next);
        }
      }
      if (!change(sum, at_border)) continue;
      for (const std::size_t t : piece) covered_[t] = !covered;
    }
  }

  void find_covered(const ToothField& ct) {
    std::vector<ToothField::Value> at;
    for (const dvec3& p : mesh_.points) at.push_back(ct.at(p));
    covered_.assign(scanned_, false);
    for (std::size_t t = 0; t < scanned_; ++t) {
      covered_[t] = std::ranges::all_of(mesh_.corners[t], [&](int i) {
        const ToothField::Value& v = at[static_cast<std::size_t>(i)];
        const double slope = glm::length(v.gradient);
        return v.tooth && std::abs(v.distance) < options_.reach && slope > kMinGradient &&
               glm::dot(v.gradient, normal(t)) > kSameSide * slope;
      });
    }
    change_pieces(false, [](double piece, bool at_border) { return !at_border && piece < kGapArea; });
    change_pieces(true, [](double piece, bool) { return piece < kMinPiece; });

    // For each corner of a crown's triangle: distance from the CT (m), and a third of the triangle's area (m²).
    std::vector<std::pair<double, double>> sizes;
    for (std::size_t t = 0; t < scanned_; ++t) {
      report_.scanned_area += area(t);
      if (!covered_[t]) continue;
      report_.covered_area += area(t);
      for (const int i : mesh_.corners[t]) {
        const double d = at[static_cast<std::size_t>(i)].distance;
        report_.mean += d * area(t) / 3;
        sizes.emplace_back(std::abs(d), area(t) / 3);
      }
    }
    if (sizes.empty()) return;
    report_.mean /= report_.covered_area;
    std::ranges::sort(sizes);
    largest_ = sizes.back().first;
    double sum = 0;
    for (const auto& [size, of] : sizes) {
      sum += of;
      if (sum <= 0.5 * report_.covered_area) report_.median_size = size;
      if (sum <= 0.95 * report_.covered_area) report_.max_size = size;
    }
  }

  /// Computes the weight of the scan at each point: 0 at the rim, rising to 1 at the distance `blend` along the edges.
  void weigh_points() {
    constexpr double kFar = 1e300;
    std::vector<double> away(mesh_.points.size(), 0);
    for (std::size_t t = 0; t < scanned_; ++t) {
      if (!covered_[t]) continue;
      for (const int i : mesh_.corners[t]) away[static_cast<std::size_t>(i)] = kFar;
    }
    for (std::size_t t = 0; t < scanned_; ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const bool rim = covered_[t] ? is_rim_edge(t, k) : true;
        if (!rim) continue;
        away[static_cast<std::size_t>(mesh_.corners[t][k])] = 0;
        away[static_cast<std::size_t>(mesh_.corners[t][(k + 1) % 3])] = 0;
      }
    }
    // Computes the distances from the rim with Dijkstra's algorithm.
    std::vector<std::vector<int>> next(mesh_.points.size());
    for (std::size_t t = 0; t < scanned_; ++t) {
      if (!covered_[t]) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        next[static_cast<std::size_t>(mesh_.corners[t][k])].push_back(mesh_.corners[t][(k + 1) % 3]);
        next[static_cast<std::size_t>(mesh_.corners[t][k])].push_back(mesh_.corners[t][(k + 2) % 3]);
      }
    }
    using Item = std::pair<double, std::size_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
    for (std::size_t i = 0; i < mesh_.points.size(); ++i) {
      if (away[i] == 0 && !next[i].empty()) open.emplace(0.0, i);
    }
    while (!open.empty()) {
      const auto [d, i] = open.top();
      open.pop();
      if (d > away[i] || d > options_.blend) continue;
      for (const int to : next[i]) {
        const auto k = static_cast<std::size_t>(to);
        const double longer = d + glm::length(mesh_.points[k] - mesh_.points[i]);
        if (longer >= away[k]) continue;
        away[k] = longer;
        open.emplace(longer, k);
      }
    }
    for (const double d : away) weights_.push_back(smooth_step(0, options_.blend, d));
  }
  /// Returns true if no other crown triangle shares the edge after corner k of the crown triangle t.
  bool is_rim_edge(std::size_t t, std::size_t k) const {
    const int a = mesh_.corners[t][k], b = mesh_.corners[t][(k + 1) % 3];
    return std::ranges::none_of(neighbours_[t], [&](std::size_t other) {
      const auto& c = mesh_.corners[other];
      return covered_[other] && std::ranges::find(c, a) != c.end() && std::ranges::find(c, b) != c.end();
    });
  }

  const FuseOptions& options_;
  importing::Mesh mesh_;  // the scan in the CT's frame C
  std::size_t scanned_;
  std::optional<TriangleTree> skin_;    // triangles of the scan without its base
  std::optional<TriangleTree> closed_;  // triangles of the scan with its base
  std::vector<std::vector<std::size_t>> neighbours_;
  // For each triangle: true if it is at the border of the scan; true if it is part of a crown.
  std::vector<bool> at_border_, covered_;
  std::vector<double> weights_;  // weight of the scan at each point: 0 at the rim, 1 inside
  FuseReport report_;
  double largest_ = 0;  // m, largest distance between the crowns and the CT's surface
};

}  // namespace

IntraoralScan::IntraoralScan(const std::filesystem::path& file, double unit) {
  ImportOptions options;
  options.preset = ImportPreset::kArch;
  options.mesh_unit = unit;
  surface_ = std::make_unique<ArchSurface>(importing::read_arch(file, options));
  area_ = area_of(mesh());
}
IntraoralScan::~IntraoralScan() = default;
IntraoralScan::IntraoralScan(IntraoralScan&&) noexcept = default;

TissueMesh IntraoralScan::mesh() const {
  TissueMesh mesh;
  mesh.vertices = surface_->mesh.points;
  for (std::size_t t = 0; t < surface_->scanned; ++t) {
    const auto& c = surface_->mesh.corners[t];
    mesh.triangles.emplace_back(c[0], c[1], c[2]);
  }
  mesh.tissue.assign(mesh.triangles.size(), Tissue::kEnamel);
  return mesh;
}

const dvec3& IntraoralScan::up() const {
  return surface_->up;
}

const std::vector<std::string>& IntraoralScan::repairs() const {
  return surface_->repairs;
}

std::vector<ScanPoint> IntraoralScan::points(std::size_t count) const {
  return spread_points(mesh(), count);
}

double area_of(const TissueMesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const dvec3 a = mesh.vertices[t.x];
    sum += 0.5 * glm::length(glm::cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a));
  }
  return sum;
}

std::vector<ScanPoint> spread_points(const TissueMesh& mesh, std::size_t count) {
  std::vector<ScanPoint> points;
  const double step = area_of(mesh) / static_cast<double>(count);
  double due = 0.5 * step, sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const dvec3 a = mesh.vertices[t.x], u = mesh.vertices[t.y] - a, v = mesh.vertices[t.z] - a, n = glm::cross(u, v);
    const double size = glm::length(n);
    sum += 0.5 * size;
    for (; due < sum; due += step) {
      // Additive recurrence with the plastic number (Roberts 2018).
      const auto k = static_cast<double>(points.size());
      double whole = 0, y = std::modf(0.7548776662466927 * k, &whole), z = std::modf(0.5698402909980532 * k, &whole);
      if (y + z > 1) y = 1 - y, z = 1 - z;
      points.push_back({a + y * u + z * v, n / size});
    }
  }
  return points;
}

ToothField::Value ToothField::at(const dvec3& p_C) const {
  const dvec3 place = ct_.frame.to_voxels(p_C);
  if (glm::any(glm::lessThan(place, dvec3(0))) || glm::any(glm::greaterThan(place, dvec3(ct_.size - 1)))) return {};
  const importing::Jet jet = distance_at(ct_, place);
  Value value{false, jet.value, jet.gradient / ct_.frame.voxel};
  if (std::abs(jet.value) > 0.95 * ct_.band) return value;
  // Position just below the surface, also if p_C lies deeper.
  const double slope = glm::length(value.gradient);
  if (!(slope > kMinGradient)) return value;
  const dvec3 below = place - (jet.value / ct_.frame.voxel + kLabelDepth) / slope * value.gradient;
  value.tooth = is_of_tooth(ct_.tissue[nearest_sample(ct_, below)]);
  return value;
}

Fused fuse(const DenseTissue& ct, const IntraoralScan& scan, const Pose& X_CS, const FuseOptions& given) {
  FuseOptions options = given;
  const double coarse = ct.frame.voxel, voxel = options.voxel.value_or(coarse);
  options.reach = std::min(options.reach, ct.band - 2 * coarse);
  if (!(options.reach > 0)) {
    throw Error("volume", "band", fmt::format("{:.3g} mm", ct.band / kMillimetre),
                fmt::format("more than two voxels of {:.3g} mm (import --band-mm)", coarse / kMillimetre));
  }
  importing::check_result_size(dvec3(ct.size) * coarse, voxel);
  const auto progress = [&](double done) {
    if (options.progress) options.progress(done);
  };
  const ToothField teeth(ct);
  const Crowns crowns(scan.surface(), X_CS, teeth, options);
  Fused fused;
  fused.report = crowns.report();
  if (!(fused.report.covered_area > 0)) {
    throw Error("scan", "", fmt::format("no part within {:g} mm of a crown", options.reach / kMillimetre),
                "a scan of teeth that the volume contains, and their pose");
  }
  progress(0.2);

  DenseTissue& out = fused.tissue;
  const bool same = voxel == coarse;
  out.frame = {ct.frame.origin, voxel};
  out.band = ct.band;
  out.exact_outside = ct.exact_outside;
  out.place = ct.place;
  out.size = same ? ct.size : glm::ivec3(glm::floor(dvec3(ct.size - 1) * (coarse / voxel) + 1e-6)) + 1;

  // phi (positive inside tissue): near crowns a blend of the distances to scan and CT, elsewhere the distance to CT.
  const double far = std::min(options.reach, crowns.largest()) + 2 * coarse;
  const auto set = blocks_near_surface(ct, out, far);
  const auto inverse = static_cast<float>(1 / voxel);
  importing::Sparse<float> phi(set, static_cast<float>(-ct.band) * inverse, static_cast<float>(ct.band) * inverse);
  importing::SparseMask moved(set, 0, 0);  // samples near the displaced surface
  importing::for_each_sample(*set, [&](const glm::ivec3& i, std::size_t at) {
    const dvec3 place = same ? dvec3(i) : dvec3(i) * (voxel / coarse);
    if (const auto rough = ct.distance[nearest_sample(ct, place)];
        std::abs(static_cast<double>(rough)) > far + coarse) {
      phi.v[at] = -rough * inverse;  // far from the crowns, only the sign counts
      return;
    }
    const importing::Jet jet = distance_at(ct, place);
    const double d = same ? static_cast<double>(ct.distance[ct.at(i.x, i.y, i.z)]) : jet.value;
    double blended = d;
    const dvec3 p = out.frame.to_world(dvec3(i)), gradient = jet.gradient / coarse;
    const double slope = glm::length(gradient);
    if (std::abs(d) < far && slope > kMinGradient) {
      // Nearest point on the scan to the sample, and to q, the CT point nearest to the sample.
      const dvec3 q = p - d / (slope * slope) * gradient;
      const auto opposite = crowns.nearest(q, options.reach);
      const auto near = opposite && opposite->weight > 0
                            ? crowns.nearest(p, glm::length(p - q) + opposite->distance + 1e-6 * coarse)
                            : std::nullopt;
      if (near && near->weight > 0) {
        const double faces = smooth_step(0, 0.5, glm::dot(opposite->normal, gradient) / slope);
        const double close = 1 - smooth_step(0.8, 1, opposite->distance / options.reach);
        const double weight = std::min(near->weight, opposite->weight * faces * close);
        if (weight > 0) {
          const double scanned = crowns.inside(p) ? -near->distance : near->distance;
          blended += weight * (scanned - d);
          moved.v[at] = std::min(std::abs(d), std::abs(blended)) < 1.5 * coarse;
        }
      }
    }
    phi.v[at] = -static_cast<float>(blended) * inverse;
  });
  progress(0.6);

  // Samples farther than band + two voxels from the change keep the CT's values.
  const double band = ct.band / voxel;
  const importing::DistanceField field = importing::signed_distance(phi, out.size, {}, band, band);
  const int reach = static_cast<int>(std::ceil((ct.band + 2 * coarse) / voxel));
  const importing::Sparse<float> to_change = importing::distance_squared_to(moved, reach);
  // If a distance changes by less than this, the CT's distance stays; voxels.
  constexpr double kEqual = 0.005;
  progress(0.9);

  out.distance.resize(voxel_count(out.size));
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  if (!ct.hardness.empty()) out.hardness.assign(out.distance.size(), 255);
  importing::for_each_voxel_in_parallel(out.size, [&](int x, int y, int z) {
    const glm::ivec3 i(x, y, z);
    const std::size_t at = out.at(x, y, z);
    const bool near_change =
        to_change.index(i) >= 0 && to_change[i] <= static_cast<float>(reach) * static_cast<float>(reach);
    const dvec3 place = same ? dvec3(i) : dvec3(i) * (voxel / coarse);
    const double d = std::clamp(static_cast<double>(field.distance[i]) * voxel, -ct.band, ct.band);
    if (same && (!near_change || std::abs(d - static_cast<double>(ct.distance[at])) < kEqual * voxel)) {
      out.distance[at] = ct.distance[at];
      out.tissue[at] = ct.tissue[at];
      if (!ct.hardness.empty()) out.hardness[at] = ct.hardness[at];
      return;
    }
    out.distance[at] = static_cast<float>(d);
    if (d > importing::kLabelReach * voxel) return;
    const std::size_t from = labelled_sample(ct, place, distance_at(ct, place));
    out.tissue[at] = ct.tissue[from];
    if (!ct.hardness.empty()) out.hardness[at] = ct.hardness[from];
  });
  progress(1);
  return fused;
}

}  // namespace typodont::haptics
