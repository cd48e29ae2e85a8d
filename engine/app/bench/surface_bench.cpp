// Compares the cost of this program's surface mesh with OpenVDB's volumeToMesh, in one run and on one thread. There are
// three inputs: the whole molar with voxels of 0.05 mm; the part of the molar that changes in one frame of drilling;
// and a ball. For the ball, volumeToMesh gets a finer grid, with which both meshes have the same error. The rows
// "triangles" measure only the meshing, because volumeToMesh does nothing else. The rows "picture" measure all work of
// a TissueView, which also reads the samples from the volume and finds the tissues below the surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "engine/surface/bench.h"
#include "engine/surface/mesh_export.h"
#include "haptics/carver.h"
#include "haptics/mesh_baseline.h"

namespace typodont {

namespace {

using haptics::MeshBaseline;
using namespace literals;

constexpr double kBand = MeshBaseline::kBand;  // voxels, width of the band of stored distances around the surface

/// Returns the shipped molar, resampled with the voxel size `voxel`.
haptics::TissueVolume molar(double voxel) {
  const haptics::TissueVolume coarse = haptics::TissueVolume::load(assets_folder() / "teeth/molar.vdb");
  glm::ivec3 lo, hi;
  coarse.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> distance(static_cast<std::size_t>(size.x) * size.y * size.z);
  std::vector<Tissue> tissue(distance.size());
  coarse.copy(lo, size, distance.data(), tissue.data());
  const VoxelFrame from = coarse.frame();
  const double ratio = voxel / from.voxel;
  const auto at = [&](glm::ivec3 i) {
    i = glm::clamp(i, glm::ivec3(0), size - 1);
    return (static_cast<std::size_t>(i.x) * size.y + static_cast<std::size_t>(i.y)) * size.z +
           static_cast<std::size_t>(i.z);
  };
  haptics::DenseTissue fine;
  fine.frame = {from.to_world(dvec3(lo)), voxel};
  fine.size = glm::ivec3(dvec3(size - 1) / ratio);
  fine.band = 8 * voxel;
  fine.distance.reserve(static_cast<std::size_t>(fine.size.x) * fine.size.y * fine.size.z);
  fine.tissue.reserve(fine.distance.capacity());
  glm::ivec3 i;
  for (i.x = 0; i.x < fine.size.x; ++i.x)
    for (i.y = 0; i.y < fine.size.y; ++i.y)
      for (i.z = 0; i.z < fine.size.z; ++i.z) {
        const dvec3 p = dvec3(i) * ratio;
        const glm::ivec3 cell(p), nearest(p + 0.5);
        const dvec3 f = p - dvec3(cell);
        double d = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const glm::ivec3 c(corner & 1, corner >> 1 & 1, corner >> 2);
          d += (c.x ? f.x : 1 - f.x) * (c.y ? f.y : 1 - f.y) * (c.z ? f.z : 1 - f.z) *
               static_cast<double>(distance[at(cell + c)]);
        }
        fine.distance.push_back(static_cast<float>(std::clamp(d * from.voxel, -fine.band, fine.band)));
        fine.tissue.push_back(tissue[at(nearest)]);
      }
  return haptics::TissueVolume(fine);
}

constexpr glm::dvec3 kCentre(8.3, 7.6, 8.9);  // voxels, centre of the balls; it is not a grid point

haptics::TissueVolume ball(double radius_voxels) {
  const double voxel_mm = 0.05;
  const dvec3 center_mm = kCentre * voxel_mm;
  return load_tissue(parse_scene(
      Json::parse(
          fmt::format(
              R"({{"tissue": {{"voxel_mm": {}, "band_mm": 0.4, "solids": [{{"tissue": "enamel", "solid": {{"sphere":
          {{"center_mm": [{}, {}, {}], "radius_mm": {}}}}}}}]}}, "tool": "round_012", "parts": ["haptics"]}})",
              voxel_mm, center_mm.x, center_mm.y, center_mm.z, radius_voxels * voxel_mm),
          "bench"),
      {}));
}

