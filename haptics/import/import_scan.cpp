#include "haptics/import/import_scan.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/dense_tissue.h"
#include "haptics/import/import_labels.h"
#include "haptics/import/jaw.h"
#include "haptics/import/levels.h"
#include "haptics/import/scan.h"
#include "haptics/import/segment.h"
#include "haptics/import/unseen_canals.h"

namespace typodont::haptics::importing {

namespace {
// Standard deviation of the smoothing before the histogram, voxels.
constexpr double kScanSmoothing = 0.8;
}  // namespace

// Imports a scan or a region of it. `known`: grey values of the whole scan; null: this function finds them.
static Imported import_read_scan(const std::filesystem::path& file, Scan scan, const ScanGreys* known,
                                 const ImportOptions& options);

// Replaces each block of k.x × k.y × k.z voxels by one voxel with their mean grey value.
static void reduce(Scan& scan, const glm::ivec3& k) {
  const glm::ivec3 size = scan.grey.size / k;
  Grid<float> out(size);
  for_each_voxel_in_parallel(size, [&](int x, int y, int z) {
    double sum = 0;
    for_each_voxel(k, [&](int a, int b, int c) { sum += scan.grey(x * k.x + a, y * k.y + b, z * k.z + c); });
    out(x, y, z) = static_cast<float>(sum / (k.x * k.y * k.z));
  });
  scan.origin += 0.5 * glm::dvec3(k - 1) * scan.spacing;
  scan.spacing *= glm::dvec3(k);
  scan.grey = std::move(out);
}

// Resamples the box lo … hi to cubic voxels; beyond the scan, samples get the value `outside`.
static Grid<float> resample(const Scan& scan, const glm::ivec3& lo, const glm::ivec3& hi, double voxel, float outside) {
  Grid<float> box(hi - lo + 1, outside);
  const glm::ivec3 from = glm::max(lo, glm::ivec3(0)), to = glm::min(hi + 1, scan.grey.size);
  for_each_in_parallel(std::max(0, to.x - from.x), [&](int x) {
    for (int y = from.y; y < to.y; ++y) {
      const float* row = &scan.grey(from.x + x, y, from.z);
      std::copy(row, row + (to.z - from.z), &box(from.x + x - lo.x, y - lo.y, from.z - lo.z));
    }
  });
  const glm::dvec3 ratio = voxel / scan.spacing;
  if (glm::all(glm::lessThan(glm::abs(ratio - 1.0), glm::dvec3(1e-3)))) return box;
  const glm::ivec3 size = glm::ivec3(glm::floor(glm::dvec3(box.size - 1) / ratio + 1e-9)) + 1;
  // Interpolates axis by axis: four nearest samples with Catmull-Rom weights.
  struct Taps {
    std::array<int, 4> at;
    std::array<double, 4> weight;
  };
  std::array<std::vector<Taps>, 3> taps;
  for (int a = 0; a < 3; ++a) {
    for (int k = 0; k < size[a]; ++k) {
      const double q = std::min(k * ratio[a], box.size[a] - 1.0);
      const int i = static_cast<int>(q);
      Taps of{{}, cubic_weights(q - i)};
      for (int j = 0; j < 4; ++j) of.at[static_cast<std::size_t>(j)] = std::clamp(i - 1 + j, 0, box.size[a] - 1);
      taps[static_cast<std::size_t>(a)].push_back(of);
    }
  }
  Grid<float> out(size);
  const auto rows = static_cast<std::size_t>(box.size.y), length = static_cast<std::size_t>(box.size.z);
  struct Scratch {
    std::vector<double> plane, row;
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  for_each_in_parallel(size.x, [&](int x) {
    auto& [plane, row] = scratch.local();
    plane.resize(rows * length);
    row.resize(length);
    const Taps& of_x = taps[0][static_cast<std::size_t>(x)];
    const auto slab = [&](std::size_t k) { return &box(of_x.at[k], 0, 0); };
    const float *a = slab(0), *b = slab(1), *c = slab(2), *d = slab(3);
    for (std::size_t i = 0; i < plane.size(); ++i) {
      plane[i] = of_x.weight[0] * static_cast<double>(a[i]) + of_x.weight[1] * static_cast<double>(b[i]) +
                 of_x.weight[2] * static_cast<double>(c[i]) + of_x.weight[3] * static_cast<double>(d[i]);
    }
    for (int y = 0; y < size.y; ++y) {
      const Taps& of_y = taps[1][static_cast<std::size_t>(y)];
      const auto line = [&](std::size_t k) { return &plane[static_cast<std::size_t>(of_y.at[k]) * length]; };
      const double *e = line(0), *f = line(1), *g = line(2), *h = line(3);
      for (std::size_t i = 0; i < length; ++i)
        row[i] = of_y.weight[0] * e[i] + of_y.weight[1] * f[i] + of_y.weight[2] * g[i] + of_y.weight[3] * h[i];
      for (int z = 0; z < size.z; ++z) {
        const Taps& of_z = taps[2][static_cast<std::size_t>(z)];
        double value = 0;
        for (std::size_t k = 0; k < 4; ++k) value += of_z.weight[k] * row[static_cast<std::size_t>(of_z.at[k])];
        out(x, y, z) = static_cast<float>(value);
      }
    }
  });
  // segment() requires grey values of the surroundings at the walls (outer faces) of the volume.
  for_each_voxel(size, [&](int x, int y, int z) {
    if (x == 0 || y == 0 || z == 0 || x == size.x - 1 || y == size.y - 1 || z == size.z - 1) out(x, y, z) = outside;
  });
  return out;
}

// Closes canals that end at an outer face (wall) of the scan; open canals would count as outside. A dark hole in the
// wall (grey values up to `bound`, width up to `widest`, m) gets a lid of the grey value `fill`, two planes thick.
static void close_walls(Grid<float>& grey, const CutWalls& wall, double bound, double fill, double widest,
                        double voxel) {
  constexpr int kRim = 2;  // number of samples by which a lid extends beyond the edge of its hole
  for (int a = 0; a < 3; ++a) {
    const int u = (a + 1) % 3, v = (a + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      if (!wall[static_cast<std::size_t>(a)][static_cast<std::size_t>(side)]) continue;
      const int plane = *wall[static_cast<std::size_t>(a)][static_cast<std::size_t>(side)], out = side == 0 ? -1 : 1;
      const auto place = [&](const glm::ivec3& q, int away) {
        glm::ivec3 p;
        p[a] = plane + out * away, p[u] = q.x, p[v] = q.y;
        return p;
      };
      Mask open(glm::ivec3(grey.size[u], grey.size[v], 1), 0);
      for (std::size_t i = 0; i < open.v.size(); ++i)
        open.v[i] = grey[place(open.place(i), 0)] <= static_cast<float>(bound);
      const SparseComponents holes = components(open);
      const auto hole_of = [&](std::size_t i) { return static_cast<std::size_t>(holes.label[open.place(i)]); };
      // Number of the component that contains the surroundings, which enclose the tissue everywhere.
      const std::size_t around = hole_of(0);
      std::vector<glm::ivec3> from(holes.voxels.size(), open.size), to(holes.voxels.size(), glm::ivec3(-1));
      for (std::size_t i = 0; i < open.v.size(); ++i) {
        const std::size_t id = hole_of(i);
        from[id] = glm::min(from[id], open.place(i)), to[id] = glm::max(to[id], open.place(i));
      }
      Mask lid(open.size, 0);
      for (std::size_t i = 0; i < open.v.size(); ++i) {
        const std::size_t id = hole_of(i);
        if (id == 0 || id == around) continue;
        const glm::ivec3 extent = to[id] - from[id] + 1;
        if (std::max(extent.x, extent.y) * voxel > widest) continue;
        const glm::ivec3 q = open.place(i);
        for (int x = -kRim; x <= kRim; ++x) {
          for (int y = -kRim; y <= kRim; ++y) {
            if (const glm::ivec3 r = q + glm::ivec3(x, y, 0); lid.holds(r)) lid[r] = 1;
          }
        }
      }
      for (std::size_t i = 0; i < lid.v.size(); ++i) {
        if (!lid.v[i]) continue;
        for (const int away : {1, 2}) {
          float& g = grey[place(lid.place(i), away)];
          g = std::max(g, static_cast<float>(fill));
        }
      }
    }
  }
}

// Part of a scan in a region.
static Scan cropped(const Scan& scan, const ImportRegion& region) {
  const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil((region.lo - scan.origin) / scan.spacing - 1e-6)), glm::ivec3(0));
  const glm::ivec3 hi =
      glm::min(glm::ivec3(glm::floor((region.hi - scan.origin) / scan.spacing + 1e-6)), scan.grey.size - 1);
  constexpr int kMin = 8;  // smallest number of samples of the region along an axis
  if (glm::any(glm::lessThan(hi - lo + 1, glm::ivec3(kMin)))) {
    const dvec3 from = scan.origin / kMillimetre,
                to = (scan.origin + dvec3(scan.grey.size - 1) * scan.spacing) / kMillimetre;
    throw Error("--region-mm", "",
                fmt::format("{} x {} x {} voxels of the scan", std::max(hi.x - lo.x + 1, 0),
                            std::max(hi.y - lo.y + 1, 0), std::max(hi.z - lo.z + 1, 0)),
                fmt::format("{} or more along each axis; the scan extends from ({:.1f}, {:.1f}, {:.1f}) to "
                            "({:.1f}, {:.1f}, {:.1f}) mm",
                            kMin, from.x, from.y, from.z, to.x, to.y, to.z));
  }
  Scan piece;
  piece.format = scan.format;
  piece.spacing = scan.spacing;
  piece.origin = scan.origin + dvec3(lo) * scan.spacing;
  piece.space = scan.space;
  piece.world_rotation = scan.world_rotation;
  piece.notes = scan.notes;
  piece.grey = Grid<float>(hi - lo + 1);
  for_each_in_parallel(piece.grey.size.x, [&](int x) {
    for (int y = 0; y < piece.grey.size.y; ++y) {
      const float* row = &scan.grey(lo.x + x, lo.y + y, lo.z);
      std::copy(row, row + piece.grey.size.z, &piece.grey(x, y, 0));
    }
  });
  return piece;
}

