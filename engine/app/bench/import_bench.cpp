// Measures the cost of an import: processor time and peak memory per voxel, for scans and meshes of clinical sizes.
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "engine/app/bench/parts.h"
#include "engine/app/planning/scan_review.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/import/scan_volume.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

/// Measures the memory of this process in bytes: the present resident size, and the largest resident size since the
/// last call of start().
class Memory {
 public:
  static void start() { std::ofstream("/proc/self/clear_refs") << "5"; }
  static double most() { return field("VmHWM:"); }
  static double now() { return field("VmRSS:"); }

 private:
  static double field(std::string_view key) {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with(key)) return 1024 * std::strtod(line.c_str() + key.size(), nullptr);
    }
    return BenchRow::kNone;
  }
};

/// Writes a simulated CT of a head: a skull that is open below, with the arch of a lower jaw in front. Grey values are
/// Hounsfield units plus 1024, with noise of 20 HU.
void write_head(const fs::path& file, const glm::ivec3& size, const dvec3& voxel_mm) {
  std::ofstream out(file, std::ios::binary);
  out << fmt::format(
      "NRRD0004\ntype: short\ndimension: 3\nsizes: {} {} {}\nspace: left-posterior-superior\nspace directions: "
      "({},0,0) "
      "(0,{},0) (0,0,{})\nendian: little\nencoding: raw\n\n",
      size.x, size.y, size.z, voxel_mm.x, voxel_mm.y, voxel_mm.z);
  std::minstd_rand random(1);
  std::vector<std::int16_t> slice(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
  const dvec3 half = 0.5 * dvec3(size) * voxel_mm;
  const double scale = std::min(half.x, half.y);
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const dvec3 q = (dvec3(x, y, z) * voxel_mm - half) / scale;
        const double r = std::sqrt(q.x * q.x * 1.4 + q.y * q.y + q.z * q.z * 0.6);
        const double ripple = 0.01 * std::sin(25 * q.x) * std::sin(19 * q.y + 4 * q.z);
        const double d = r + ripple;
        const double hu = d > 0.85 ? -1000 : d > 0.74 ? 30 : d > 0.71 ? 1300 : d > 0.67 ? 500 : d > 0.64 ? 1200 : 40;
        slice[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x)] =
            static_cast<std::int16_t>(hu + 1024 + static_cast<int>(random() % 70) - 35);
      }
    }
    out.write(reinterpret_cast<const char*>(slice.data()),
              static_cast<std::streamsize>(slice.size() * sizeof slice[0]));
  }
}

/// Returns the grey value (Hounsfield units) of a lower jaw with fourteen teeth along half a circle. `q`: position in
/// mm, relative to the circle's centre.
double jaw_grey(const dvec3& q) {
  // kArch: radius of the circle, mm; kTeeth: number of teeth; kApart: angle between two teeth, rad
  constexpr double kArch = 25, kTeeth = 14, kApart = 4.0 / kTeeth * 0.7;
  const double angle = std::atan2(q.y, q.x), across = std::hypot(q.x, q.y) - kArch;
  // rad, angle of the tooth nearest to q, measured from the midline of the jaw
  const double nearest = kApart * std::round((angle - kPi / 2) / kApart - 0.5) + kApart * 0.5;
  const double along = kArch * (angle - kPi / 2 - nearest);
  const bool in_row = std::abs(nearest) < kApart * kTeeth / 2 && q.y > 0;
  const double out = std::hypot(across, along);
  if (in_row && q.z > 10) {
    const auto cap = [&](double wide, double high) {
      return out * out / (wide * wide) + (q.z - 14) * (q.z - 14) / (high * high) < 1;
    };
    if (cap(1, 2)) return 60;
    if (cap(2.2, 3.6)) return 1650;
    if (cap(3.2, 4.6)) return 2800;
  }
  if (in_row && q.z > -3 && q.z <= 10) {
    const double root = 2.2 * std::sqrt((q.z + 3) / 13);
    if (out < 0.5) return 60;
    if (out < root) return 1650;
    if (out < root + 0.3) return 50;
    if (out < root + 0.9) return 1500;
  }
  const double bone = std::hypot(across / 6, q.z / 10);
  if (q.y > 0 && bone < 1) {
    const double canal = std::hypot(across, q.z + 5);
    if (canal < 1.3) return 60;
    return bone > 0.75 || canal < 1.8 ? 1500 : 450;
  }
  return q.z > 11 ? -1000 : 50;
}

