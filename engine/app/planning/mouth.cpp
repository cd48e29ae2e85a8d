#include "engine/app/planning/mouth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/surface_solver.h"
#include "engine/base/error.h"
#include "engine/base/lower_case.h"
#include "engine/base/units.h"
#include "haptics/import/fuse.h"
#include "haptics/import/mesh_tissue.h"

namespace typodont {

namespace {

/// One scan. Its distance field is computed only if there is a bite scan.
struct Jaw {
  std::string name;
  haptics::IntraoralScan scan;
  haptics::TissueMesh surface;
  haptics::DenseTissue field;
  Pose X_BK;  // this scan's pose in frame B of the bite scan
  calibration::SurfaceRegistration fit;
};

dvec3 middle_of(const haptics::TissueMesh& mesh) {
  dvec3 sum(0);
  for (const dvec3& p : mesh.vertices) sum += p / static_cast<double>(mesh.vertices.size());
  return sum;
}

/// Registers the bite scan to the jaws, in two rounds. Each point of the bite scan is compared with the nearest jaw.
void register_bite(const std::filesystem::path& file, double unit, std::vector<Jaw>& jaws) {
  constexpr double kPointSpacing = 0.25e-3;                 // m, distance between the points of the bite scan
  constexpr double kMinPoints = 2000, kMaxPoints = 40'000;  // smallest and largest number of the bite scan's points
  // In each of the two rounds: largest distance from a jaw at which a point of the bite scan is used, m.
  constexpr double kReach[] = {2.5e-3, 1e-3};
  // Fraction of the points near a jaw that must agree with it; some points belong to the other jaw's teeth.
  constexpr double kMinAgreement = 0.6;
  const haptics::TissueMesh bite = haptics::read_tissue_mesh(file, unit, Tissue::kEnamel).mesh;
  const double area = haptics::area_of(bite);
  const double count = std::clamp(area / (kPointSpacing * kPointSpacing), kMinPoints, kMaxPoints);
  const std::vector<haptics::ScanPoint> points = haptics::spread_points(bite, static_cast<std::size_t>(count));
  for (const double reach : kReach) {
    std::vector<std::vector<calibration::SurfacePoint>> of_jaw(jaws.size());
    for (const haptics::ScanPoint& p : points) {
      double nearest = reach;
      std::optional<std::size_t> jaw;
      for (std::size_t k = 0; k < jaws.size(); ++k) {
        const haptics::ToothField::Value at = haptics::ToothField(jaws[k].field).at(inverse(jaws[k].X_BK) * p.p_S);
        if (at.tooth && std::abs(at.distance) < nearest) nearest = std::abs(at.distance), jaw = k;
      }
      if (jaw) of_jaw[*jaw].push_back({p.p_S, p.n_S});
    }
    for (std::size_t k = 0; k < jaws.size(); ++k) {
      Jaw& jaw = jaws[k];
      const std::string place = fmt::format("{} on {}", file.filename().string(), jaw.name);
      constexpr std::size_t kEnough = 500;  // if fewer points are near a jaw, the registration is refused
      if (of_jaw[k].size() < kEnough) {
        throw Error(
            place, "",
            fmt::format("{:.0f} mm² of teeth within {:g} mm of each other",
                        static_cast<double>(of_jaw[k].size()) * area / count / kSquareMillimetre, reach / kMillimetre),
            "scans whose frames agree within 2 mm, as a scanner's software exports them, and a bite scan whose "
            "triangles face outward");
      }
      calibration::SurfaceOptions options;
      options.point_area = area / count;
      options.start_reach = reach;
      options.resolution = jaw.field.frame.voxel;
      options.min_agreement = kMinAgreement;
      const haptics::ToothField teeth(jaw.field);
      const auto field = [&](const dvec3& p_K) -> calibration::FieldSample {
        const haptics::ToothField::Value v = teeth.at(p_K);
        return {v.tooth, v.distance, v.gradient};
      };
      jaw.fit = calibration::register_surface(of_jaw[k], field, inverse(jaw.X_BK), options);
      jaw.X_BK = inverse(jaw.fit.X_DS);
    }
  }
  for (const Jaw& jaw : jaws) {
    if (!jaw.fit.distrust.empty())
      throw Error(fmt::format("{} on {}: {}", file.filename().string(), jaw.name, jaw.fit.distrust));
  }
}

}  // namespace

ImportedMouth import_mouth(const MouthFiles& files, const haptics::ImportOptions& options) {
  const bool arch = options.preset == haptics::ImportPreset::kArch;
  if (!arch && (files.bite || files.open != 0))
    throw Error(files.bite ? "--bite" : "--open-mm", "", "a --preset other than arch", "intraoral scans");
  const auto progress = [&](double done) {
    if (options.progress) options.progress(done);
  };
  ImportedMouth mouth;
  mouth.scans.resize(files.scans.size());
  if (arch) {
    // Voxel size and largest stored distance of the distance field of a scan, m.
    constexpr double kFieldVoxel = 0.25e-3, kFieldBand = 3e-3;
    std::vector<Jaw> jaws;
    for (const std::filesystem::path& file : files.scans) {
      haptics::IntraoralScan scan(file, options.mesh_unit);
      haptics::TissueMesh surface = scan.mesh();
      jaws.push_back({file.filename().string(), std::move(scan), std::move(surface), {}, {}, {}});
      if (!files.bite) continue;
      haptics::ImportOptions coarse = options;
      coarse.progress = {}, coarse.estimated = {};
      coarse.voxel = kFieldVoxel, coarse.band = kFieldBand;
      coarse.turn = glm::dmat3(1);
      jaws.back().field = haptics::import_tissue(file, coarse).tissue;
      progress(0.4 * static_cast<double>(jaws.size()) / static_cast<double>(files.scans.size()));
    }
    mouth.up = jaws[0].scan.up();
    double highest = -1e300;
    for (const dvec3& p : jaws[0].surface.vertices) {
      if (const double height = glm::dot(p, mouth.up); height > highest) highest = height, mouth.top = p;
    }
    if (files.bite) register_bite(*files.bite, options.mesh_unit, jaws);
    const Pose X_WB = inverse(jaws[0].X_BK);
    for (std::size_t k = 0; k < jaws.size(); ++k) {
      MouthScan& scan = mouth.scans[k];
      if (files.bite) {
        const calibration::SurfaceRegistration& fit = jaws[k].fit;
        scan.fit = BiteFit{fit.median, fit.most_of, fit.predicted_error, fit.area};
        if (k > 0) scan.X_WK = X_WB * jaws[k].X_BK;
        const dvec3 middle = middle_of(jaws[k].surface);
        scan.moved = glm::length(scan.X_WK * middle - middle);
      }
      if (glm::dot(scan.X_WK.rotate(jaws[k].scan.up()), mouth.up) < 0) scan.X_WK.p += files.open * mouth.up;
    }
  }
  std::vector<haptics::PlacedMesh> meshes;
  for (std::size_t k = 0; k < files.scans.size(); ++k) meshes.push_back({files.scans[k], mouth.scans[k].X_WK});
  haptics::ImportOptions watched = options;
  const double from = files.bite ? 0.5 : 0;
  watched.progress = [&](double done) { progress(from + (1 - from) * done); };
  mouth.imported = haptics::import_meshes(meshes, watched);
  mouth.up = options.turn * mouth.up, mouth.top = options.turn * mouth.top;
  std::vector<std::string>& notes = mouth.imported.report.notes;
  for (std::size_t k = 0; k < mouth.scans.size(); ++k) {
    const MouthScan& scan = mouth.scans[k];
    if (!scan.fit) continue;
    notes.push_back(
        fmt::format("{}: {:.0f} mm² of the bite scan lie {:.3f} mm (median) and {:.3f} mm (95 %) from its surface; {}",
                    files.scans[k].filename().string(), scan.fit->area / kSquareMillimetre,
                    scan.fit->median / kMillimetre, scan.fit->most_of / kMillimetre,
                    k == 0 ? "the other scans are placed relative to it"
                           : fmt::format("moved by {:.3f} mm", scan.moved / kMillimetre)));
  }
  if (const double overlap = mouth.imported.report.overlap / kCubicMillimetre; overlap > 0)
    notes.push_back(fmt::format("the meshes overlap by {:.2f} mm³, where they become one body", overlap));
  return mouth;
}

MouthFiles mouth_files(const std::vector<std::filesystem::path>& meshes) {
  MouthFiles files;
  for (const std::filesystem::path& mesh : meshes) {
    const std::string name = lower_case(mesh.stem().string());
    if (name.find("bite") == std::string::npos) {
      files.scans.push_back(mesh);
    } else if (files.bite) {
      throw Error(mesh.string(), "", "a second bite scan", "one file with \"bite\" in its name");
    } else {
      files.bite = mesh;
    }
  }
  if (files.scans.empty()) throw Error("INPUT", "", "only a bite scan", "a scan of a jaw");
  return files;
}

}  // namespace typodont