// Finds grey values. `smooth`: the scan after slight smoothing.
static ScanGreys greys_without_shading(const std::filesystem::path& file, const Scan& scan, const Grid<float>& smooth,
                                       const ImportOptions& options) {
  ScanGreys greys;
  Levels& levels = greys.levels;
  levels = find_levels(file, scan.grey, smooth, options, greys.notes);
  if (options.preset != ImportPreset::kJaw) return greys;
  if (!levels.hounsfield)
    throw Error(file.string(), "greys", "a scale that is not known",
                "Hounsfield units plus a constant; --hounsfield OFFSET gives it, e.g. 0 or 1024");
  greys.jaw = find_jaw_greys(smooth, levels.surface(), *levels.hounsfield, levels.smoothed_noise);
  levels.noise = noise_of(scan.grey);
  // The surface lies half-way between the surroundings and the tissue below it, which has a grey value from levels.soft
  // (cancellous bone) to levels.dense (metal or enamel).
  levels.soft = greys.jaw.cancellous;
  levels.dense = greys.jaw.metal.value_or(greys.jaw.enamel);
  if (greys.jaw.has_enamel) levels.tooth = greys.jaw.crown();
  if (!greys.jaw.has_enamel) greys.notes.push_back("nothing as bright as enamel: no teeth are told from the bone");
  return greys;
}

