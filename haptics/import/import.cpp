#include "haptics/import/import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "engine/base/error.h"
#include "engine/base/lower_case.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/dense_tissue.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/scan.h"

namespace typodont::haptics {

namespace importing {

constexpr double kMaxResult = 4e8;  // largest number of voxels of an imported volume

static double voxels_in(const dvec3& extent, double voxel) {
  return (extent.x / voxel) * (extent.y / voxel) * (extent.z / voxel);
}

bool result_size_fits(const dvec3& extent, double voxel) {
  return voxels_in(extent, voxel) <= kMaxResult;
}

void check_result_size(const dvec3& extent, double voxel) {
  if (result_size_fits(extent, voxel)) return;
  const double count = voxels_in(extent, voxel);
  throw Error("--voxel-mm", "",
              fmt::format("{:g}: {:.3g} voxels for {:.1f} x {:.1f} x {:.1f} mm", voxel / kMillimetre, count,
                          extent.x / kMillimetre, extent.y / kMillimetre, extent.z / kMillimetre),
              fmt::format("at most {:.3g} voxels: at least {:.3g} mm", kMaxResult,
                          voxel * std::cbrt(count / kMaxResult) / kMillimetre));
}

double free_memory() {
  double free = 1e18;
  std::ifstream in("/proc/meminfo");
  for (std::string line; std::getline(in, line);) {
    constexpr std::string_view kKey = "MemAvailable:";
    if (line.starts_with(kKey)) free = 1024 * std::strtod(line.c_str() + kKey.size(), nullptr);
  }
  // If the address space is limited (ulimit -v), reserved memory counts too.
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    double pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const double left = static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGESIZE));
    free = std::min(free, std::max(0.0, left));
  }
  return free;
}

void require_memory(double bytes, const ImportOptions& options, ImportReport& report) {
  report.memory = std::max(report.memory, bytes);
  const double most = options.memory.value_or(free_memory());
  if (bytes > most) {
    throw Error(options.memory ? "--memory-mb" : "memory", "",
                fmt::format("about {:.0f} MB for this work", bytes * 1e-6),
                fmt::format("at most {:.0f} MB{}: a coarser --voxel-mm, or a smaller piece of the scan", most * 1e-6,
                            options.memory ? "" : ", which are free"));
  }
  if (options.estimated) options.estimated(bytes);
}

// Fraction of dentin on the crown's surface. In each sector around the tooth's axis, the crown ends where enamel ends.
static std::optional<double> false_dentin_share(const DenseTissue& t) {
  std::vector<glm::ivec3> skin;
  dvec3 all(0), enamel(0);
  double n_all = 0, n_enamel = 0;
  for_each_voxel_between(glm::ivec3(1), t.size - 2, [&](int x, int y, int z) {
    const std::size_t i = t.at(x, y, z);
    if (t.distance[i] > 0) return;
    all += dvec3(x, y, z), n_all += 1;
    if (t.tissue[i] == Tissue::kEnamel) enamel += dvec3(x, y, z), n_enamel += 1;
    if (t.distance[t.at(x + 1, y, z)] > 0 || t.distance[t.at(x - 1, y, z)] > 0 || t.distance[t.at(x, y + 1, z)] > 0 ||
        t.distance[t.at(x, y - 1, z)] > 0 || t.distance[t.at(x, y, z + 1)] > 0 || t.distance[t.at(x, y, z - 1)] > 0) {
      skin.push_back({x, y, z});
    }
  });
  if (n_enamel < 1 || n_all < 1) return std::nullopt;
  all /= n_all;
  enamel /= n_enamel;
  const dvec3 up = enamel - all;
  // Enamel and tissue have nearly the same centre: enamel is on all sides, so the scan shows no root.
  if (glm::length(up) * t.frame.voxel < 0.2e-3) {
    double dentin = 0;
    for (const glm::ivec3& p : skin) dentin += t.tissue[t.at(p.x, p.y, p.z)] != Tissue::kEnamel;
    return skin.empty() ? std::nullopt : std::optional(dentin / static_cast<double>(skin.size()));
  }
  const dvec3 axis = glm::normalize(up);
  const dvec3 u = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 v = glm::cross(axis, u);
  constexpr int kSectors = 48;
  std::vector<double> heights[kSectors];
  const auto sector = [&](const dvec3& r) {
    return std::clamp(static_cast<int>((std::atan2(glm::dot(r, v), glm::dot(r, u)) / kPi + 1) * 0.5 * kSectors), 0,
                      kSectors - 1);
  };
  for (const glm::ivec3& p : skin) {
    const dvec3 r = dvec3(p) - enamel;
    if (t.tissue[t.at(p.x, p.y, p.z)] == Tissue::kEnamel) heights[sector(r)].push_back(glm::dot(r, axis));
  }
  double margin[kSectors];
  for (int s = 0; s < kSectors; ++s) {
    if (heights[s].empty()) {
      margin[s] = 1e300;
      continue;
    }
    margin[s] = nth(heights[s], heights[s].size() / 50) + 0.3e-3 / t.frame.voxel;
  }
  double crown = 0, dentin = 0;
  for (const glm::ivec3& p : skin) {
    const dvec3 r = dvec3(p) - enamel;
    if (glm::dot(r, axis) < margin[sector(r)]) continue;
    crown += 1;
    dentin += t.tissue[t.at(p.x, p.y, p.z)] == Tissue::kDentin;
  }
  return crown > 0 ? std::optional(dentin / crown) : std::nullopt;
}

