#include "engine/app/planning/scan_fusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

// Standard deviation of a picked point along each axis, m.
constexpr double kClickNoise = 0.5e-3;
constexpr double kPointSpacing = 0.25e-3;  // m, distance between registration points
constexpr double kMinPoints = 2000, kMaxPoints = 40000;

const glm::vec3 kScanColor(225, 205, 190), kToothColor(240, 230, 200), kBoneColor(150, 170, 155), kUnknown(120);

calibration::RegistrationResult register_picks(const std::vector<dvec3>& points_S, const std::vector<dvec3>& points_C,
                                               const std::string& place) {
  if (points_S.size() < ScanFusion::kMinPairs) {
    throw Error(place, "", fmt::format("{} pairs", points_S.size()), "three pairs of points or more, not on one line");
  }
  calibration::RegistrationOptions options;
  options.known_sigma = kClickNoise;
  calibration::RegistrationResult start = calibration::register_points(points_S, points_C, options);
  // Rejects only gross errors, because register_surfaces() checks the refined pose.
  const calibration::Defect defect = start.degeneracy.defect;
  if (defect != calibration::Defect::kNone && defect != calibration::Defect::kNoise) {
    throw Error(place, "",
                fmt::format("pairs that do not give a pose (H: the scan, D: the CT): {}", start.degeneracy.reason),
                "three pairs or more of the same points in scan and CT, in mm and not on one line");
  }
  if (!start.rivals.empty()) {
    throw Error(place, "",
                fmt::format("{} pairs that agree on one pose and {} on another", start.inliers.size(),
                            start.rivals.front().pairs.size()),
                "pairs of the same points in scan and CT");
  }
  return start;
}

calibration::SurfaceRegistration register_surfaces(const haptics::IntraoralScan& scan, const haptics::DenseTissue& ct,
                                                   const Pose& X_CS_start, const std::string& file) {
  calibration::SurfaceOptions options;
  const double count = std::clamp(scan.area() / (kPointSpacing * kPointSpacing), kMinPoints, kMaxPoints);
  std::vector<calibration::SurfacePoint> points;
  for (const haptics::ScanPoint& p : scan.points(static_cast<std::size_t>(count))) points.push_back({p.p_S, p.n_S});
  options.point_area = scan.area() / static_cast<double>(points.size());
  options.start_reach = std::min(options.start_reach, 0.95 * ct.band);
  options.resolution = ct.frame.voxel;
  const haptics::ToothField teeth(ct);
  const auto field = [&](const dvec3& p_C) -> calibration::FieldSample {
    const haptics::ToothField::Value v = teeth.at(p_C);
    return {v.tooth, v.distance, v.gradient};
  };
  calibration::SurfaceRegistration fine = calibration::register_surface(points, field, X_CS_start, options);
  if (!fine.distrust.empty()) throw Error(fmt::format("{}: fine registration: {}", file, fine.distrust));
  return fine;
}

bool is_of_tooth(Tissue t) {
  return t == Tissue::kEnamel || t == Tissue::kDentin || t == Tissue::kCaries || t == Tissue::kAmalgam ||
         t == Tissue::kComposite;
}

/// Colour of a distance: green up to 0.1 mm, yellow at 0.3 mm, red from 0.6 mm.
glm::vec3 distance_color(double distance) {
  const double mm = std::abs(distance) / kMillimetre;
  const glm::vec3 good(90, 200, 120), fair(240, 210, 80), bad(230, 80, 70);
  if (mm < 0.3) return glm::mix(good, fair, static_cast<float>(std::clamp((mm - 0.1) / 0.2, 0.0, 1.0)));
  return glm::mix(fair, bad, static_cast<float>(std::clamp((mm - 0.3) / 0.3, 0.0, 1.0)));
}

}  // namespace

ScanRegistration register_scan(const haptics::IntraoralScan& scan, const haptics::DenseTissue& ct,
                               const std::vector<dvec3>& points_S, const std::vector<dvec3>& points_C,
                               const std::string& place, const std::string& file) {
  ScanRegistration registration;
  registration.start = register_picks(points_S, points_C, place);
  registration.fine = register_surfaces(scan, ct, registration.start.X_DH, file);
  return registration;
}

