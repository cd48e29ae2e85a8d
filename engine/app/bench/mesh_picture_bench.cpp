// Measures the picture of a mesh while it is carved (contact models mesh_lod and vertex). Compares two ways to update
// and upload the mesh: only the parts that changed since the last frame, or the whole mesh.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/bench/parts.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/app/scene.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/lockstep.h"
#include "haptics/tissue_mesh.h"

namespace typodont {

namespace {

constexpr double kBur = 0.6e-3;       // m, radius of a round bur
constexpr int kApproach = 500;        // number of ticks in which the bur moves from the air into the surface
constexpr int kTicksAFrame = 16;      // number of ticks of 1 ms per frame
constexpr double kDepth = 0.3e-3;     // m, depth of the bur below the surface
constexpr double kPace = 5e-3;        // m/s, speed of the bur along the surface
constexpr double kPictureTime = 2e6;  // ns, time limit: an update of the picture should take less than this

/// Divides every triangle into four similar triangles, which gives a finer mesh.
haptics::TissueMesh divided(const haptics::TissueMesh& mesh) {
  haptics::TissueMesh finer;
  finer.vertices = mesh.vertices;
  std::map<std::pair<unsigned, unsigned>, unsigned> middle;
  const auto between = [&](unsigned a, unsigned b) {
    const auto [found, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<unsigned>(finer.vertices.size()));
    if (fresh) finer.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    return found->second;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    const unsigned a = between(v.x, v.y), b = between(v.y, v.z), c = between(v.z, v.x);
    for (const glm::uvec3& f :
         {glm::uvec3(v.x, a, c), glm::uvec3(a, v.y, b), glm::uvec3(c, b, v.z), glm::uvec3(a, b, c)})
      finer.triangles.push_back(f), finer.tissue.push_back(mesh.tissue[t]);
  }
  return finer;
}

void rows_of(const char* what, haptics::TissueVolume volume, bool quick, std::vector<BenchRow>& rows) {
  const haptics::TissueMesh mesh = haptics::surface_mesh(volume);
  dvec3 top = mesh.vertices.front();
  for (const dvec3& p : mesh.vertices)
    if (p.z > top.z) top = p;
  haptics::ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 2 * kBur;
  settings.spindle.free_speed = 300 * kKrpm;
  settings.materials.fill({1000, 20e9, 0.2, 0.15, 2900, dvec3(0.9)});
  settings.method = haptics::contact_method("vertex", "bench");
  haptics::LockStep steps(std::move(volume), settings);
  const display::DisplayRig rig = display::load_rig(assets_folder() / "rigs/closeup.json");
  PictureStage stage(rig, settings, {});
  const dvec3 origin = steps.carver().volume().frame().origin;
  TissueView view;
  const auto timed = [](const auto& work) {
    const Nanos began = now();
    work();
    return static_cast<double>(now() - began);
  };
  std::vector<render::MeshUpdate> bricks;
  const double whole = timed([&] {
    bricks = view.update(steps.carver());
    stage.show(bricks, origin);
  });
  const std::size_t all = bricks.size();

  std::vector<double> made, uploaded, together, triangles;
  ServoTick tick;
  Cut cut;
  haptics::HandSample hand;
  hand.pedal = 1;
  const int ticks = quick ? 4000 : 20'000;
  for (int i = 0; i < kApproach + ticks; ++i) {
    hand.t += 1'000'000;
    const double down = std::min(i, kApproach) * (kDepth + 0.05e-3) / kApproach, on = std::max(i - kApproach, 0) * 1e-3;
    hand.X_WT.p = top + dvec3(1e-3 * std::sin(kPace * on / 1e-3), 2e-4 * std::sin(0.3 * on), kBur + 0.05e-3 - down);
    steps.tick(hand, tick, cut);
    if (i < kApproach || i % kTicksAFrame != 0) continue;
    made.push_back(timed([&] { bricks = view.update(steps.carver()); }));
    if (bricks.empty()) {
      made.pop_back();
      continue;
    }
    uploaded.push_back(timed([&] { stage.show(bricks, origin); }));
    together.push_back(made.back() + uploaded.back());
    double count = 0;
    for (const render::MeshUpdate& brick : bricks) count += static_cast<double>(brick.indices.size()) / 3;
    triangles.push_back(count);
  }
  const auto row = [&](const char* name, double ns, double size, const char* unit) {
    BenchRow r;
    r.name = name;
    r.knob = fmt::format("{}, round 1.2 mm, edge 0.1 mm, {} vertices", what, mesh.vertices.size());
    r.time_ns = ns, r.per = "update";
    r.baseline = "2 ms", r.ratio = ns / kPictureTime;
    r.size = size, r.size_unit = unit;
    rows.push_back(r);
  };
  row("changes of 16 ms, prepared, median", quantile(made, 0.5), quantile(triangles, 0.5), "triangles");
  row("changes of 16 ms, uploaded, median", quantile(uploaded, 0.5), quantile(triangles, 0.5), "triangles");
  row("both, 99 %", quantile(together, 0.99), quantile(triangles, 0.99), "triangles");
  row("whole mesh, once", whole, static_cast<double>(all), "pieces");
}

}  // namespace

std::vector<BenchRow> bench_mesh_picture(const BenchRun& run) {
  std::vector<BenchRow> rows;
  const auto scene = [](const char* name) {
    return load_untouched(read_scene(assets_folder() / "scenes" / (std::string(name) + ".json")));
  };
  // The molar has four tissues in layers, so the program must find the tissue below every vertex.
  rows_of("molar", scene("molar-caries"), run.quick, rows);
  haptics::TissueVolume arch = scene("arch-carve");
  for (int level = 1; level <= (run.quick ? 1 : 3); ++level) {
    arch.set_mesh(std::make_shared<const haptics::TissueMesh>(divided(*arch.mesh())));
    if (level == 2) continue;
    haptics::TissueVolume finer = arch.clone();
    finer.set_mesh(arch.mesh());
    rows_of("arch", std::move(finer), run.quick, rows);
  }
  return rows;
}

}  // namespace typodont