void measure(Imported& imported, ImportPreset preset) {
  const DenseTissue& t = imported.tissue;
  ImportReport& report = imported.report;
  report.voxel = t.frame.voxel;
  report.size = t.size;
  report.volume.fill(0);
  report.hardness.fill(0);
  dvec3 lo(1e300), hi(-1e300);
  const double h = t.frame.voxel;
  for_each_voxel(t.size, [&](const glm::ivec3& p) {
    const std::size_t i = t.at(p.x, p.y, p.z);
    const double d = t.distance[i];
    if (d > h) return;
    // Fraction of the voxel inside the tissue, as if the surface were a plane at the distance d from its centre.
    const double fraction = std::clamp(0.5 - d / h, 0.0, 1.0);
    const auto tissue = static_cast<std::size_t>(t.tissue[i]);
    report.volume[tissue] += fraction * h * h * h;
    if (!t.hardness.empty()) report.hardness[tissue] += fraction * h * h * h * hardness_fraction(t.hardness[i]);
    if (d > 0) return;
    // The bounding box must contain the surface point between this voxel and each neighbour outside the tissue.
    for (int a = 0; a < 3; ++a) {
      for (const int side : {-1, 1}) {
        glm::ivec3 q = p;
        q[a] += side;
        if (q[a] < 0 || q[a] >= t.size[a]) continue;
        const double e = t.distance[t.at(q.x, q.y, q.z)];
        if (e <= 0) continue;
        const double at = p[a] + side * d / (d - e);
        lo[a] = std::min(lo[a], at);
        hi[a] = std::max(hi[a], at);
      }
    }
  });
  for (std::size_t i = 0; i < report.hardness.size(); ++i) {
    if (report.volume[i] > 0) report.hardness[i] /= report.volume[i];
  }
  report.lo = t.frame.to_world(lo);
  report.hi = t.frame.to_world(hi);
  const dvec3 extent = report.hi - report.lo;
  report.height = std::max({extent.x, extent.y, extent.z});
  if (preset == ImportPreset::kTooth) report.false_dentin = false_dentin_share(t);
}

Imported completed(Imported imported, const ImportOptions& options) {
  measure(imported, options.preset);
  const ImportReport& report = imported.report;
  imported.tissue.place = {{dvec3(0), glm::normalize(glm::quat_cast(report.world_rotation))},
                           patient_axes(report.space)};
  turn(imported, options.turn);
  if (options.progress) options.progress(1);
  return imported;
}

}  // namespace importing

const std::vector<std::string>& scan_endings() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> endings;
    for (const importing::ScanFormat& format : importing::scan_formats())
      endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
  }();
  return all;
}

const std::vector<std::string>& mesh_endings() {
  static const std::vector<std::string> all{".stl", ".ply", ".obj", ".gltf", ".glb", ".3mf"};
  return all;
}

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string name = lower_case(file.filename().string());
  return std::ranges::any_of(mesh_endings(), [&](const std::string& ending) { return name.ends_with(ending); });
}

Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options) {
  const auto check = [](const char* name, double value, double least, double most) {
    if (value >= least && value <= most) return;
    throw Error(name, "", fmt::format("{:g}", value / kMillimetre),
                fmt::format("{:g} to {:g} mm", least / kMillimetre, most / kMillimetre));
  };
  if (options.voxel) check("--voxel-mm", *options.voxel, 5e-6, 2e-3);
  check("--band-mm", options.band, 0.1e-3, 20e-3);
  for (const ImportPart& part : options.parts) {
    if (!is_mesh_file(part.file))
      throw Error(part.file.string(), "--part", "no mesh",
                  fmt::format("a closed mesh ({})", fmt::join(mesh_endings(), " ")));
  }
  const bool arch = options.preset == ImportPreset::kArch;
  if (arch && (!options.parts.empty() || !is_mesh_file(file))) {
    throw Error("--preset", "", "arch",
                fmt::format("tooth or bone, or a mesh of an arch ({})", fmt::join(mesh_endings(), " ")));
  }
  if (options.preset == ImportPreset::kJaw && (!options.parts.empty() || is_mesh_file(file)))
    throw Error("--preset", "", "jaw", "a scan (tooth or bone for a mesh, which has no greys)");
  if (options.region && (!options.parts.empty() || is_mesh_file(file)))
    throw Error("--region-mm", "", options.parts.empty() ? file.string() : "--part", "a scan");
  if (options.spacing) {
    for (int a = 0; a < 3; ++a) check("--spacing-mm", (*options.spacing)[a], 1e-6, 10e-3);
  }
  if (const auto& h = options.hardness) {
    if (!(h->own > h->zero) || !(h->dense.value_or(h->own) > h->zero))
      throw Error("--hardness-greys", "", fmt::format("{:g},{:g}", h->zero, h->own), "rising greys");
    if (!options.parts.empty() || is_mesh_file(file))
      throw Error("--hardness-greys", "", file.string(), "a scan: a mesh has no greys");
  }
  Imported imported = !options.parts.empty() ? importing::import_parts(options)
                      : arch                 ? importing::import_arch(file, options)
                      : is_mesh_file(file)   ? importing::import_mesh(file, options)
                                             : importing::import_scan(file, options);
  return importing::completed(std::move(imported), options);
}

}  // namespace typodont::haptics
