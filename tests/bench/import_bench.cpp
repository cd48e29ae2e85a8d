// Processor time and peak memory of the import of scans and meshes.
#include <malloc.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>

#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "tests/bench/bench.h"
#include "tests/support/mesh_shapes.h"

namespace typodont::bench {

namespace {

namespace fs = std::filesystem;

/// Memory of this process in bytes, by a key of /proc/self/status.
double memory(std::string_view key) {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(key)) return 1024 * std::strtod(line.c_str() + key.size(), nullptr);
  return std::nan("");
}

/// Writes a CT of a head: a skull that is open below. Hounsfield units plus 1024, with noise.
void write_head(const fs::path& file, const glm::ivec3& size) {
  const dvec3 voxel(230.0 / size.x, 230.0 / size.y, smoke() ? 1.5 : 0.45);
  std::ofstream out(file, std::ios::binary);
  out << fmt::format(
      "NRRD0004\ntype: short\ndimension: 3\nsizes: {} {} {}\nspacings: {} {} {}\nendian: little\nencoding: raw\n\n",
      size.x, size.y, size.z, voxel.x, voxel.y, voxel.z);
  std::minstd_rand random(1);
  std::vector<std::int16_t> row(static_cast<std::size_t>(size.x));
  const dvec3 half = 0.5 * dvec3(size) * voxel;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const dvec3 q = (dvec3(x, y, z) * voxel - half) / std::min(half.x, half.y);
        const double d = std::sqrt(q.x * q.x * 1.4 + q.y * q.y + q.z * q.z * 0.6) +
                         0.01 * std::sin(25 * q.x) * std::sin(19 * q.y + 4 * q.z);
        const int hu = d > 0.85 ? -1000 : d > 0.74 ? 30 : d > 0.71 ? 1300 : d > 0.67 ? 500 : d > 0.64 ? 1200 : 40;
        row[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(hu + 1024 + static_cast<int>(random() % 70) - 35);
      }
      out.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(2 * row.size()));
    }
}

void write_ball(const fs::path& file, double radius_mm) {
  const haptics::TissueMesh mesh = test::ball(dvec3(radius_mm), 2);
  std::ofstream out(file);
  for (const dvec3& p : mesh.vertices) out << fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const glm::uvec3& t : mesh.triangles) out << fmt::format("f {} {} {}\n", t.x + 1, t.y + 1, t.z + 1);
}

void import(benchmark::State& state, const char* name, const std::function<void(const fs::path&)>& write,
            double voxel_mm) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / name;
  write(file);
  haptics::ImportOptions options;
  options.greys = false;
  options.preset = haptics::ImportPreset::kBone;
  if (voxel_mm > 0) options.voxel = voxel_mm * kMillimetre;
  malloc_trim(0);  // memory of earlier cases does not count
  const double before = memory("VmRSS:"), start = cpu_seconds(RUSAGE_SELF);
  std::ofstream("/proc/self/clear_refs") << "5";
  const haptics::ImportReport report = haptics::import_tissue(file, options).report;
  set_time(state, 1e9 * (cpu_seconds(RUSAGE_SELF) - start));
  state.counters["peak_MB"] = std::max(memory("VmHWM:") - before, 0.0) * 1e-6;
  state.counters["estimated_MB"] = report.memory * 1e-6;
}

}  // namespace

void add_cases() {
  for (const glm::ivec3& size : smoke() ? std::vector<glm::ivec3>{{128, 128, 40}}
                                        : std::vector<glm::ivec3>{{256, 256, 140}, {512, 512, 140}, {512, 512, 512}})
    add(
        fmt::format("CT of a head/{} x {} x {}", size.x, size.y, size.z),
        [=](benchmark::State& state) {
      import(state, "head.nrrd", [&](const fs::path& file) { write_head(file, size);
        },
        0);
});
for (const double voxel_mm : smoke() ? std::vector{1.0} : std::vector{0.5, 0.3})
  add(
      fmt::format("mesh of 80 mm/voxel {:g} mm", voxel_mm),
      [=](benchmark::State& state) {
      import(state, "ball.obj", [](const fs::path& file) { write_ball(file, 40);
      },
      voxel_mm);
});
}

}  // namespace typodont::bench
