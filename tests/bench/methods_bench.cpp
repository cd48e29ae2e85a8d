// Contact models on large tissues: packings and meshes of growing size, cavities, and the phases of implant surgery.
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <numeric>
#include <random>

#include "engine/app/assets.h"
#include "haptics/contact/implant/implant_model.h"
#include "haptics/contact/mesh_lod/mesh_levels.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/contact_method.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/packing.h"
#include "tests/bench/haptic_scene.h"

namespace typodont::bench {

namespace {

using haptics::HeadShape;
using haptics::TissueMesh;
using haptics::TissueVolume;
using test::HapticBench;
namespace packing = haptics::packing;

haptics::ServoSettings settings_for(const std::string& method, const haptics::Tool& tool) {
  haptics::ServoSettings settings;
  settings.tool = tool;
  settings.spindle.free_speed = 300 * kKrpm;
  settings.method = haptics::read_contact_method(Json::parse(method, "bench"));
  return settings;
}

// ---- Packings of a ball of 10 mm with n spheres.

constexpr double kPacked = 5e-3, kHead = 0.6e-3;  // m, radii of the tissue and of a round bur

TissueVolume packed_ball() {
  return TissueVolume(tissue(R"([{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 5}}}])", 0.1));
}

const SpherePacking& packing_of(std::size_t spheres) {
  static std::map<std::size_t, SpherePacking> made;
  if (!made.contains(spheres)) {
    haptics::PackOptions options;
    options.spheres = spheres;
    made.emplace(spheres, haptics::pack_spheres(packed_ball(), options));
  }
  return made.at(spheres);
}

void pack(benchmark::State& state, std::size_t spheres) {
  const Nanos start = thread_cpu_time();
  const SpherePacking& made = packing_of(spheres);
  set_time(state, static_cast<double>(thread_cpu_time() - start));
  state.counters["unfilled_percent"] = 100 * (1 - made.coverage());
}

/// The direction of the surface, estimated from the overlap of a round bur with the spheres.
void pack_normal(benchmark::State& state, std::size_t spheres) {
  const SpherePacking& made = packing_of(spheres);
  const packing::SphereTissue tissue(made, packing::Removal::kMended);
  packing::SphereProxy proxy(packing::ToolSpheres({dvec3(0)}, {kHead}), {});
  PerTissue density{};
  density.fill(1);
  std::vector<packing::Place> scratch(made.size());
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> times;
  double squares = 0;
  const int looks = smoke() ? 20 : 500;
  for (int i = 0; i < looks; ++i) {
    const dvec3 out = glm::normalize(dvec3(normal(random), normal(random), normal(random)));
    proxy.place({(kPacked + kHead) * out, {1, 0, 0, 0}});
    const Nanos start = thread_cpu_time();
    const auto estimate = packing::estimate_surface(tissue, proxy, kPacked * out, 0.1e-3, density, scratch);
    times.push_back(static_cast<double>(thread_cpu_time() - start));
    squares += std::pow(degrees_between(estimate.n_W, out), 2) / looks;
  }
  set_times(state, times);
  state.counters["direction_rms_deg"] = std::sqrt(squares);
}

void pack_cut(benchmark::State& state, std::size_t spheres) {
  const auto settings =
      settings_for(fmt::format(R"({{"packing": {{"spheres": {}}}}})", spheres), round_head(2 * kHead));
  HapticBench scene = scene_of(packed_ball(), settings);
  set_times(state, servo_times(scene, 1, smoke() ? 300 : 5000, [](int i, const ServoTick&) {
              const double angle = 0.8 * std::sin(0.002 * i), deep = std::min(0.5e-3, 1e-6 * i);
              return Pose{(kPacked + kHead + 0.1e-3 - deep) *
                          dvec3(std::sin(angle), 0.1 * std::sin(0.003 * i), std::cos(angle))};
            }));
}

/// A reamer of 44 mm, pressed into a socket of bone with 180 N by a hand of 3 kg.
void ream(benchmark::State& state, std::size_t spheres) {
  const TissueVolume socket(haptics::read_solids(Json::parse(
      R"({"voxel_mm": 0.8, "band_mm": 4, "solids": [{"tissue": "cancellous_bone", "solid": {"difference": [
          {"box": {"size_mm": [56, 56, 32]}}, {"sphere": {"center_mm": [0, 0, 16], "radius_mm": 22.5}}]}}]})",
      "bench")));
  auto settings = settings_for(fmt::format(R"({{"packing": {{"spheres": {}}}}})", spheres), round_head(44e-3));
  settings.spindle.free_speed = 0.3 * kKrpm;
  settings.stiffness = 60e3, settings.damping = 20, settings.force_limit = 250, settings.torque_limit = 10;
  MaterialTable bone;
  bone.fill({1000, 0.4e9, 0.2, 0.15, 2150, dvec3(0.8)});
  HapticBench scene(socket.clone(), settings, bone);
  dvec3 x(0, 0, 16.5e-3), v(0);
  const std::vector<double> times = servo_times(scene, 1, smoke() ? 300 : 5000, [&](int, const ServoTick& last) {
    v += 1e-3 * (dvec3(-20e3 * x.x, -20e3 * x.y, -180) - 1000.0 * v + last.f_T_W) / 3.0;
    return Pose{x += 1e-3 * v};
  });
  set_times(state, times);
  state.counters["mean_ns"] = std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
}

