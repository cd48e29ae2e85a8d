// Tests of fusing an intraoral scan of a jaw with the jaw's CT. The jaw is known exactly (synthetic,
// tests/support/jaw_phantom.h). Tested are the errors of pose and crowns, the parts that must stay unchanged, and which
// input is refused.
#include <gtest/gtest.h>

#include <random>

#include "calibration/surface_solver.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/fuse.h"
#include "haptics/tissue_volume.h"
#include "tests/support/fuse_phantom.h"

namespace typodont {
namespace {

using haptics::DenseTissue;
using haptics::TissueMesh;
using test::clicked;
using test::ct;
using test::jaw;
using test::JawPhantom;
using test::kGum;
using test::random_pose;
using test::scanned;
using test::true_surface;
using test::write_stl;

calibration::SurfaceRegistration registered(const haptics::IntraoralScan& scan, const DenseTissue& volume,
                                            const Pose& start) {
  constexpr std::size_t kPoints = 4000;
  std::vector<calibration::SurfacePoint> points;
  for (const haptics::ScanPoint& p : scan.points(kPoints)) points.push_back({p.p_S, p.n_S});
  const haptics::ToothField teeth(volume);
  calibration::SurfaceOptions options;
  options.point_area = scan.area() / static_cast<double>(points.size());
  options.resolution = volume.frame.voxel;
  return register_surface(
      points,
      [&](const dvec3& p) {
        const auto v = teeth.at(p);
        return calibration::FieldSample{v.tooth, v.distance, v.gradient};
      },
      start, options);
}

/// Returns the largest distance (mm) between the positions of the corners around the crowns.
double error_at_crowns(const Pose& found, const Pose& truth) {
  double most = 0;
  for (int k = 0; k < 8; ++k) {
    const dvec3 p = inverse(truth) * (dvec3(k & 1 ? 6 : 24, k & 2 ? 8 : 16, k & 4 ? 25 : 31) * kMillimetre);
    most = std::max(most, glm::length(found * p - truth * p) / kMillimetre);
  }
  return most;
}

struct Spread {
  double median, most_of;  // mm, 95 %
};
/// Returns the distance of the surface of a volume from the true crowns, where these are at least 1 mm above the gum.
Spread crown_error(const DenseTissue& t) {
  std::vector<double> errors;
  for (const dvec3& p : true_surface().vertices) {
    if (p.z > (kGum + 1) * kMillimetre) errors.push_back(std::abs(test::distance_at(t, p)) / kMillimetre);
  }
  std::ranges::sort(errors);
  return {errors[errors.size() / 2], errors[errors.size() * 95 / 100]};
}

TEST(ImportFuse, FromClicksOfOneMillimetreThePoseIsFoundWithinATwentiethOfAMillimetreAndItsErrorIsAsPredicted) {
  constexpr unsigned kSeeds = 5;
  double squares = 0, predicted = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937 random(seed);
    const Pose X_CS = random_pose(random, 2, 30e-3);
    const haptics::IntraoralScan scan(write_stl("scan.stl", scanned(X_CS, seed)), kMillimetre);
    const auto fine = registered(scan, ct(), clicked(X_CS, random));
    EXPECT_EQ(fine.distrust, "") << seed;
    EXPECT_LT(fine.median, 0.03e-3) << seed;
    EXPECT_GT(fine.agreement, 0.9) << seed;
    const double error = error_at_crowns(fine.X_DS, X_CS);
    EXPECT_LT(error, 0.05) << seed;
    squares += error * error / kSeeds;
    predicted += fine.predicted_error / kMillimetre / kSeeds;
  }
  // The error is the largest one at eight corners around the crowns, but the prediction is a mean over the crowns. So
  // the two may differ by a factor.
  EXPECT_LT(std::sqrt(squares), 3 * predicted);
  EXPECT_GT(std::sqrt(squares), 0.3 * predicted);
}

TEST(ImportFuse, AScanOfAnotherMouthIsNotTrusted) {
  // Uses the same teeth, but their crowns are 1.5 mm closer to each other and a tenth narrower.
  std::mt19937 random(5);
  const Pose X_CS = random_pose(random, 2, 30e-3);
  TissueMesh other = scanned(Pose{}, 5);
  const double middle = 0.5 * (JawPhantom::kTeeth[0] + JawPhantom::kTeeth[1]) * kMillimetre;
  for (dvec3& p : other.vertices) {
    p.x += (p.x < middle ? 1 : -1) * 0.75e-3;
    p.y = 12e-3 + 0.9 * (p.y - 12e-3) + 0.4e-3 * std::sin(p.x / 1.2e-3);
    p = inverse(X_CS) * p;
  }
  const haptics::IntraoralScan scan(write_stl("other.stl", other), kMillimetre);
  EXPECT_NE(registered(scan, ct(), clicked(X_CS, random)).distrust, "");
}

TEST(ImportFuse, CrownsBecomeAsSharpAsTheScanAndRootsStayExactlyAsTheyWere) {
  std::mt19937 random(3);
  const Pose X_CS = random_pose(random, 2, 30e-3);
  const haptics::IntraoralScan scan(write_stl("scan.stl", scanned(X_CS, 3)), kMillimetre);
  const auto fine = registered(scan, ct(), clicked(X_CS, random));
  ASSERT_EQ(fine.distrust, "");
  const haptics::Fused fused = fuse(ct(), scan, fine.X_DS, {});
  haptics::FuseOptions finer;
  finer.voxel = 0.15e-3;
  const haptics::Fused sharp = fuse(ct(), scan, fine.X_DS, finer);

  // The CT blurs the grooves of the crowns. The scan shows them, so the fused surface must be nearer to the truth.
  const Spread before = crown_error(ct()), same = crown_error(fused.tissue), fine_voxel = crown_error(sharp.tissue);
  EXPECT_GT(before.most_of, 0.12);
  EXPECT_LT(same.median, 0.01);
  EXPECT_LT(same.most_of, 0.06);
  EXPECT_LT(fine_voxel.median, 0.01);
  EXPECT_LT(fine_voxel.most_of, 0.04);
  // A scan of the crowns without the gum around them.
  const TissueMesh noisy = scanned(X_CS, 3);
  double crowns = 0;
  for (const glm::uvec3& t : true_surface().triangles) {
    const dvec3 u = noisy.vertices[t.y] - noisy.vertices[t.x], v = noisy.vertices[t.z] - noisy.vertices[t.x];
    if (true_surface().vertices[t.x].z > (kGum + 0.1) * kMillimetre) crowns += 0.5 * glm::length(glm::cross(u, v));
  }
  EXPECT_NEAR(fused.report.covered_area / crowns, 1, 0.05);

  const DenseTissue &a = ct(), &b = fused.tissue;
  ASSERT_EQ(a.size, b.size);
  std::size_t changed = 0;
  for_each_voxel(a.size, [&](int x, int y, int z) {
    if (a.frame.to_world(dvec3(x, y, z)).z > (kGum - 2.5) * kMillimetre) return;
    const std::size_t i = a.at(x, y, z);
    changed += a.distance[i] == b.distance[i] && a.tissue[i] == b.tissue[i] && a.hardness[i] == b.hardness[i] ? 0 : 1;
  });
  EXPECT_EQ(changed, 0U);
  const PerTissue truth = jaw().volumes();
  for (const DenseTissue* t : {&fused.tissue, &sharp.tissue}) {
    const PerTissue volume = haptics::TissueVolume(*t).volumes(), old = haptics::TissueVolume(ct()).volumes();
    for (const Tissue tissue : {Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone, Tissue::kCancellousBone}) {
      const auto k = static_cast<std::size_t>(tissue);
      EXPECT_NEAR(volume[k] / old[k], 1, 5e-3) << name_of(tissue);
    }
    const auto enamel = static_cast<std::size_t>(Tissue::kEnamel);
    EXPECT_NEAR(volume[enamel] / kCubicMillimetre / truth[enamel], 1, 0.03);
  }
}

}  // namespace
}  // namespace typodont