/// Writes a CT with noise and with voxels of `voxel` mm. `grey_at` returns the grey value at a position in mm. The
/// origin of this position lies in the scan, at the fractions `middle` of the scan's length along x, y and z.
template <class Grey>
void write_scan(const fs::path& file, const glm::ivec3& size, double voxel, const dvec3& middle, Grey grey_at) {
  std::ofstream out(file, std::ios::binary);
  out << fmt::format(
      "NRRD0004\ntype: short\ndimension: 3\nsizes: {} {} {}\nspacings: {} {} {}\nendian: little\nencoding: raw\n\n",
      size.x, size.y, size.z, voxel, voxel, voxel);
  std::minstd_rand random(1);
  std::vector<std::int16_t> row(static_cast<std::size_t>(size.x));
  const dvec3 centre = middle * dvec3(size) * voxel;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        // sum of the grey values at eight points of the voxel; a real CT also averages the grey values in a voxel
        // (partial-volume effect)
        double sum = 0;
        for (int k = 0; k < 8; ++k)
          sum += grey_at((dvec3(x, y, z) + 0.5 * dvec3(k & 1, k >> 1 & 1, k >> 2)) * voxel - centre);
        row[static_cast<std::size_t>(x)] =
            static_cast<std::int16_t>(std::lround(sum / 8) + static_cast<int>(random() % 140) - 70);
      }
      out.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(row.size() * sizeof row[0]));
    }
  }
}

/// Returns the grey value (Hounsfield units) of a hip. `q`: mm, relative to the centre of the joint. The femur's head
/// (radius 23 mm) lies in the socket of the pelvis, with cartilage of 3 mm between them. Neck and shaft point downwards
/// and outwards.
double hip_grey(const dvec3& q) {
  // mm. kHead: radius of the femur's head. kPlate: thickness of the dense bone at the surface of a bone.
  constexpr double kHead = 23, kPlate = 1.5;
  const auto bone = [](double depth, double plate) { return depth < plate ? 1200.0 : 350.0; };
  // Returns the depth (mm) of q below the surface of a rod from a to b with round ends; negative outside.
  const auto rod = [&](const dvec3& a, const dvec3& b, double radius) {
    const dvec3 along = b - a;
    const double t = std::clamp(glm::dot(q - a, along) / glm::dot(along, along), 0.0, 1.0);
    return radius - glm::length(q - a - t * along);
  };
  const double r = glm::length(q);
  const double head = kHead - r, neck = rod(dvec3(0), dvec3(40, 0, -35), 14);
  if (const double depth = std::max(head, neck); depth > 0) return bone(depth, kPlate);
  if (const double shaft = rod(dvec3(45, 0, -35), dvec3(45, 0, -160), 15); shaft > 0)
    return shaft < 5 ? 1500 : q.z > -60 ? 350 : -80;  // marrow of the shaft is fat
  // The socket is the part of a thick shell around the head that is open downwards and outwards. The wing of the pelvis
  // is a curved plate above it.
  const double open = glm::dot(q, glm::normalize(dvec3(1, 0, -0.7)));
  if (r > kHead + 3 && r < kHead + 15 && open < 8) return bone(std::min(r - kHead - 3, kHead + 15 - r), kPlate);
  const double wing = std::abs(q.x + 12 - 0.004 * q.y * q.y);
  if (wing < 6 && q.z > 25 && q.z < 95 && std::abs(q.y) < 60) return bone(6 - wing, kPlate);
  return std::hypot(q.x / 110, q.y / 95) < 1 ? 50 : -1000;
}

/// Writes a mesh of a ball that is as large as a bone. `radius`: mm.
void write_ball(const fs::path& file, double radius) {
  constexpr int kRings = 100;
  std::ofstream out(file);
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j < 2 * kRings; ++j) {
      const double a = kPi * i / kRings, b = kPi * j / kRings;
      out << fmt::format("v {} {} {}\n", radius * std::sin(a) * std::cos(b), radius * std::sin(a) * std::sin(b),
                         radius * std::cos(a));
    }
  }
  const auto at = [](int i, int j) { return 2 * kRings * i + j % (2 * kRings) + 1; };
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < 2 * kRings; ++j) {
      out << fmt::format("f {} {} {}\nf {} {} {}\n", at(i, j), at(i + 1, j), at(i, j + 1), at(i, j + 1), at(i + 1, j),
                         at(i + 1, j + 1));
    }
  }
}

void measure(std::vector<BenchRow>& rows, const std::string& name, const std::string& knob, double voxels,
             const std::function<haptics::Imported()>& import) {
  malloc_trim(0);  // returns freed memory to the system, so that memory of earlier test cases is not counted
  const double before = Memory::now(), start = cpu_seconds(RUSAGE_SELF);
  const auto began = std::chrono::steady_clock::now();
  Memory::start();
  double estimate = 0;
  {
    const haptics::Imported imported = import();
    estimate = imported.report.memory;
    if (voxels == 0) {
      const glm::dvec3 size(imported.report.size);
      voxels = size.x * size.y * size.z;
    }
  }
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const double seconds = cpu_seconds(RUSAGE_SELF) - start, bytes = Memory::most() - before;
  BenchRow row;
  row.name = name;
  row.knob = knob;
  row.error = bytes * 1e-6;
  row.error_unit = fmt::format("MB at most (estimated before: {:.0f}); CPU time {:.1f} s, duration {:.1f} s",
                               estimate * 1e-6, seconds, wall);
  row.time_ns = seconds * 1e9 / voxels;
  row.per = "voxel";
  row.size = voxels;
  row.size_unit = "voxels";
  rows.push_back(row);
}

}  // namespace