// ---- Meshes of the dental arch with n vertices.

/// Removes pairs of opposite triangles with the same three corners, which simplification leaves on flat surfaces. With
/// such a pair, an edge would have four faces and count as a border.
TissueMesh without_double_faces(const TissueMesh& mesh) {
  const auto sorted = [&](std::size_t i) {
    std::array<std::uint32_t, 3> v{mesh.triangles[i].x, mesh.triangles[i].y, mesh.triangles[i].z};
    std::ranges::sort(v);
    return v;
  };
  // Returns true if the indices x, y, z increase cyclically. Of two triangles with opposite order, one gives true.
  const auto rises = [&](std::size_t i) {
    const glm::uvec3& t = mesh.triangles[i];
    return (t.x < t.y && t.y < t.z) || (t.y < t.z && t.z < t.x) || (t.z < t.x && t.x < t.y);
  };
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, sorted);
  std::vector<bool> gone(order.size());
  for (std::size_t from = 0, to; from < order.size(); from = to) {
    std::vector<std::size_t> faces[2];
    for (to = from; to < order.size() && sorted(order[to]) == sorted(order[from]); ++to) {
      faces[rises(order[to])].push_back(order[to]);
    }
    for (std::size_t k = 0; k < std::min(faces[0].size(), faces[1].size()); ++k) {
      gone[faces[0][k]] = gone[faces[1][k]] = true;
    }
  }
  TissueMesh result;
  std::map<std::uint32_t, std::uint32_t> number;  // of each vertex that the result uses
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (gone[i]) continue;
    glm::uvec3 t = mesh.triangles[i];
    for (int k = 0; k < 3; ++k) {
      const auto [it, fresh] = number.try_emplace(t[k], static_cast<std::uint32_t>(result.vertices.size()));
      if (fresh) result.vertices.push_back(mesh.vertices[t[k]]);
      t[k] = it->second;
    }
    result.triangles.push_back(t);
    result.tissue.push_back(mesh.tissue[i]);
  }
  return result;
}

TissueMesh arch(std::size_t vertices) {
  static const TissueMesh whole =
      haptics::read_tissue_mesh(assets_folder() / "jaw/lower_arch.ply", kMillimetre, Tissue::kEnamel).mesh;
  return without_double_faces(haptics::mesh_lod::base_mesh(whole, {vertices, {}}));
}

