// The mesh of the tissue against OpenVDB's volumeToMesh, on one thread: the whole molar, a frame of drilling, and a
// ball at equal error.
#include <memory>
#include <optional>

#include "engine/app/assets.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/carver.h"
#include "tests/bench/bench.h"
#include "tests/bench/level_set.h"
#include "tests/support/surface_checks.h"

namespace typodont::bench {

namespace {

using namespace literals;
constexpr float kBand = 4;                    // voxels
constexpr glm::dvec3 kCentre(8.3, 7.6, 8.9);  // voxels, of the balls; no grid point

int repeats() {
  return smoke() ? 1 : 7;
}

/// The shipped molar, resampled to voxels of 0.05 mm.
haptics::DenseTissue fine_molar() {
  const haptics::TissueVolume coarse = haptics::TissueVolume::load(assets_folder() / "teeth/molar.vdb");
  glm::ivec3 lo, hi;
  coarse.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> distance(static_cast<std::size_t>(size.x) * size.y * size.z);
  std::vector<Tissue> tissue(distance.size());
  coarse.copy(lo, size, distance.data(), tissue.data());
  const VoxelFrame from = coarse.frame();
  const double voxel = smoke() ? 0.2_mm : 0.05_mm, ratio = voxel / from.voxel;
  const auto at = [&](glm::ivec3 p) {
    p = glm::clamp(p, glm::ivec3(0), size - 1);
    return static_cast<std::size_t>((p.x * size.y + p.y) * size.z + p.z);
  };
  haptics::DenseTissue fine;
  fine.frame = {from.to_world(dvec3(lo)), voxel};
  fine.size = glm::ivec3(dvec3(size - 1) / ratio);
  fine.band = 8 * voxel;
  for_each_voxel(fine.size, [&](int x, int y, int z) {
    const glm::ivec3 i(x, y, z);
    const dvec3 p = dvec3(i) * ratio, f = p - glm::floor(p);
    double d = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 c(corner & 1, corner >> 1 & 1, corner >> 2);
      const dvec3 w = glm::mix(1.0 - f, f, dvec3(c));
      d += w.x * w.y * w.z * static_cast<double>(distance[at(glm::ivec3(p) + c)]);
    }
    fine.distance.push_back(static_cast<float>(std::clamp(d * from.voxel, -fine.band, fine.band)));
    fine.tissue.push_back(tissue[at(glm::ivec3(p + 0.5))]);
  });
  return fine;
}

/// Time (ns) to mesh these bricks.
double mesh_time(surface::SurfaceMesher& mesher, const haptics::TissueVolume& volume,
                 const std::vector<glm::ivec3>& keys) {
  std::vector<FieldBrick> bricks(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) volume.read_brick(keys[i], bricks[i]);
  return measure(1,
                 [&] {
                   for (const FieldBrick& brick : bricks) mesher.put(brick);
                   (void)mesher.remesh();
                 })
      .median;
}

struct Molar {
  haptics::DenseTissue dense = fine_molar();
  haptics::TissueVolume volume{dense};
  double theirs = 0;  // ns, volumeToMesh of the whole
};

/// The whole molar, and frames of a bur of 1.2 mm that drills its crown at 6 mm/s, 60 per second. The time is that of
/// the picture: reading samples, triangles, and the tissues below the surface.
void drilling_frame(benchmark::State& state, Molar& molar, float tolerance) {
  const Scene scene = parse_scene(
      Json::parse(R"({"tissue": {"volume": "teeth/molar.vdb"}, "tool": "round_012", "parts": ["haptics"]})", "bench"),
      {});
  // A carver reports each change once, so the mesh and the picture have a carver each.
  haptics::Carver carver(molar.volume.clone(), haptics::tool_set(scene.servo)),
      same(molar.volume.clone(), haptics::tool_set(scene.servo));
  TissueView view(tolerance);
  surface::SurfaceMesher mesher({.tolerance = tolerance});
  state.counters["whole_mesh_ns"] = mesh_time(mesher, molar.volume, molar.volume.surface_bricks());
  state.counters["whole_picture_ns"] = measure(1, [&] { (void)view.update(carver.volume()); }).median;
  state.counters["triangles"] = static_cast<double>(test::triangle_count(mesher));
  glm::ivec3 lo, hi;
  molar.volume.bounds(lo, hi);
  const VoxelFrame frame = molar.volume.frame();
  const dvec3 middle = frame.to_world(0.5 * dvec3(lo + hi)), high = frame.to_world(dvec3(hi));
  std::vector<double> pictures, meshes;
  Nanos t = kNanosPerSecond;
  for (int i = 0; i < (smoke() ? 20 : 60); ++i) {
    Cut cut;
    cut.index = carver.cuts() + 1, cut.t = t += kNanosPerSecond / 60;
    cut.X_WA.p = {middle.x - 3.0_mm + i * 0.1_mm, middle.y, high.z - 3.0_mm};
    cut.X_WB.p = cut.X_WA.p + dvec3(0.1_mm, 0, 0);
    carver.apply(cut);
    same.apply(cut);
    const Nanos start = thread_cpu_time();
    if (view.update(carver.volume()).empty()) continue;
    pictures.push_back(static_cast<double>(thread_cpu_time() - start));
    meshes.push_back(mesh_time(mesher, same.volume(), same.volume().take_changed_bricks()));
  }
  set_times(state, pictures);
  state.counters["mesh_ns"] = quantile(meshes, 0.5);
  require_time(quantile(meshes, 0.5) < molar.theirs / 50,
               "a drilling frame is fifty times faster than the whole molar");
}

/// Meshes a ball of 60 voxels. volumeToMesh gets a finer grid, with which its error is the same.
void ball(benchmark::State& state) {
  const auto distance = [](double radius) {
    return [radius](const glm::dvec3& p) { return glm::length(p - kCentre) - radius; };
  };
  const double radius = smoke() ? 20 : 60;
  const auto bricks = test::sample_bricks(kCentre - radius - 2.0, kCentre + radius + 2.0, distance(radius));
  std::optional<surface::SurfaceMesher> mesher;
  const double ours = measure(repeats(), [&] {
                        mesher.emplace(surface::SurfaceMesher({.tolerance = -1}));
                        for (const FieldBrick& brick : bricks) mesher->put(brick);
                        (void)mesher->remesh();
                      }).median;
  const double error = test::max_error(surface::weld(*mesher), distance(radius)) / radius;
  double theirs = 0;
  for (double finer = radius; finer < 6 * radius; finer *= 1.1) {
    const LevelSet grid(finer, kCentre, kBand);
    LevelSet::Mesh made;
    theirs = grid.extract(1, made);
    surface::WholeMesh mesh;
    for (const glm::vec3& p : made.points) mesh.vertices.push_back({p, {}, Tissue::kEnamel});
    for (const auto& t : made.triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
    if (test::max_error(mesh, distance(finer)) / finer > error) continue;
    theirs = grid.extract(repeats(), made);
    break;
  }
  set_time(state, ours);
  state.counters["error_of_radius"] = error;
  state.counters["volume_to_mesh_ns"] = theirs;
  require_time(ours < theirs / 3, "the whole ball is meshed three times faster than by volumeToMesh at equal error");
}

/// Triangles for an error: N ε / R of a sphere of R voxels (optimum 4.84, marching cubes 14.1).
void sphere(benchmark::State& state, float tolerance) {
  const double radius = 50;
  const auto distance = [&](const glm::dvec3& p) { return glm::length(p - kCentre) - radius; };
  const auto bricks = test::sample_bricks(kCentre - radius - 2.0, kCentre + radius + 2.0, distance);
  surface::SurfaceMesher mesher({.tolerance = tolerance});
  const double ns = measure(repeats(), [&] {
                      for (const FieldBrick& brick : bricks) mesher.put(brick);
                      (void)mesher.remesh();
                    }).median;
  const surface::WholeMesh mesh = surface::weld(mesher);
  const auto triangles = static_cast<double>(mesh.triangles.size());
  const double cost = triangles * test::max_error(mesh, distance) / radius;
  set_time(state, ns / static_cast<double>(bricks.size()));
  state.counters["triangles"] = triangles;
  state.counters["triangles_times_error"] = cost;
  require(cost < 7.3, "a sphere needs few triangles for its error");
}

}  // namespace

void add_cases() {
  const auto molar = std::make_shared<std::optional<Molar>>();
  const auto loaded = [molar]() -> Molar& { return *molar ? **molar : molar->emplace(); };
  add("molar/whole by volumeToMesh", [=](benchmark::State& state) {
    LevelSet::Mesh mesh;
    const LevelSet grid(loaded().dense, kBand);
    set_time(state, loaded().theirs = grid.extract(repeats(), mesh));
    state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  });
  for (const float tolerance : {-1.0f, 0.1f})
    add(fmt::format("molar/drilling frame/{}", tolerance < 0 ? "full resolution" : "tolerance 0.1 voxel"),
        [=](benchmark::State& state) { drilling_frame(state, loaded(), tolerance); });
  add("ball at equal error", ball);
  for (const float tolerance : {-1.0f, 0.0f, 0.05f, 0.1f, 0.2f})
    add(fmt::format("sphere, a brick/tolerance {:g}", tolerance),
        [=](benchmark::State& state) { sphere(state, tolerance); });
}

}  // namespace typodont::bench