// Finds the grey values. Of a jaw, first removes the shading from `scan` and `smooth`.
static ScanGreys greys_of(const std::filesystem::path& file, Scan& scan, Grid<float>& smooth,
                          const ImportOptions& options) {
  std::optional<Shading> shading;
  if (options.preset == ImportPreset::kJaw) shading = find_shading(scan, smooth, noise_of(scan.grey));
  if (shading) {
    shading->remove_from(scan);
    smooth = gaussian(scan.grey, kScanSmoothing);
  }
  ScanGreys greys = greys_without_shading(file, scan, smooth, options);
  greys.shading = shading;
  if (shading)
    greys.notes.push_back(
        fmt::format("the greys change by {:.0f} across the scan (shading); this was corrected", shading->range));
  return greys;
}

ScanGreys find_greys(const std::filesystem::path& file, Scan scan, const ImportOptions& options) {
  Grid<float> smooth = gaussian(scan.grey, kScanSmoothing);
  return greys_of(file, scan, smooth, options);
}

Imported import_scan(const std::filesystem::path& file, const ImportOptions& options) {
  const bool tooth = options.preset == ImportPreset::kTooth;
  // A tooth is 10 to 35 mm long; voxels above 0.7 mm cannot show it.
  const SpacingLimits limits = tooth
                                   ? SpacingLimits{1e-6, 0.7e-3, "a tooth", "; of a jaw or another bone --preset bone"}
                                   : SpacingLimits{1e-6, 3e-3, "a bone", ""};
  Scan scan = read_scan({file, options.series, options.memory}, options.spacing, options.nan_grey, limits);
  if (is_label_map(scan, options))
    return import_labels(file, options.region ? cropped(scan, *options.region) : scan, options);
  if (!options.surface_grey) refuse_labels(file, scan);
  if (!options.region) return import_read_scan(file, std::move(scan), nullptr, options);
  const ScanGreys greys = find_greys(file, scan, options);
  scan = cropped(scan, *options.region);
  return import_read_scan(file, std::move(scan), &greys, options);
}