/// A round bur swings on the highest cusp, 0.1 mm deep, or cuts it, 0.3 mm deep.
void on_arch(benchmark::State& state, const std::string& method, std::size_t vertices, bool cuts) {
  const TissueMesh mesh = arch(vertices);
  const dvec3 top = *std::ranges::max_element(mesh.vertices, {}, &dvec3::z);
  TissueVolume volume(tissue(R"([{"tissue": "enamel", "solid": {"box": {"size_mm": [4, 4, 4]}}}])", 0.5));
  volume.set_mesh(std::make_shared<const TissueMesh>(mesh));
  haptics::ServoSettings settings = settings_for(method, round_head(2 * kHead));
  settings.cutting = cuts;
  std::vector<double> times = least_of([&] {
    HapticBench scene = scene_of(volume.clone(), settings);
    return servo_times(scene, cuts ? 1 : 0, smoke() ? 800 : 6000, [&](int i, const ServoTick&) {
      const double down = (cuts ? 0.3e-3 : 0.1e-3) * std::min(i, 500) / 500;
      return Pose{top + dvec3(0.4e-3 * std::sin(0.004 * i), 0, kHead + 0.05e-3 - down)};
    });
  });
  times.erase(times.begin(), times.begin() + 500);
  set_times(state, times);
  state.counters["vertices"] = static_cast<double>(mesh.vertices.size());
}

/// A bur sinks 1.5 mm into a block and widens the hole on a spiral. Returns the removed volume, m³.
double widen(const haptics::Tool& bur, const std::string& method, std::vector<double>& times) {
  constexpr double kDeep = 1.5e-3, kSpeed = 2e-6, kCircle = 0.5e-3, kWiden = 0.7e-3;  // m, m per tick
  static const TissueVolume block(tissue(
      R"([{"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, -2], "size_mm": [12.7, 12.7, 4]}}}])", 0.1));
  HapticBench scene = scene_of(block.clone(), settings_for(method, bur));
  const int sinking = static_cast<int>(kDeep / kSpeed);
  times = servo_times(scene, 1, sinking + (smoke() ? 200 : 5000), [&](int i, const ServoTick&) {
    const int k = std::max(i - sinking, 0);
    const double angle = k * kSpeed / kCircle, radius = std::min(k * kSpeed / 10, kWiden);
    return Pose{
        {radius * std::cos(angle), radius * std::sin(angle), bur.half() + std::max(0.05e-3 - i * kSpeed, -kDeep)}};
  });
  times.erase(times.begin(), times.begin() + sinking);
  return total(scene.last.removed);
}

void cavity(benchmark::State& state, const haptics::Tool& bur, const std::string& method) {
  double removed = 0;
  set_times(state, least_of([&] {
              std::vector<double> times;
              removed = widen(bur, method, times);
              return times;
            }));
  std::vector<double> unused;
  const double reference = widen(bur, "\"offset\"", unused);
  state.counters["volume_against_offset_percent"] = 100 * std::abs(removed / reference - 1);
}

// ---- Implant surgery (paper S1): tool voxels of 0.06 mm.

using haptics::implant::Motion;

struct Phase {
  const char* name;
  const char* tool;  // JSON
  double pedal;
  double bed_mm;  // depth of the bed (drilled hole) at the start; 0: none
  Motion state;   // that the hand must produce
  /// Height of the head's centre in tick i, m. `half`: m, half the length of the head.
  double (*height)(int i, const ServoTick& last, double half);
};
constexpr const char* kDrill = R"({"name": "drill 4.2 mm", "shape": "cylinder", "diameter_mm": 4.2, "length_mm": 12,
    "implant": {"kind": "drill", "ability": {"end": 1, "centre": 1}, "thrust_ratio": 12, "speed_rpm": 400}})";
constexpr const char* kTap = R"({"name": "tap 4.8 mm", "shape": "cylinder", "diameter_mm": 4.8, "length_mm": 12,
    "implant": {"kind": "tap", "thread": {"pitch_mm": 0.8, "core_mm": 4.2}, "top_speed_rpm": 15}})";
const Phase kPhases[] = {
    {"a drill slides on the bone", kDrill, 0, 0, Motion::kFree,
     [](int i, const ServoTick&, double half) { return half - std::min(0.5e-3, 2e-6 * i); }},
    {"a drill deepens a bed", kDrill, 1, 8, Motion::kDrilling,
     [](int i, const ServoTick& last, double half) { return (i == 0 ? half - 7.95e-3 : last.X_WG.p.z) - 0.7e-3; }},
    {"a drill slides in a bed", kDrill, 0, 8, Motion::kSliding,
     [](int i, const ServoTick&, double half) { return half - 7e-3 - 0.9e-3 * std::sin(0.003 * i); }},
    {"a tap cuts a thread", kTap, 1, 10, Motion::kScrewing,
     [](int i, const ServoTick& last, double half) { return i == 0 ? half - 6e-3 : last.X_WG.p.z - 0.3e-3; }},
};