std::unique_ptr<MeshBaseline> ball_grid(double radius) {
  auto grid = std::make_unique<MeshBaseline>();
  const int reach = static_cast<int>(radius) + 15;
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y) {
      // Along z, the band around the ball's surface consists of two intervals, one below and one above the centre.
      const double across = std::hypot(x - kCentre.x, y - kCentre.y);
      if (across > radius + kBand) continue;
      const double far = std::sqrt(std::max(0.0, std::pow(radius + kBand, 2) - across * across));
      const double near = std::sqrt(std::max(0.0, std::pow(radius - kBand, 2) - across * across));
      for (int z = static_cast<int>(kCentre.z - far) - 1; z <= kCentre.z + far; ++z) {
        if (std::abs(z - kCentre.z) < near - 1) z = static_cast<int>(kCentre.z + near) - 1;
        const double d = glm::length(dvec3(x, y, z) - kCentre) - radius;
        if (std::abs(d) < kBand) grid->set({x, y, z}, static_cast<float>(d));
      }
    }
  grid->finish();
  return grid;
}

/// Makes the input of volumeToMesh: a grid with the samples of `volume`, in voxel units.
std::unique_ptr<MeshBaseline> grid_of(const haptics::TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> distance(static_cast<std::size_t>(size.x) * size.y * size.z);
  volume.copy(lo, size, distance.data(), nullptr);
  auto grid = std::make_unique<MeshBaseline>();
  std::size_t s = 0;
  for (int x = 0; x < size.x; ++x)
    for (int y = 0; y < size.y; ++y)
      for (int z = 0; z < size.z; ++z)
        if (const float d = distance[s++]; std::abs(d) < kBand) grid->set(lo + glm::ivec3(x, y, z), d);
  grid->finish();
  return grid;
}

struct Extraction {
  double ns = 0;  // ns, median time of a call of volumeToMesh
  surface::WholeMesh mesh;
};

Extraction volume_to_mesh(const MeshBaseline& grid, int repeats) {
  MeshBaseline::Mesh theirs;
  Extraction out;
  out.ns = grid.extract(repeats, theirs);
  for (const glm::vec3& p : theirs.points) out.mesh.vertices.push_back({p, {}, Tissue::kEnamel});
  for (const auto& t : theirs.triangles) out.mesh.triangles.push_back({t[0], t[1], t[2]});
  return out;
}

std::vector<FieldBrick> read(const haptics::TissueVolume& volume, const std::vector<glm::ivec3>& keys) {
  std::vector<FieldBrick> bricks(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) volume.read_brick(keys[i], bricks[i]);
  return bricks;
}

/// Measures the time to mesh the bricks (blocks of voxels), ns.
double triangles_time(surface::SurfaceMesher& mesher, const std::vector<FieldBrick>& bricks) {
  return measure(1,
                 [&] {
                   for (const FieldBrick& brick : bricks) mesher.put(brick);
                   (void)mesher.remesh();
                 })
      .median;
}

/// Measures the time to make a whole picture, ns: the median of `repeats` new views. `view` becomes the last of them.
double picture_time(int repeats, float tolerance, haptics::TissueVolume& volume, TissueView& view) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    view = TissueView(tolerance);
    times.push_back(measure(1, [&] { (void)view.update(volume); }).median);
  }
  return quantile(times, 0.5);
}

/// Measures the time to mesh all bricks (blocks of voxels), ns: the median of `repeats` new meshers. `mesher` becomes
/// the last of them.
double whole_time(int repeats, float tolerance, const std::vector<FieldBrick>& bricks, surface::SurfaceMesher& mesher) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    mesher = surface::SurfaceMesher({.tolerance = tolerance});
    times.push_back(triangles_time(mesher, bricks));
  }
  return quantile(times, 0.5);
}