ScanFusion::ScanFusion(std::shared_ptr<const haptics::DenseTissue> ct, const std::filesystem::path& file, double unit)
    : ct_(std::move(ct)), name_(file.filename().string()), scan_(file, unit), scan_mesh_(scan_.mesh()) {
  haptics::TissueMesh ct_mesh = haptics::TissueVolume(*ct_).extract_mesh();
  std::vector<glm::vec3> ct_colors;
  for (const Tissue t : ct_mesh.tissue) ct_colors.push_back(is_of_tooth(t) ? kToothColor : kBoneColor);
  views_[kScan] = SurfacePicture(scan_mesh_, std::vector<glm::vec3>(scan_mesh_.triangles.size(), kScanColor));
  // The view shows the scan's outer side: it looks against the mean normal.
  dvec3 normal(0);
  for (const glm::uvec3& t : scan_mesh_.triangles)
    normal += glm::cross(scan_mesh_.vertices[t.y] - scan_mesh_.vertices[t.x],
                         scan_mesh_.vertices[t.z] - scan_mesh_.vertices[t.x]);
  const double length = glm::length(normal);
  const dvec3 look = length > 0 ? -normal / length : dvec3(0, 0, -1);
  views_[kScan].look_along(look, std::abs(look.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0));
  // The view looks from the teeth towards the bone, so that it shows the crowns.
  dvec3 tooth(0), all(0);
  double teeth = 0;
  for (std::size_t t = 0; t < ct_mesh.triangles.size(); ++t) {
    const dvec3& p = ct_mesh.vertices[ct_mesh.triangles[t].x];
    all += p;
    if (is_of_tooth(ct_mesh.tissue[t])) tooth += p, teeth += 1;
  }
  const double below = teeth > 0 && !ct_mesh.triangles.empty()
                           ? tooth.z / teeth - all.z / static_cast<double>(ct_mesh.triangles.size())
                           : 1;
  ct_picture_ = SurfacePicture(std::move(ct_mesh), std::move(ct_colors));
  views_[kCt] = ct_picture_;
  views_[kCt].look_along({0, 0, below < 0 ? 1 : -1}, {0, 1, 0});
}

void ScanFusion::show_ct(const SurfacePicture& surfaces) {
  SurfacePicture fresh = surfaces;
  fresh.look_like(views_[kCt]);
  views_[kCt] = std::move(fresh);
}

bool ScanFusion::pick(Side side, const dvec2& place) {
  if (points_[side].size() > points_[1 - side].size()) return false;
  const std::optional<dvec3> p = views_[side].at(place);
  if (!p) return false;
  if (registration_) {
    registration_.reset();
    show_ct(ct_picture_);
  }
  points_[side].push_back(*p);
  order_.push_back(side);
  return true;
}

void ScanFusion::drop_last() {
  if (order_.empty()) return;
  points_[order_.back()].pop_back();
  order_.pop_back();
  if (!registration_) return;
  registration_.reset();
  show_ct(ct_picture_);
}

ScanRegistration ScanFusion::registered() const {
  ScanRegistration found = register_scan(scan_, *ct_, points_[kScan], points_[kCt], "points", name_);
  haptics::TissueMesh laid = scan_mesh_;
  for (dvec3& p : laid.vertices) p = found.fine.X_DS * p;
  const haptics::ToothField teeth(*ct_);
  std::vector<glm::vec3> colors;
  for (const glm::uvec3& t : laid.triangles) {
    const haptics::ToothField::Value v = teeth.at((laid.vertices[t.x] + laid.vertices[t.y] + laid.vertices[t.z]) / 3.0);
    colors.push_back(v.tooth ? distance_color(v.distance - found.fine.offset) : kUnknown);
  }
  found.picture = ct_picture_;
  found.picture.add(laid, colors);
  return found;
}

void ScanFusion::show(ScanRegistration registration) {
  registration_ = std::move(registration);
  show_ct(registration_->picture);
}

haptics::Fused ScanFusion::fused(Progress& progress) const {
  haptics::FuseOptions options;
  options.progress = [&](double done) { progress.at(done); };
  return haptics::fuse(*ct_, scan_, registration_->fine.X_DS, options);
}

}  // namespace typodont