void implant(benchmark::State& state, const Phase& phase) {
  haptics::ServoSettings settings = settings_for("\"implant\"", haptics::read_tool(Json::parse(phase.tool, "bench")));
  settings.stiffness = 3000;
  settings.spindle.free_speed = 0.8 * kKrpm;
  MaterialTable bone;
  bone.fill({1000, 0.5e9, 0.2, 0.15, 2150, dvec3(0.8)});
  std::string solid = R"({"box": {"center_mm": [0, 0, -8], "size_mm": [12, 12, 16]}})";
  if (phase.bed_mm > 0) {
    solid = fmt::format(R"({{"difference": [{}, {{"cylinder": {{"radius_mm": 2.1, "height_mm": {}}}}}]}})", solid,
                        2 * phase.bed_mm);
    settings.method = haptics::read_contact_method(Json::parse(
        fmt::format(
            R"({{"implant": {{"beds": [{{"entry_mm": [0, 0, 0], "axis": [0, 0, -1], "depth_mm": {}, "diameter_mm": 4.2}}]}}}})",
            phase.bed_mm),
        "bench"));
  }
  const TissueVolume volume(tissue(fmt::format(R"([{{"tissue": "cancellous_bone", "solid": {}}}])", solid), 0.15));
  std::uint32_t ended = 0;
  set_times(state, least_of([&] {
              HapticBench scene(volume.clone(), settings, bone);
              const double half = settings.tool.half();
              const auto times =
                  servo_times(scene, phase.pedal, smoke() ? 300 : 5000, [&](int i, const ServoTick& last) {
                    return Pose{{0, 0, phase.height(i, last, half)}};
                  });
              ended = scene.last.level;
              return times;
            }));
  require(ended == static_cast<std::uint32_t>(phase.state), std::string("the motion of the phase: ") + phase.name);
}

}  // namespace

void add_cases() {
  for (const std::size_t n :
       smoke() ? std::vector<std::size_t>{2000} : std::vector<std::size_t>{10'000, 36'000, 300'000}) {
    const std::string of = fmt::format("packing/{} spheres/", n);
    add(of + "fill a ball", [=](auto& state) { pack(state, n); });
    add(of + "direction of the surface", [=](auto& state) { pack_normal(state, n); });
    add(of + "cut a ball", [=](auto& state) { pack_cut(state, n); });
    add(of + "ream a socket", [=](auto& state) { ream(state, n); });
  }
  const std::vector<std::size_t> sizes =
      smoke() ? std::vector<std::size_t>{7'000} : std::vector<std::size_t>{13'000, 53'000, 212'000};
  const std::pair<const char*, const char*> methods[] = {{"mesh_lod", R"({"mesh_lod": {"levels": [2000000]}})"},
                                                         {"vertex", R"({"vertex": {"edge_mm": 0.1}})"}};
  const std::pair<const char*, haptics::Tool> burs[] = {{"round 1.2 mm", round_head(1.2e-3)},
                                                        {"cylinder 1 x 4 mm", head(HeadShape::kCylinder, 1e-3, 4e-3)}};
  for (const auto& [name, method] : methods) {
    for (const std::size_t n : sizes)
      for (const bool cuts : {false, true})
        add(fmt::format("{}/{} vertices/{} the arch", name, n, cuts ? "cut" : "slide on"),
            [=, method = std::string(method)](auto& state) { on_arch(state, method, n, cuts); });
    for (const auto& [bur, tool] : burs)
      add(fmt::format("{}/widen a cavity/{}", name, bur),
          [=, tool = tool, method = fmt::format("\"{}\"", name)](auto& state) { cavity(state, tool, method); });
  }
  for (const Phase& phase : kPhases)
    add(std::string("implant/") + phase.name, [&phase](auto& state) { implant(state, phase); });
}

}  // namespace typodont::bench