std::vector<BenchRow> bench_import(const BenchRun& run) {
  std::vector<BenchRow> rows;
  const fs::path folder = fs::temp_directory_path() / fmt::format("typodont_bench_import_{}", getpid());
  fs::create_directories(folder);
  struct Remove {
    const fs::path& folder;
    ~Remove() {
      std::error_code code;
      fs::remove_all(folder, code);
    }
  } const remove{folder};
  haptics::ImportOptions bone;
  bone.greys = false;  // no grey values are stored, as with `typodont import` without the option --preview
  bone.preset = haptics::ImportPreset::kBone;
  const std::vector<glm::ivec3> heads =
      run.quick ? std::vector<glm::ivec3>{{128, 128, 40}}
                : std::vector<glm::ivec3>{{256, 256, 140}, {512, 512, 140}, {512, 512, 512}};
  for (const glm::ivec3& size : heads) {
    const fs::path file = folder / "head.nrrd";
    const dvec3 voxel(230.0 / size.x, 230.0 / size.y, run.quick ? 0.45 * 140 / size.z : 0.45);
    write_head(file, size, voxel);
    const dvec3 count(size);
    measure(rows, "scan of a head", fmt::format("{} x {} x {}, {:.2g} mm", size.x, size.y, size.z, voxel.x),
            count.x * count.y * count.z, [&] { return haptics::import_tissue(file, bone); });
  }
  haptics::ImportOptions jaw;
  jaw.greys = false;
  jaw.preset = haptics::ImportPreset::kJaw;
  const fs::path jaw_file = folder / "jaw.nrrd";
  const auto in_words = [](const glm::ivec3& size, double voxel) {
    return fmt::format("{} x {} x {}, {:.2g} mm", size.x, size.y, size.z, voxel);
  };
  // Writes the scan of a jaw and measures its import. `voxel`: mm; `middle`: position of the jaw in the scan, as a
  // fraction of the scan's lengths.
  const auto measure_jaw = [&](const glm::ivec3& size, double voxel, const dvec3& middle) {
    write_scan(jaw_file, size, voxel, middle, jaw_grey);
    measure(rows, "cone beam CT of a lower jaw", in_words(size, voxel), static_cast<double>(size.x) * size.y * size.z,
            [&] { return haptics::import_tissue(jaw_file, jaw); });
  };
  if (!run.quick) measure_jaw(glm::ivec3(512), 0.16, dvec3(0.5, 0.3, 0.45));
  {
    const fs::path& file = jaw_file;
    const glm::ivec3 size = run.quick ? glm::ivec3(96, 64, 48) : glm::ivec3(280, 190, 130);
    const double voxel = 0.25 * 280 / size.x;  // mm, voxel size
    measure_jaw(size, voxel, dvec3(0.5, 0.2, 0.45));
    const std::string knob = in_words(size, voxel);
    const double all = static_cast<double>(size.x) * size.y * size.z;
    std::shared_ptr<const haptics::ScanVolume> scan;
    measure(rows, "the same in the window: read, and coarse labels", knob, all, [&] {
      scan = std::make_shared<const haptics::ScanVolume>(file, jaw);
      return scan->import(ScanReview(scan).request()->options);
    });
    ScanReview review(scan);
    const dvec3 extent = scan->hi() - scan->lo();
    review.set_region({scan->lo() + 0.3 * extent, scan->lo() + 0.7 * extent});
    measure(rows, "coarse labels while a wall is dragged", "a box of 40 %", all * std::pow(0.4, 3),
            [&] { return scan->import(review.request()->options); });
    measure(rows, "exact labels of the box", "a box of 40 %", all * std::pow(0.4, 3),
            [&] { return scan->import(review.options()); });
  }
  {
    const fs::path file = folder / "hip.nrrd";
    const glm::ivec3 size = run.quick ? glm::ivec3(64, 64, 80) : glm::ivec3(256, 256, 330);
    const double voxel = 0.7 * 256 / size.x;  // mm, voxel size
    write_scan(file, size, voxel, dvec3(0.4, 0.5, 0.6), hip_grey);
    measure(rows, "CT of a hip", fmt::format("{} x {} x {}, {:.2g} mm", size.x, size.y, size.z, voxel),
            static_cast<double>(size.x) * size.y * size.z, [&] { return haptics::import_tissue(file, bone); });
  }
  const fs::path ball = folder / "ball.obj";
  write_ball(ball, 40);
  for (const double mm : run.quick ? std::vector<double>{1.0} : std::vector<double>{0.5, 0.3}) {
    bone.voxel = mm * kMillimetre;
    measure(rows, "mesh of 80 mm", fmt::format("voxel {:g} mm", mm), 0,
            [&] { return haptics::import_tissue(ball, bone); });
  }
  return rows;
}

}  // namespace typodont