void molar_rows(int repeats, std::vector<BenchRow>& rows) {
  haptics::TissueVolume volume = molar(0.05_mm);
  const Extraction theirs = volume_to_mesh(*grid_of(volume), repeats);
  const std::string baseline = fmt::format("volumeToMesh of the whole, {:.1f} ms", theirs.ns * 1e-6);
  const auto row = [&](std::string name, float tolerance, double ns, const char* per, std::size_t triangles) {
    rows.push_back({.name = std::move(name),
                    .knob = tolerance < 0 ? "full resolution" : fmt::format("tolerance {:g} voxel", tolerance),
                    .time_ns = ns,
                    .per = per,
                    .baseline = baseline,
                    .ratio = ns / theirs.ns,
                    .size = static_cast<double>(triangles),
                    .size_unit = "triangles"});
  };
  const Scene scene = parse_scene(
      Json::parse(R"({"tissue": {"volume": "teeth/molar.vdb"}, "tool": "round_012", "parts": ["haptics"]})", "bench"),
      {});
  for (const float tolerance : {-1.0f, 0.1f}) {
    // A carver cuts the tissue, and reports each change of the tissue only once. The rows "triangles" and "picture"
    // both need the changes, so each of these rows has its own carver.
    haptics::Carver carver(volume.clone(), haptics::tool_set(scene.servo)),
        same(volume.clone(), haptics::tool_set(scene.servo));
    TissueView view(tolerance);
    surface::SurfaceMesher mesher({.tolerance = tolerance});
    const double triangles = whole_time(repeats, tolerance, read(volume, volume.surface_bricks()), mesher);
    row("molar at 0.05 mm, whole, triangles", tolerance, triangles, "whole", mesher.triangle_count());
    const double whole = picture_time(repeats, tolerance, carver.volume(), view);
    row("molar at 0.05 mm, whole, picture", tolerance, whole, "whole", mesher.triangle_count());
    // Drills with a bur of 1.2 mm diameter at 6 mm/s and draws 60 pictures per second. Half of the bur lies below the
    // top of the crown.
    glm::ivec3 lo, hi;
    volume.bounds(lo, hi);
    const VoxelFrame frame = volume.frame();
    const dvec3 middle = frame.to_world(0.5 * dvec3(lo + hi)), high = frame.to_world(dvec3(hi));
    std::vector<double> pictures, meshes;
    Nanos t = kNanosPerSecond;
    for (int i = 0; i < std::max(20, 10 * repeats); ++i) {
      Cut cut;
      cut.index = carver.cuts() + 1, cut.t = t += kNanosPerSecond / 60;
      cut.X_WA.p = {middle.x - 3.0_mm + i * 0.1_mm, middle.y, high.z - 3.0_mm};
      cut.X_WB.p = cut.X_WA.p + dvec3(0.1_mm, 0, 0);
      carver.apply(cut);
      same.apply(cut);
      const Nanos start = thread_cpu_time();
      const auto updates = view.update(carver.volume());
      if (updates.empty()) continue;
      pictures.push_back(static_cast<double>(thread_cpu_time() - start));
      meshes.push_back(triangles_time(mesher, read(same.volume(), same.volume().take_changed_bricks())));
    }
    row("molar at 0.05 mm, drilling frame, triangles", tolerance, quantile(meshes, 0.5), "frame",
        mesher.triangle_count());
    row("molar at 0.05 mm, drilling frame, picture", tolerance, quantile(pictures, 0.5), "frame",
        mesher.triangle_count());
  }
}

/// Adds the rows for a ball. This program's mesher gets a coarse grid. For volumeToMesh, the grid is refined until its
/// mesh has the same error as this program's mesh.
void ball_row(int repeats, std::vector<BenchRow>& rows) {
  const auto error = [](const surface::WholeMesh& mesh, const dvec3& centre, double radius) {
    return surface::largest_error(mesh, [&](const glm::dvec3& p) { return glm::length(p - centre) - radius; }) / radius;
  };
  const double radius = 60;
  haptics::TissueVolume volume = ball(radius);
  TissueView view(-1);
  const double picture = picture_time(repeats, -1, volume, view);
  surface::SurfaceMesher mesher({.tolerance = -1});
  const double triangles = whole_time(repeats, -1, read(volume, volume.surface_bricks()), mesher);
  const dvec3 centre = kCentre - volume.frame().origin / volume.frame().voxel;
  const double allowed = error(surface::weld(mesher), centre, radius);
  for (double finer = radius;; finer *= 1.1) {
    const auto grid = ball_grid(finer);
    if (error(volume_to_mesh(*grid, 1).mesh, kCentre, finer) > allowed && finer < 6 * radius) continue;
    const Extraction theirs = volume_to_mesh(*grid, repeats);
    for (const auto& [what, ns] : {std::pair{"triangles", triangles}, {"picture", picture}})
      rows.push_back({.name = fmt::format("ball at equal error, whole, {}", what),
                      .knob = fmt::format("radius {:g} voxels", radius),
                      .error = allowed,
                      .error_unit = "of the radius, greatest",
                      .time_ns = ns,
                      .per = "whole",
                      .baseline = fmt::format("volumeToMesh, radius {:.0f} voxels, {:.1f} ms", finer, theirs.ns * 1e-6),
                      .ratio = ns / theirs.ns,
                      .size = static_cast<double>(mesher.triangle_count()),
                      .size_unit = "triangles"});
    return;
  }
}

}  // namespace

std::vector<BenchRow> bench_surface(const BenchRun& run) {
  surface::BenchOptions options;
  if (run.quick) options.repeats = 3;
  std::vector<BenchRow> rows = surface::bench_sphere(options);
  molar_rows(options.repeats, rows);
  ball_row(options.repeats, rows);
  return rows;
}

}  // namespace typodont
