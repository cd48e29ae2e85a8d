#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/arch.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/mesh.h"
#include "haptics/import/mesh_fill.h"
#include "haptics/import/mesh_repair.h"

namespace typodont::haptics::importing {

namespace {

ImportRegion bounds_of(const Mesh& mesh) {
  ImportRegion bounds{dvec3(1e300), dvec3(-1e300)};
  for (const dvec3& p : mesh.points) bounds.lo = glm::min(bounds.lo, p), bounds.hi = glm::max(bounds.hi, p);
  return bounds;
}

double longest_of(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

/// Throws Error if the mesh is too small or too large for a tooth or bone.
void check_length(const std::filesystem::path& file, const dvec3& extent, const ImportOptions& options,
                  std::string_view what, double least, double most) {
  const double longest = longest_of(extent);
  if (longest >= least && longest <= most) return;
  // Finds a unit with which the size would be plausible, for the message.
  std::string guess;
  for (const double mm : {1.0, 10.0, 1000.0, 25.4}) {
    const double length = longest / options.mesh_unit * mm * kMillimetre;
    if (guess.empty() && length >= least && length <= most)
      guess = fmt::format("; with --unit-mm {:g} it would be {:.4g} mm long", mm, length / kMillimetre);
  }
  throw Error(
      file.string(), "size",
      fmt::format("a body {:.4g} mm long at {:g} mm a unit", longest / kMillimetre, options.mesh_unit / kMillimetre),
      fmt::format("{} of {:g} to {:g} mm; say what its unit is (--unit-mm){}", what, least / kMillimetre,
                  most / kMillimetre, guess));
}
void check_length(const std::filesystem::path& file, const dvec3& extent, const ImportOptions& options) {
  if (options.preset == ImportPreset::kTooth)
    check_length(file, extent, options, "a tooth", 1e-3, 60e-3);
  else
    check_length(file, extent, options, "a bone", 3e-3, 0.6);
}

void check_unit(const ImportOptions& options) {
  if (options.mesh_unit > 0 && std::isfinite(options.mesh_unit)) return;
  throw Error("--unit-mm", "", fmt::format("{:g}", options.mesh_unit / kMillimetre),
              "millimetres per unit of the mesh, above 0");
}

void move(Mesh& mesh, MeshRepairs& repairs, const Pose& X_WF) {
  for (dvec3& p : mesh.points) p = X_WF * p;
  for (dvec3& p : repairs.places) p = X_WF * p;
}

/// Returns an empty volume that encloses the bounds.
DenseTissue empty_volume(const ImportRegion& bounds, const ImportOptions& options, std::vector<std::string>& notes) {
  return volume_around(bounds.lo, bounds.hi, voxel_of_meshes(bounds, options, notes), options.band);
}

/// Selected triangles of a mesh in voxel coordinates.
template <class Wanted>
std::vector<Triangle> triangles_of(const Mesh& mesh, const VoxelFrame& frame, Wanted wanted) {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
    if (!wanted(t)) continue;
    const auto& [a, b, c] = mesh.triangle(t);
    triangles.push_back({frame.to_voxels(a), frame.to_voxels(b), frame.to_voxels(c)});
  }
  return triangles;
}

/// Throws Error if memory is too small. `deepest`: largest computed depth, voxels; `labels`: bytes per voxel.
void require_memory_for(const DenseTissue& out, std::span<const std::vector<Triangle>> parts, double deepest,
                        double labels, const ImportOptions& options, ImportReport& report) {
  // Memory of the imported volume (bytes per voxel), and fixed memory (bytes), as measured by ./run bench import.
  constexpr double kResult = 5, kResidue = 30e6;
  const dvec3 size(out.size);
  require_memory(kResidue + memory_of_filling(parts, out.size, deepest) + (kResult + labels) * size.x * size.y * size.z,
                 options, report);
}

void count_parts(Imported& imported) {
  const DenseTissue& t = imported.tissue;
  const auto row_of = [&](auto test) {
    return [&t, test](int x, int y, std::span<std::uint8_t> row) {
      for (int z = 0; z < t.size.z; ++z) row[static_cast<std::size_t>(z)] = test(t.at(x, y, z));
    };
  };
  ImportReport& report = imported.report;
  const auto solid = [&](std::size_t i) { return t.distance[i] <= 0; };
  report.bodies_kept = report.bodies_found = static_cast<int>(count_bodies(t.size, row_of(solid)));
  const auto pulp = [&](std::size_t i) { return solid(i) && t.tissue[i] == Tissue::kPulp; };
  report.pulp_parts = static_cast<int>(count_bodies(t.size, row_of(pulp)));
}

/// Sum of area × normal, m²: 0 for a closed mesh, otherwise it points from the opening to the side opposite to it.
dvec3 area_vector(const Mesh& mesh) {
  dvec3 sum(0);
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) sum += mesh.triangle(t).area_vector();
  return sum;
}

/// Normal of the plane of a border, within 45° of `start`. Minimises the mean deviation of the points from their median
/// height, so a rise of the border over a crown does not tilt the plane.
dvec3 across_border(const Mesh& mesh, const Border& border, const dvec3& start) {
  const std::size_t n = border.points.size();
  const auto at = [&](std::size_t k) { return mesh.point(border.points[k % n]); };
  const auto mean_distance = [&](const dvec3& up) {
    // For each edge of the border: height of its first point above the plane, and its length along the plane.
    std::vector<std::pair<double, double>> heights;
    double total = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const dvec3 d = at(k + 1) - at(k);
      const double along = glm::length(d - glm::dot(d, up) * up);
      heights.emplace_back(glm::dot(at(k), up), along);
      total += along;
    }
    std::ranges::sort(heights);
    double below = 0, median = heights.back().first, sum = 0;
    for (const auto& [height, along] : heights) {
      below += along;
      if (2 * below < total) continue;
      median = height;
      break;
    }
    for (const auto& [height, along] : heights) sum += along * std::abs(height - median);
    return total > 0 ? sum / total : 1e300;
  };
  // Searches on a grid, then with ever smaller steps around the best direction.
  dvec3 best = start;
  double least = mean_distance(start);
  const auto look_around = [&](const dvec3& from, double step, int reach) {
    const dvec3 u = glm::normalize(glm::cross(from, std::abs(from.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
    const dvec3 v = glm::cross(from, u);
    constexpr double kWithin = 0.7;  // smallest cosine of the angle between a tested direction and `start`
    for (int i = -reach; i <= reach; ++i) {
      for (int j = -reach; j <= reach; ++j) {
        const dvec3 up = glm::normalize(from + step * i * u + step * j * v);
        if (glm::dot(up, start) < kWithin) continue;
        if (const double d = mean_distance(up); d < least) least = d, best = up;
      }
    }
  };
  constexpr double kCoarse = 0.1, kFine = 1e-3;
  look_around(start, kCoarse, 10);
  for (double step = kCoarse / 2; step > kFine; step /= 2) look_around(best, step, 1);
  return best;
}

/// Direction away from the base of a closed mesh. The base is the flattest side: the plane that touches it has the most
/// area in or just below it. Zero if no side is clearly the flattest.
dvec3 away_from_base(const Mesh& mesh) {
  struct Face {
    dvec3 normal, middle;  // unit normal of the triangle; its centre, m
    double area;
  };
  std::vector<Face> faces;
  double whole = 0;
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
    const Triangle tri = mesh.triangle(t);
    const dvec3 normal = tri.area_vector();
    const double area = glm::length(normal);
    if (!(area > 0)) continue;
    faces.push_back({normal / area, (tri.a + tri.b + tri.c) / 3.0, area});
    whole += area;
  }
  // With more than kEnough triangles, only every n-th small one is used, with n times its area.
  constexpr double kEnough = 20'000;
  const double small = whole / kEnough;
  const auto every = static_cast<std::size_t>(1 + static_cast<double>(faces.size()) / kEnough);
  std::size_t next = 0;
  std::erase_if(faces, [&](Face& f) {
    if (f.area > small) return false;
    f.area *= static_cast<double>(every);
    return next++ % every != 0;
  });
  // Triangles of the base lie at most this far (m) inside the plane that touches the base from outside.
  constexpr double kDeep = 1.5e-3;
  // Smallest cosine of the angle between the normal of a triangle of the base and the base's normal.
  constexpr double kSlope = 0.9;
  constexpr double kMin = 0.08;      // smallest area of the base, as a fraction of the mesh's area
  constexpr double kClear = 1.3;     // factor by which the base's area must exceed that of any other side
  constexpr int kDirections = 1000;  // directions that are tried, 5° to 6° apart
  struct Side {
    dvec3 out{0};
    double area = 0;
  };
  std::vector<Side> sides(kDirections);
  for_each_in_parallel(kDirections, [&](int k) {
    const double z = 1 - (2 * k + 1.0) / kDirections, angle = k * kPi * (3 - std::sqrt(5.0));
    dvec3 out(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    // Improves the normal: takes the mean normal of the triangles on this side.
    for (int pass = 0; pass < 3; ++pass) {
      double top = -1e300, area = 0;
      dvec3 mean(0);
      for (const Face& f : faces) top = std::max(top, glm::dot(f.middle, out));
      for (const Face& f : faces) {
        if (glm::dot(f.normal, out) < kSlope || glm::dot(f.middle, out) < top - kDeep) continue;
        area += f.area, mean += f.area * f.normal;
      }
      sides[static_cast<std::size_t>(k)] = {out, area};
      if (!(area > 0)) return;
      out = glm::normalize(mean);
    }
  });
  const Side base = *std::ranges::max_element(sides, {}, &Side::area);
  // A side counts as the base itself if the cosine between its normal and the base's normal is at least this.
  constexpr double kApart = 0.7;
  double other = 0;
  for (const Side& side : sides) {
    if (glm::dot(side.out, base.out) < kApart) other = std::max(other, side.area);
  }
  return base.area > kMin * whole && base.area > kClear * other ? -base.out : dvec3(0);
}

/// Removes pieces with less than 2 % of the largest piece's area. Returns their number.
std::size_t drop_pieces(Mesh& mesh) {
  constexpr double kMin = 0.02;
  const Shells shells = shells_of(mesh, false);
  std::vector<double> area(shells.volume.size(), 0);
  for (std::size_t t = 0; t < mesh.corners.size(); ++t)
    area[static_cast<std::size_t>(shells.of_triangle[t])] += glm::length(mesh.triangle(t).area_vector());
  const double least = kMin * *std::ranges::max_element(area);
  std::size_t t = 0;
  std::erase_if(mesh.corners,
                [&](const auto&) { return area[static_cast<std::size_t>(shells.of_triangle[t++])] < least; });
  return static_cast<std::size_t>(std::ranges::count_if(area, [&](double a) { return a < least; }));
}

/// Triangulates a polygon with anticlockwise outline by ear clipping.
std::vector<std::array<std::size_t, 3>> triangulate(const std::vector<glm::dvec2>& polygon) {
  const auto cross = [&](std::size_t a, std::size_t b, std::size_t c) {
    const glm::dvec2 u = polygon[b] - polygon[a], v = polygon[c] - polygon[a];
    return u.x * v.y - u.y * v.x;
  };
  std::vector<std::size_t> left(polygon.size());
  for (std::size_t k = 0; k < left.size(); ++k) left[k] = k;
  std::vector<std::array<std::size_t, 3>> triangles;
  while (left.size() > 3) {
    // A border that crosses itself may have no ear; then the straightest corner is cut off.
    std::size_t ear = 0;
    double best = -1e300;
    bool found = false;
    for (std::size_t k = 0; k < left.size() && !found; ++k) {
      const std::size_t a = left[(k + left.size() - 1) % left.size()], b = left[k], c = left[(k + 1) % left.size()];
      const double turn = cross(a, b, c);
      if (turn <= 0) {
        if (turn > best) best = turn, ear = k;
        continue;
      }
      found = std::ranges::none_of(left, [&](std::size_t p) {
        return p != a && p != b && p != c && cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
      });
      if (found) ear = k;
    }
    triangles.push_back({left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

/// Adds walls from the border down to a plane `depth` (m) below all points, and a floor. `up`: unit vector.
void add_base(Mesh& mesh, const Border& border, const dvec3& up, double depth) {
  double lowest = 1e300;
  for (const dvec3& p : mesh.points) lowest = std::min(lowest, glm::dot(p, up));
  const dvec3 u = glm::normalize(glm::cross(up, std::abs(up.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 v = glm::cross(up, u);
  const std::size_t n = border.points.size();
  std::vector<int> foot;
  std::vector<glm::dvec2> outline;
  for (const int i : border.points) {
    const dvec3 p = mesh.point(i);
    const dvec3 q = p + (lowest - depth - glm::dot(p, up)) * up;
    foot.push_back(static_cast<int>(mesh.points.size()));
    mesh.points.push_back(q);
    if (!mesh.colors.empty()) mesh.colors.push_back(mesh.colors[static_cast<std::size_t>(i)]);
    // Outline of the floor as seen from above. The floor faces down, so its triangles are reversed later.
    outline.emplace_back(glm::dot(q, u), glm::dot(q, v));
  }
  double area = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const glm::dvec2 a = outline[k], b = outline[(k + 1) % n];
    area += a.x * b.y - a.y * b.x;
    const int top = border.points[k], next = border.points[(k + 1) % n], low = foot[k], low_next = foot[(k + 1) % n];
    mesh.corners.push_back({next, top, low});
    mesh.corners.push_back({next, low, low_next});
  }
  if (area < 0) {
    for (glm::dvec2& p : outline) p.y = -p.y;
  }
  for (const auto& t : triangulate(outline)) mesh.corners.push_back({foot[t[2]], foot[t[1]], foot[t[0]]});
}

/// Excess of red in a colour, relative to its brightness; high for gingiva.
double redness(const Color& c) {
  const double sum = c[0] + c[1] + c[2];
  return sum > 0 ? (c[0] - 0.5 * (c[1] + c[2])) / sum : 0;
}

/// Plane z = a·x + b·y + c through the upper points: repeats the fit without points more than 2 mm below the
/// plane. Nullopt: no plane, or a slope of more than 30°.
std::optional<dvec3> upper_plane(std::vector<dvec3> points) {
  constexpr int kRounds = 20;
  // Points more than kBelow (m) below the plane are dropped. kSteepest: tangent of the largest slope.
  constexpr double kBelow = 2e-3, kSteepest = 0.577;
  constexpr std::size_t kMin = 6;
  std::optional<dvec3> plane;
  for (int round = 0; round < kRounds && points.size() >= kMin; ++round) {
    dvec3 middle(0);
    for (const dvec3& p : points) middle += p / static_cast<double>(points.size());
    double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
    for (const dvec3& p : points) {
      const dvec3 d = p - middle;
      xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, xz += d.x * d.z, yz += d.y * d.z;
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0.01 * xx * yy)) return std::nullopt;
    const double a = (xz * yy - yz * xy) / determinant, b = (yz * xx - xz * xy) / determinant;
    if (std::hypot(a, b) > kSteepest) return std::nullopt;
    plane = dvec3(a, b, middle.z - a * middle.x - b * middle.y);
    if (std::erase_if(points, [&](const dvec3& p) { return p.z < a * p.x + b * p.y + plane->z - kBelow; }) == 0) break;
  }
  return plane;
}

/// Threshold between two groups of values (Otsu 1979); nullopt if the groups explain at most 0.6 of the variance.
std::optional<double> bound_between(std::vector<double> values) {
  constexpr double kOneGroup = 0.6;
  std::ranges::sort(values);
  double all = 0, squares = 0, below = 0, best = 0, bound = 0;
  for (const double v : values) all += v, squares += v * v;
  const auto n = static_cast<double>(values.size());
  for (std::size_t k = 1; k < values.size(); ++k) {
    below += values[k - 1];
    const auto low = static_cast<double>(k), high = n - low;
    const double apart = below / low - (all - below) / high, between = low * high / (n * n) * apart * apart;
    if (between > best) best = between, bound = 0.5 * (values[k - 1] + values[k]);
  }
  const double variance = squares / n - all / n * (all / n);
  return variance > 0 && best > kOneGroup * variance ? std::optional(bound) : std::nullopt;
}

/// Marks the points on gingiva, one byte per point.
std::vector<std::uint8_t> find_gum(const std::filesystem::path& file, const Mesh& mesh, const dvec3& up, double crown,
                                   std::vector<std::string>& notes) {
  std::vector<std::uint8_t> gum(mesh.points.size(), 0);
  if (!mesh.colors.empty()) {
    std::vector<double> red;
    for (const Color& c : mesh.colors) red.push_back(redness(c));
    if (const auto bound = bound_between(red)) {
      for (std::size_t i = 0; i < gum.size(); ++i) gum[i] = red[i] > *bound;
      notes.emplace_back("gum and teeth are told by colour");
      return gum;
    }
  }
  if (up == dvec3(0)) {
    throw Error(file.string(), "mesh", "closed, without colours and without a flat base",
                "an open scan, a scan with colours, or a base that is flatter than any other side, so that it is known "
                "where the teeth are");
  }
  // Without colours, a point is gingiva if it is far below the highest point near it (cells of kReach, m, large enough
  // for a cusp), or far below the plane of the cusps (floor of the mouth, palate).
  constexpr double kReach = 6e-3;
  const dvec3 u = glm::normalize(glm::cross(up, std::abs(up.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 v = glm::cross(up, u);
  // A point that is this far (m) plus `crown` below the plane of the cusps is gingiva.
  constexpr double kFarBelow = 3e-3;
  std::map<std::pair<int, int>, double> highest;
  std::map<std::pair<int, int>, dvec3> cusps;  // for each cell: (u, v, height) of its highest point
  const auto cell = [&](const dvec3& p) {
    return std::pair(static_cast<int>(std::floor(glm::dot(p, u) / kReach)),
                     static_cast<int>(std::floor(glm::dot(p, v) / kReach)));
  };
  for (const dvec3& p : mesh.points) {
    double& top = highest.try_emplace(cell(p), -1e300).first->second;
    if (glm::dot(p, up) <= top) continue;
    top = glm::dot(p, up);
    cusps[cell(p)] = {glm::dot(p, u), glm::dot(p, v), top};
  }
  std::vector<dvec3> tops;
  for (const auto& [at, top] : cusps) tops.push_back(top);
  const std::optional<dvec3> plane = upper_plane(std::move(tops));
  for (std::size_t i = 0; i < gum.size(); ++i) {
    const auto [x, y] = cell(mesh.points[i]);
    double top = -1e300;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto near = highest.find({x + dx, y + dy});
        if (near != highest.end()) top = std::max(top, near->second);
      }
    }
    const dvec3& p = mesh.points[i];
    gum[i] =
        glm::dot(p, up) < top - crown ||
        (plane && glm::dot(p, up) < glm::dot(*plane, dvec3(glm::dot(p, u), glm::dot(p, v), 1)) - crown - kFarBelow);
  }
  notes.push_back(fmt::format("no colours that tell gum from teeth: what lies more than {:g} mm below the cusps is gum",
                              crown / kMillimetre));
  return gum;
}

void add_words(std::vector<std::string>& all, const MeshRepairs& repairs, const std::string& of) {
  for (const std::string& words : repairs.in_words()) all.push_back(of.empty() ? words : of + ": " + words);
}

}  // namespace

ImportRegion mesh_bounds(const std::filesystem::path& file, const ImportOptions& options) {
  check_unit(options);
  if (options.preset == ImportPreset::kArch) return bounds_of(read_arch(file, options).mesh);
  MeshRepairs repairs;
  Mesh mesh = read_mesh(file, options.mesh_unit, repairs);
  move(mesh, repairs, options.mesh_pose);
  return bounds_of(mesh);
}

double voxel_of_meshes(const ImportRegion& bounds, const ImportOptions& options, std::vector<std::string>& notes) {
  // Usual voxel edge, and the step by which it grows until the number of voxels is allowed, m.
  constexpr double kDefault = 0.1e-3, kStep = 0.01e-3;
  // Width of the volume beyond the band around the mesh, voxels: sum of both sides along an axis.
  constexpr double kMargin = 8;
  const auto extent = [&](double voxel) { return bounds.hi - bounds.lo + 2 * options.band + kMargin * voxel; };
  constexpr double kLongest = 1;  // m; if all meshes together are longer, their coordinate frames differ
  if (!glm::all(glm::lessThanEqual(bounds.hi - bounds.lo, dvec3(kLongest))))
    throw Error("INPUT", "",
                fmt::format("meshes that are {:.4g} mm long together", longest_of(bounds.hi - bounds.lo) / kMillimetre),
                fmt::format("at most {:g} mm, in one coordinate frame", kLongest / kMillimetre));
  double voxel = options.voxel.value_or(kDefault);
  if (!options.voxel) {
    for (int step = 1; !result_size_fits(extent(voxel), voxel); ++step) voxel = kDefault + step * kStep;
    if (voxel > kDefault)
      notes.push_back(fmt::format("the voxels have an edge of {:.2f} mm, because the usual {:g} mm would need too many",
                                  voxel / kMillimetre, kDefault / kMillimetre));
  }
  check_result_size(extent(voxel), voxel);
  return voxel;
}

Imported import_mesh(const std::filesystem::path& file, const ImportOptions& options) {
  const bool tooth = options.preset == ImportPreset::kTooth;
  check_unit(options);
  MeshRepairs repairs;
  Mesh mesh = read_mesh(file, options.mesh_unit, repairs);
  move(mesh, repairs, options.mesh_pose);
  const ImportRegion bounds = bounds_of(mesh);
  const dvec3 extent = bounds.hi - bounds.lo;
  check_length(file, extent, options);
  const double longest = longest_of(extent);

  Imported result;
  result.report.format = file.extension().string().substr(1);
  add_words(result.report.repairs, repairs, "");
  result.report.repaired = std::move(repairs.places);
  DenseTissue& out = result.tissue;
  out = empty_volume(bounds, options, result.report.notes);
  const double voxel = out.frame.voxel;

  // A shell inside no other shell is a body; a shell inside another one is a hollow.
  const Shells shells = shells_of(mesh, true);
  double body = 0, hollows = 0;
  for (std::size_t s = 0; s < shells.volume.size(); ++s) {
    (shells.depth[s] == 0 ? body : hollows) += std::abs(shells.volume[s]);
  }
  // Largest plausible fraction of pulp in a tooth; a young molar has about a tenth.
  constexpr double kMaxPulp = 0.3;
  const int deepest_shell = shells.depth.empty() ? 0 : *std::ranges::max_element(shells.depth);
  if (tooth && (deepest_shell > 1 || hollows > kMaxPulp * body)) {
    throw Error(file.string(), "shells",
                deepest_shell > 1 ? "a shell within a shell within a shell"
                                  : fmt::format("shells of {:.0f} mm³ within one of {:.0f} mm³",
                                                hollows / kCubicMillimetre, body / kCubicMillimetre),
                fmt::format("at most a pulp ({:g} % of the tooth) within it; of tissues that lie in one another, one "
                            "file each: --part enamel=FILE --part dentin=FILE --part pulp=FILE",
                            100 * kMaxPulp));
  }
  const auto shell_is = [&](bool hollow) {
    return [&, hollow](std::size_t t) {
      return (shells.depth[static_cast<std::size_t>(shells.of_triangle[t])] > 0) == hollow;
    };
  };
  // A hollow is filled as a separate part, so its triangles are reversed.
  std::vector<std::vector<Triangle>> parts{triangles_of(mesh, out.frame, shell_is(false)),
                                           triangles_of(mesh, out.frame, shell_is(true))};
  for (Triangle& t : parts[1]) std::swap(t.b, t.c);
  const bool has_hollow = !parts[1].empty();
  if (!has_hollow) parts.pop_back();
  if (options.progress) options.progress(0.2);

  // Rules for labels; lengths in m. Tooth: enamel of thickness `shell` on the crown, which is kCrownShare of the
  // length; thinner within kTaper of the crown's border. Pulp: in hollows; without hollows, deeper than kPulpDepth.
  // Elsewhere dentin. Bone: a cortical layer of thickness `shell`, cancellous bone inside.
  constexpr double kPulpDepth = 3e-3, kTaper = 2.5e-3, kCrownShare = 0.42;
  const double shell = options.shell.value_or(tooth ? 1.3e-3 : 1.5e-3);
  if (!(shell >= 0 && shell <= 0.5 * longest)) {
    throw Error("--shell-mm", "", fmt::format("{:g}", shell / kMillimetre),
                fmt::format("0 to {:.3g} mm", 0.5 * longest / kMillimetre));
  }
  const double deepest = std::max({options.band, shell + 2 * voxel, tooth ? kPulpDepth + 2 * voxel : 0.0});
  require_memory_for(out, parts, deepest / voxel, 0, options, result.report);
  const FilledMesh filled = fill_mesh(parts, out.size, deepest / voxel);
  if (options.progress) options.progress(0.8);

  // The crown is at that end of the longest axis where the tooth is wider.
  const int axis = extent.x == longest ? 0 : extent.y == longest ? 1 : 2;
  const double middle = 0.5 * (bounds.lo[axis] + bounds.hi[axis]);
  // For each x: number of the body's voxels below and above the middle of its longest axis.
  std::vector<std::array<std::size_t, 2>> of_slab(static_cast<std::size_t>(out.size.x));
  for_each_voxel_in_parallel(out.size, [&](int x, int y, int z) {
    if (filled.distance(x, y, z) >= 0) return;
    ++of_slab[static_cast<std::size_t>(x)][out.frame.to_world(dvec3(x, y, z))[axis] > middle ? 1 : 0];
  });
  std::size_t below = 0, above = 0;
  for (const auto& [lower, upper] : of_slab) below += lower, above += upper;
  if (above + below < 8) {
    throw Error(file.string(), "size", fmt::format("a body of {} voxels", above + below),
                "a body thicker than --voxel-mm");
  }
  const double crown_end = above >= below ? bounds.hi[axis] : bounds.lo[axis];
  const double margin_of_crown = crown_end + (above >= below ? -1 : 1) * kCrownShare * extent[axis];
  store(filled, out, [&](const glm::ivec3& p, double d) {
    const double depth = std::max(-d, 0.0);
    if (!tooth) return depth < shell || shell == 0 ? Tissue::kCorticalBone : Tissue::kCancellousBone;
    const double up = (out.frame.to_world(dvec3(p))[axis] - margin_of_crown) * (above >= below ? 1 : -1);
    const double enamel = shell * std::clamp(up / kTaper, 0.0, 1.0);
    const bool pulp = has_hollow ? filled.part[p] == 2 : depth > kPulpDepth;
    return pulp ? Tissue::kPulp : depth < enamel ? Tissue::kEnamel : Tissue::kDentin;
  });
  count_parts(result);
  if (tooth)
    result.report.notes.push_back(has_hollow ? "enamel is told by depth below the surface, pulp by the mesh's hollows"
                                             : "tissues are told by depth below the surface; root canals are not");
  return result;
}

ArchSurface read_arch(const std::filesystem::path& file, const ImportOptions& options) {
  // Length of a small hole's border, smallest and largest length of an arch, depth of the base below the lowest point;
  // m.
  constexpr double kSmallHole = 6e-3, kMin = 8e-3, kMost = 0.11, kBaseDepth = 3e-3;
  check_unit(options);
  ArchSurface arch;
  MeshRepairs repairs;
  Mesh& mesh = arch.mesh;
  mesh = read_surface(file, options.mesh_unit, repairs);
  move(mesh, repairs, options.mesh_pose);
  drop_copies(mesh, repairs);
  orient(mesh, repairs);
  const std::size_t pieces = drop_pieces(mesh);
  const ImportRegion bounds = bounds_of(mesh);
  check_length(file, bounds.hi - bounds.lo, options, "an arch or a part of one", kMin, kMost);

  // Small holes are closed first, so that area_vector() points from the longest border to the opposite surface.
  close_holes(mesh, kSmallHole, repairs);
  arch.scanned = mesh.corners.size();
  std::vector<Border> open = borders(mesh);
  std::erase_if(open, [](const Border& b) { return !b.closed || b.points.size() < 3; });
  if (!open.empty()) {
    const auto main = std::ranges::max_element(open, {}, &Border::length);
    dvec3 rim(0), middle(0);
    for (const int i : main->points) rim += mesh.point(i) / static_cast<double>(main->points.size());
    for (const auto& c : mesh.corners) middle += mesh.point(c[0]) / static_cast<double>(mesh.corners.size());
    arch.up = area_vector(mesh);
    if (!(glm::length(arch.up) > 0)) arch.up = middle - rim;
    if (glm::dot(arch.up, middle - rim) < 0) {
      for (auto& c : mesh.corners) std::swap(c[1], c[2]);
      for (Border& b : open) std::ranges::reverse(b.points);
      arch.up = -arch.up;
      ++repairs.shells_turned;
    }
    const Border base = *main;
    arch.up = across_border(mesh, base, glm::normalize(arch.up));
    for (const Border& b : open) {
      if (&b != &*main) close_border(mesh, b, repairs);
    }
    add_words(arch.repairs, repairs, "");
    if (open.size() > 1) arch.repairs.push_back(fmt::format("{} large openings closed", open.size() - 1));
    arch.scanned = mesh.corners.size();
    add_base(mesh, base, arch.up, kBaseDepth);
    arch.repairs.push_back(fmt::format("a base added under the border of {:.0f} mm, {:g} mm below the lowest point",
                                       base.length / kMillimetre, kBaseDepth / kMillimetre));
  } else {
    arch.up = away_from_base(mesh);
    add_words(arch.repairs, repairs, "");
  }
  if (pieces > 0) arch.repairs.push_back(fmt::format("{} loose pieces left out", pieces));
  arch.repaired = std::move(repairs.places);
  return arch;
}

Imported import_arch(const std::filesystem::path& file, const ImportOptions& options) {
  // Height of a crown, thickness of enamel, width of its thinner edge, thickness of gingiva; m.
  constexpr double kUsualCrown = 7e-3, kUsualEnamel = 1.3e-3, kTaper = 2.5e-3, kGumDepth = 2e-3;
  Imported result;
  ImportReport& report = result.report;
  report.format = file.extension().string().substr(1);
  ArchSurface arch = read_arch(file, options);
  const Mesh& mesh = arch.mesh;
  const dvec3& up = arch.up;
  const std::size_t scanned = arch.scanned;
  report.repairs = std::move(arch.repairs);
  report.repaired = std::move(arch.repaired);
  std::vector<std::uint8_t> gum = find_gum(file, mesh, up, options.crown.value_or(kUsualCrown), report.notes);

  DenseTissue& out = result.tissue;
  out = empty_volume(bounds_of(mesh), options, report.notes);
  const double voxel = out.frame.voxel;
  if (options.progress) options.progress(0.2);
  const double shell = options.shell.value_or(kUsualEnamel);
  const double deepest = std::max({options.band, shell + 2 * voxel, kGumDepth + 2 * voxel});
  const std::vector<std::vector<Triangle>> parts{triangles_of(mesh, out.frame, [](std::size_t) { return true; })};
  // Memory of both distance fields and of the marks of teeth and gum, bytes per voxel.
  constexpr double kTeethAndGum = 10;
  require_memory_for(out, parts, deepest / voxel, kTeethAndGum, options, report);
  const FilledMesh filled = fill_mesh(parts, out.size, deepest / voxel);
  if (options.progress) options.progress(0.7);

  // The base counts as gingiva.
  Mask teeth_at(out.size, 0), gum_at(out.size, 0);
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) {
    std::size_t gums = 0;
    for (const int i : mesh.corners[t]) gums += gum[static_cast<std::size_t>(i)];
    Mask& at = t < scanned && gums < 2 ? teeth_at : gum_at;
    const Triangle& tri = parts[0][t];
    const double size = std::max({glm::length(tri.b - tri.a), glm::length(tri.c - tri.b), glm::length(tri.a - tri.c)});
    const int steps = std::max(1, static_cast<int>(std::ceil(2 * size)));
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const double a = static_cast<double>(i) / steps, b = static_cast<double>(j) / steps;
        const glm::ivec3 p(glm::round(tri.a + a * (tri.b - tri.a) + b * (tri.c - tri.a)));
        if (at.holds(p)) at[p] = 1;
      }
    }
  }
  const Grid<float> to_teeth = distance_squared_to(teeth_at), to_gum = distance_squared_to(gum_at);
  store(filled, out, [&](const glm::ivec3& p, double d) {
    const double teeth = std::sqrt(static_cast<double>(to_teeth[p])) * voxel,
                 gums = std::sqrt(static_cast<double>(to_gum[p])) * voxel, depth = std::max(-d, 0.0);
    if (gums < teeth) return depth < kGumDepth ? Tissue::kGingiva : Tissue::kCorticalBone;
    return depth < shell * std::clamp(gums / kTaper, 0.0, 1.0) ? Tissue::kEnamel : Tissue::kDentin;
  });
  count_parts(result);
  report.notes.push_back(
      fmt::format("enamel {:.3g} mm deep, thinning out over {:.3g} mm towards the gum, dentin below; gum {:.3g} mm "
                  "deep, bone below: a "
                  "surface scan knows no more",
                  shell / kMillimetre, kTaper / kMillimetre, kGumDepth / kMillimetre));
  return result;
}

Imported import_parts(const ImportOptions& options) {
  check_unit(options);
  Imported result;
  ImportReport& report = result.report;
  std::vector<Mesh> meshes;
  ImportRegion bounds;
  for (const ImportPart& part : options.parts) {
    MeshRepairs repairs;
    meshes.push_back(read_mesh(part.file, options.mesh_unit, repairs));
    const ImportRegion of_part = bounds_of(meshes.back());
    bounds = meshes.size() == 1 ? of_part : around(bounds, of_part);
    add_words(report.repairs, repairs, std::string(name_of(part.tissue)));
    report.repaired.insert(report.repaired.end(), repairs.places.begin(), repairs.places.end());
    const std::string format = part.file.extension().string().substr(1);
    if (report.format.find(format) == std::string::npos) report.format += (report.format.empty() ? "" : ", ") + format;
  }
  check_length(options.parts[0].file, bounds.hi - bounds.lo, options);
  DenseTissue& out = result.tissue;
  out = empty_volume(bounds, options, report.notes);
  const double voxel = out.frame.voxel;
  std::vector<std::vector<Triangle>> parts;
  for (const Mesh& mesh : meshes) parts.push_back(triangles_of(mesh, out.frame, [](std::size_t) { return true; }));
  if (options.progress) options.progress(0.2);
  require_memory_for(out, parts, out.band / voxel, 1, options, report);
  FilledMesh filled = fill_mesh(parts, out.size, out.band / voxel);
  if (options.progress) options.progress(0.8);
  std::vector<std::size_t> own(parts.size(), 0);
  for (const std::uint8_t part : filled.part.v) {
    if (part) ++own[part - 1U];
  }
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (own[k] > 0) continue;
    throw Error(options.parts[k].file.string(), "--part",
                fmt::format("no voxel of {} that a later part does not cover", name_of(options.parts[k].tissue)),
                "the parts from the outermost to the innermost: where they overlap the later one counts");
  }
  spread_parts(filled, kLabelReach);
  store(filled, out, [&](const glm::ivec3& p, double) {
    return filled.part[p] ? options.parts[filled.part[p] - 1U].tissue : Tissue::kAir;
  });
  count_parts(result);
  if (report.bodies_kept > 1)
    report.notes.push_back(fmt::format("the parts are {} bodies that do not touch each other", report.bodies_kept));
  return result;
}

}  // namespace typodont::haptics::importing