Imported import_region(const std::filesystem::path& file, const Scan& scan, const ScanGreys& greys,
                       const ImportOptions& options) {
  const ImportRegion all{scan.origin, scan.origin + dvec3(scan.grey.size - 1) * scan.spacing};
  return import_read_scan(file, cropped(scan, options.region.value_or(all)), &greys, options);
}

// Adds notes about the largest bodies that were not imported.
static void say_what_is_left_out(const std::vector<Body>& bodies, std::size_t main, const Scan& scan,
                                 ImportReport& report) {
  constexpr double kMin = 0.3e-6;  // m³, smallest body that is worth a note
  constexpr std::size_t kMost = 4;
  const double voxel = scan.spacing.x * scan.spacing.y * scan.spacing.z;
  std::vector<const Body*> others;
  for (const Body& body : bodies) {
    if (&body != &bodies[main] && static_cast<double>(body.voxels) * voxel >= kMin) others.push_back(&body);
  }
  std::ranges::sort(others, std::greater<>(), &Body::voxels);
  others.resize(std::min(others.size(), kMost));
  for (const Body* body : others) {
    const dvec3 from = (scan.origin + dvec3(body->lo) * scan.spacing) / kMillimetre,
                to = (scan.origin + dvec3(body->hi) * scan.spacing) / kMillimetre;
    report.notes.push_back(fmt::format(
        "another body of {:.1f} cm³{} is left out; --region-mm {:.0f},{:.0f},{:.0f},{:.0f},{:.0f},{:.0f} shows where "
        "it lies",
        static_cast<double>(body->voxels) * voxel / 1e-6,
        static_cast<double>(body->bright) * voxel >= Levels::kMinTeeth ? " with teeth" : "", std::floor(from.x),
        std::floor(from.y), std::floor(from.z), std::ceil(to.x), std::ceil(to.y), std::ceil(to.z)));
  }
}

// Uncertainty of a tissue's volume: area of its border × the standard deviation of its position (`border`, m).
static PerTissue volume_uncertainty(const DenseTissue& t, double border) {
  PerTissue faces{};
  for_each_voxel_between(glm::ivec3(1), t.size - 2, [&](int x, int y, int z) {
    const std::size_t i = t.at(x, y, z);
    if (t.distance[i] >= 0) return;
    for (const glm::ivec3& step : kFaceSteps) {
      const std::size_t j = t.at(x + step.x, y + step.y, z + step.z);
      faces[static_cast<std::size_t>(t.tissue[i])] += t.distance[j] >= 0 || t.tissue[j] != t.tissue[i];
    }
  });
  // Mean ratio of the area of voxel faces to the area of the true surface.
  constexpr double kFacesPerArea = 1.5;
  for (double& of_tissue : faces) of_tissue *= t.frame.voxel * t.frame.voxel / kFacesPerArea * border;
  return faces;
}

static Imported import_read_scan(const std::filesystem::path& file, Scan scan, const ScanGreys* known,
                                 const ImportOptions& options) {
  const bool tooth = options.preset == ImportPreset::kTooth, jaw = options.preset == ImportPreset::kJaw;
  const auto progress = [&](double done) {
    if (options.progress) options.progress(done);
  };
  Imported result;
  ImportReport& report = result.report;
  report.format = scan.format;
  report.spacing = scan.spacing;
  report.space = scan.space;
  report.world_rotation = scan.world_rotation;
  report.notes = scan.notes;
  progress(0.1);

  constexpr double kRounding = 1e-6;
  const auto read_voxels = static_cast<double>(scan.grey.v.size());
  const double finest = std::min({scan.spacing.x, scan.spacing.y, scan.spacing.z});
  const double voxel = options.voxel.value_or(finest);
  const glm::ivec3 k = glm::clamp(glm::ivec3(voxel / scan.spacing + 1e-6), glm::ivec3(1), scan.grey.size / 4);
  if (k != glm::ivec3(1)) reduce(scan, k);

  // First finds the body approximately, to get the grey values of its tissues and its bounding box.
  const double working = std::min({scan.spacing.x, scan.spacing.y, scan.spacing.z});
  if (known && known->shading) known->shading->remove_from(scan);
  Grid<float> smooth = gaussian(scan.grey, kScanSmoothing);
  const ScanGreys greys = known ? *known : greys_of(file, scan, smooth, options);
  const Levels& levels = greys.levels;
  const JawGreys& jaw_greys = greys.jaw;
  report.notes.insert(report.notes.end(), greys.notes.begin(), greys.notes.end());
  if (jaw)
    report.kinds = {jaw_greys.bright(), jaw_greys.crown(), jaw_greys.soft, jaw_greys.cancellous, jaw_greys.hard};
  else if (levels.dense)
    report.kinds = {levels.denser(), levels.denser(), levels.outside, levels.soft, *levels.dense};
  else  // no enamel: all bone is cortical
    report.kinds = {levels.surface(), std::numeric_limits<double>::infinity(), levels.outside, levels.soft,
                    levels.soft};
  Mask solid(smooth.size, 0);
  const auto surface = static_cast<float>(levels.surface());
  const auto tooth_grey = static_cast<float>(levels.tooth.value_or(std::numeric_limits<float>::infinity()));
  for_each_voxel_in_parallel(solid.size, [&](int x, int y, int z) {
    const float grey = smooth(x, y, z);
    solid(x, y, z) = grey > surface ? grey > tooth_grey ? kBrightVoxel : 1 : 0;
  });
  smooth = Grid<float>();
  const std::vector<Body> bodies = find_bodies(solid);
  if (bodies.empty()) {
    throw Error(file.string(), "greys", fmt::format("nothing brighter than {:.6g}", levels.surface()),
                "tissue; see --thresholds");
  }
  for (const Body& body : bodies) report.bodies_found += body.voxels >= 8;
  const std::size_t main = main_body(bodies, Levels::kMinTeeth / (scan.spacing.x * scan.spacing.y * scan.spacing.z));
  const glm::ivec3 lo = bodies[main].lo, hi = bodies[main].hi, scan_size = solid.size;
  if (jaw) say_what_is_left_out(bodies, main, scan, report);
  // Volume of all blocks with tissue and of the blocks beside these, m³.
  const double near_tissue =
      fraction_near(solid) * static_cast<double>(solid.v.size()) * scan.spacing.x * scan.spacing.y * scan.spacing.z;
  solid = Mask();
  const char* of = options.region ? "region" : "scan";
  for (int a = 0; a < 3; ++a) {
    const char axis = "xyz"[a];
    if (lo[a] == 0)
      report.notes.push_back(
          fmt::format("the tissue touches the {}'s {}- wall and is closed there by a flat cut", of, axis));
    if (hi[a] == scan_size[a] - 1)
      report.notes.push_back(
          fmt::format("the tissue touches the {}'s {}+ wall and is closed there by a flat cut", of, axis));
  }
  const glm::dvec3 extent = glm::dvec3(hi - lo + 1) * scan.spacing;
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double least = tooth ? 1e-3 : 3e-3, most = tooth ? 60e-3 : 0.6;
  if (longest < least || longest > most) {
    throw Error(
        file.string(), options.spacing ? "--spacing-mm" : "spacing",
        fmt::format("a body {:.4g} mm long at {:.4g} {:.4g} {:.4g} mm a voxel", longest / kMillimetre,
                    report.spacing.x / kMillimetre, report.spacing.y / kMillimetre, report.spacing.z / kMillimetre),
        fmt::format("{} of {:g} to {:g} mm; {}", tooth ? "a tooth" : "a bone", least / kMillimetre, most / kMillimetre,
                    tooth && !options.spacing && longest > most
                        ? "of a jaw or another bone --preset bone; where the file is wrong, --spacing-mm X,Y,Z"
                        : "where the file is wrong, give the true voxel with --spacing-mm X,Y,Z"));
  }
  check_result_size(extent + 2 * options.band, voxel);
  check_result_size(extent + 20 * working, working);
  {
    // Memory in bytes per voxel, measured by ./run bench import: whole scan; box of the body; stored blocks during
    // segmentation, after it, and on another grid; imported volume; kept grey values. kResidue: fixed memory, bytes.
    constexpr double kRead = 9, kBox = 4, kSegmented = 38, kKept = 28, kPlaced = 24, kResult = 6, kGrey = 4,
                     kResidue = 90e6;
    // Additional memory for the scan of a jaw and of a tooth, bytes per voxel near tissue.
    constexpr double kJaw = 70, kTooth = 35;
    const auto voxels = [](const glm::dvec3& size, double h) { return size.x / h * size.y / h * size.z / h; };
    const double box = voxels(extent + 20 * working, working);
    const double near = std::min(box, near_tissue / std::pow(working, 3));
    const bool same_grid = std::abs(voxel / working - 1) < kRounding;
    const double placed = same_grid ? 0 : kPlaced * near * std::pow(working / voxel, 3);
    const double made = (kResult + (options.greys ? kGrey : 0) + (options.hardness || jaw ? 1 : 0)) *
                        voxels(extent + 2 * options.band + 4 * voxel, voxel);
    const double labels = jaw ? kJaw * near : 0;
    require_memory(kResidue + std::max({kRead * read_voxels, kBox * box + (kSegmented + (tooth ? kTooth : 0)) * near,
                                        kBox * box + kKept * near + labels, kBox * box + kKept * near + placed + made}),
                   options, report);
  }
  progress(0.2);

  // If the imported volume has the same grid spacing as the working grid, segment() also computes its distances.
  const double scale = voxel / working, band = options.band / working;
  const bool same_grid = std::abs(scale - 1) < kRounding;
  const double around_body = same_grid ? std::max(10.0, band + 6) : 10;
  const glm::ivec3 margin = glm::ivec3(glm::ceil(around_body * working / scan.spacing)) + 1;
  Grid<float> grey = resample(scan, lo - margin, hi + margin, working, static_cast<float>(levels.outside));
  CutWalls wall{};
  for (int a = 0; a < 3; ++a) {
    auto& of_axis = wall[static_cast<std::size_t>(a)];
    const double step = scan.spacing[a] / working;
    if (lo[a] == 0) of_axis[0] = static_cast<int>(std::ceil(margin[a] * step - kRounding));
    if (hi[a] == scan_size[a] - 1) of_axis[1] = static_cast<int>((margin[a] + hi[a] - lo[a]) * step + kRounding);
  }
  // Width of the widest nerve canal and root canal that are closed, m.
  constexpr double kNerveCanal = 5e-3, kRootCanal = 3e-3;
  close_walls(grey, wall, levels.surface(), levels.soft, kNerveCanal, working);
  if (jaw) close_walls(grey, wall, jaw_greys.bright(), jaw_greys.hard, kRootCanal, working);
  const glm::dvec3 origin = scan.origin + glm::dvec3(lo - margin) * scan.spacing;
  scan.grey = Grid<float>();
  Segmentation s = segment(grey, levels, working, options.preset, same_grid ? std::optional(band) : std::nullopt,
                           [&](double done) { progress(0.2 + 0.5 * done); });

  std::optional<JawLabels> labels;
  if (jaw) {
    labels =
        label_jaw(grey, s, jaw_greys, wall, levels.noise, working, [&](double done) { progress(0.7 + 0.2 * done); });
    for (JawCanal& canal : labels->report.canals) {
      for (dvec3& c : canal.centre) c = origin + working * c;
    }
    for (JawTooth& of_jaw : labels->report.teeth) of_jaw.centre = origin + working * of_jaw.centre;
    report.jaw = std::move(labels->report);
  }

  // First voxel and size of the imported volume. At least one sample of its grid is also a sample of the working grid.
  glm::ivec3 first = grey.size, last(0);
  for (std::size_t i = 0; i < s.surface.distance.v.size(); ++i) {  // blocks that are not stored lie deeper inside
    if (!(s.surface.distance.v[i] < 0)) continue;
    first = glm::min(first, s.surface.distance.place(i));
    last = glm::max(last, s.surface.distance.place(i));
  }
  if (first.x > last.x)
    throw Error(file.string(), "greys", "no body left after smoothing", "tissue a few voxels thick");
  const glm::ivec3 from = glm::ivec3(glm::floor((glm::dvec3(first) - 2.0 - band) / scale + kRounding));
  const glm::ivec3 to = glm::ivec3(glm::ceil((glm::dvec3(last) + 2.0 + band) / scale - kRounding));
  DenseTissue& out = result.tissue;
  out.size = to - from + 1;
  out.band = options.band;
  const Placement placement{scale * glm::dvec3(from), scale};
  out.frame = {origin + working * placement.offset, voxel};
  const DistanceField field =
      same_grid ? std::move(s.surface) : signed_distance(s.phi, out.size, placement, band, band);
  // Shift from indices of the imported volume to indices of `field`.
  const glm::ivec3 shift = same_grid ? from : glm::ivec3(0);
  progress(0.9);

  const Tissue dense = tooth ? Tissue::kEnamel : Tissue::kCorticalBone;
  const Tissue soft = tooth ? Tissue::kDentin : levels.dense ? Tissue::kCancellousBone : Tissue::kCorticalBone;
  const Tissue cavity = tooth ? Tissue::kPulp : Tissue::kCancellousBone;
  out.distance.resize(voxel_count(out.size));
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  if (options.greys) result.grey.resize(out.distance.size());
  if (options.hardness || jaw) out.hardness.assign(out.distance.size(), kOwnHardness);
  const double reach = kLabelReach * scale;
  for_each_voxel_in_parallel(out.size, [&](int x, int y, int z) {
    const std::size_t i = out.at(x, y, z);
    const glm::ivec3 at = shift + glm::ivec3(x, y, z);
    const double d = field.distance[at];
    const dvec3 q = placement.offset + scale * dvec3(x, y, z);
    out.distance[i] = static_cast<float>(std::clamp(d * working, -out.band, out.band));
    if (options.greys) result.grey[i] = same_grid ? grey[at] : sample(grey, q);
    if (d > reach) return;
    dvec3 p = q;
    if (d > 0) {
      const dvec3 c(field.closest[at]);
      const double away = glm::length(q - c);
      p = away > 1e-6 ? c + 0.5 / away * (c - q) : c;
    }
    if (labels) {
      const dvec3 near = glm::clamp(glm::round(p), dvec3(0), dvec3(grey.size - 1));
      const Tissue t = labels->tissue[glm::ivec3(near)];
      out.tissue[i] = t == Tissue::kAir ? Tissue::kCancellousBone : t;
      const bool bone = t == Tissue::kCorticalBone || t == Tissue::kCancellousBone;
      if (bone) {
        const double own = t == Tissue::kCorticalBone ? jaw_greys.hard : jaw_greys.cancellous;
        out.hardness[i] = hardness_byte((sample(s.grey, p) - jaw_greys.soft) / (own - jaw_greys.soft));
      }
      return;
    }
    const bool in_cavity = sample(s.cavity, p) > 0, is_dense = !in_cavity && sample(s.dense, p) > 0;
    out.tissue[i] = in_cavity ? cavity : is_dense ? dense : soft;
    if (options.hardness && !(in_cavity && tooth)) {
      const HardnessGreys& h = *options.hardness;
      const double own = is_dense ? h.dense.value_or(h.zero) : h.own, above = sample(s.grey, p) - h.zero;
      if (own > h.zero) out.hardness[i] = hardness_byte(above / (own - h.zero));
    }
  });

  // Uncertainty of volumes. In a jaw, adds the volume that may be mislabelled between teeth and bone.
  const double contrast = levels.dense ? *levels.dense - levels.soft : levels.soft - levels.outside;
  report.volume_uncertainty = volume_uncertainty(
      out, report.jaw ? report.jaw->border : working * border_uncertainty(levels.noise / contrast, s.blur));
  if (report.jaw) {
    for (const Tissue t : {Tissue::kDentin, Tissue::kCorticalBone})
      report.volume_uncertainty[static_cast<std::size_t>(t)] += report.jaw->mislabelled;
  }
  if (tooth && levels.dense) {
    constexpr double kNarrowest = 1.5;  // voxels, diameter of the narrowest root canal that is found
    const double narrowest = kNarrowest * working, unseen = unseen_canal_volume(out, narrowest);
    // Adds half of `unseen`, the volume of canals too narrow to be found, so that twice the uncertainty contains it.
    for (const Tissue t : {Tissue::kDentin, Tissue::kPulp})
      report.volume_uncertainty[static_cast<std::size_t>(t)] += 0.5 * unseen;
    if (unseen >= 1 * kCubicMillimetre)
      report.notes.push_back(
          fmt::format("root canals narrower than {:.2f} mm are not found; the roots in which no pulp was found can "
                      "contain up to {:.1f} mm³ of it",
                      narrowest / kMillimetre, unseen / kCubicMillimetre));
  }

  report.outside_grey = levels.outside;
  report.soft_grey = levels.soft;
  report.surface_grey = levels.surface();
  report.dense_level = levels.dense;
  if (levels.dense) report.dense_grey = levels.denser();
  report.noise_grey = levels.noise;
  report.blur = s.blur * working;
  report.bodies_kept = s.bodies_kept;
  report.pulp_parts = s.cavity_parts;
  return result;
}

}  // namespace typodont::haptics::importing
