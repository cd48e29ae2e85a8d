// Tests an intraoral scan that is registered to a CBCT by picked points, without a window.
#include "engine/app/planning/scan_fusion.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/support/fuse_phantom.h"

namespace typodont {
namespace {

/// A square with corners at ±10 mm in the plane z = height, facing +z.
haptics::TissueMesh square(double height) {
  constexpr double k = 10e-3;
  haptics::TissueMesh mesh;
  mesh.vertices = {{-k, -k, height}, {k, -k, height}, {k, k, height}, {-k, k, height}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.tissue.assign(2, Tissue::kEnamel);
  return mesh;
}

TEST(SurfacePicture, AClickFindsTheNearestPointOfTheSurface) {
  SurfacePicture picture(square(0), {{200, 0, 0}, {200, 0, 0}});
  haptics::TissueMesh above = square(3e-3);
  for (dvec3& p : above.vertices) p.x = 0.5 * p.x + 5e-3;  // covers x from 0 to 10 mm
  picture.add(above, {{0, 200, 0}, {0, 200, 0}});
  picture.look_along({0, 0, -1}, {0, 1, 0});
  constexpr int kPixels = 200;
  const render::Picture drawn = picture.draw(kPixels);
  const double pixel = 1.05 * 20e-3 * std::sqrt(2) / kPixels;
  for (const dvec3& p : {dvec3(-6e-3, 2e-3, 0), dvec3(4e-3, -7e-3, 3e-3)}) {
    const dvec2 place = picture.place_of(p);
    const auto found = picture.at(place);
    ASSERT_TRUE(found);
    EXPECT_NEAR(glm::length(*found - p), 0, pixel);
    EXPECT_NEAR(found->z, p.z, 1e-8);
    const std::uint8_t* color = drawn.at(static_cast<int>(place.x * kPixels), static_cast<int>(place.y * kPixels));
    EXPECT_EQ(color[0] > color[1], p.z == 0);
  }
  EXPECT_FALSE(picture.at({0.01, 0.5}));
  // Seen from behind, the lower square is nearer.
  picture.look_along({0, 0, 1}, {0, 1, 0});
  (void)picture.draw(kPixels);
  const auto behind = picture.at(picture.place_of({4e-3, -7e-3, 0}));
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->z, 0, 1e-8);
}

TEST(SurfacePicture, TurningAndZoomingKeepThePointUnderItsPlace) {
  SurfacePicture picture(square(1e-3), {{200, 0, 0}, {200, 0, 0}});
  picture.look_along({0, 0, -1}, {0, 1, 0});
  picture.turn({0.1, -0.05});
  picture.zoom(1.3);
  (void)picture.draw(300);
  for (const dvec3& p : {dvec3(0, 0, 1e-3), dvec3(5e-3, 4e-3, 1e-3), dvec3(-3e-3, 6e-3, 1e-3)}) {
    const auto found = picture.at(picture.place_of(p));
    ASSERT_TRUE(found);
    EXPECT_LT(glm::length(*found - p), 0.2e-3);
  }
}

TEST(ScanFusion, ThreePicksLayTheScanOnTheTeethAndReplaceTheCrowns) {
  const Pose X_CS{dvec3(0.02, -0.03, 0.05), glm::angleAxis(2.0, glm::normalize(dvec3(1, 2, -1)))};
  const auto file = test::write_stl("window_crowns.stl", test::scanned(X_CS, 1));
  const auto ct = std::make_shared<const haptics::DenseTissue>(test::ct());
  ScanFusion fusion(ct, file, kMillimetre);
  for (const auto side : {ScanFusion::kScan, ScanFusion::kCt}) (void)fusion.view(side).draw(400);
  EXPECT_FALSE(fusion.pick(ScanFusion::kScan, {0.001, 0.001})) << "beside the surface";
  // Points of the crowns that a person recognises, m in the CT; they are seen from above.
  const Pose X_SC = inverse(X_CS);
  for (const dvec3& mm : {dvec3(9.5, 12, 31), dvec3(20, 12, 31), dvec3(20, 9, 29.4)}) {
    const dvec3 p_C = mm * kMillimetre;
    EXPECT_FALSE(fusion.can_register());
    EXPECT_TRUE(fusion.pick(ScanFusion::kScan, fusion.view(ScanFusion::kScan).place_of(X_SC * p_C)));
    EXPECT_FALSE(fusion.pick(ScanFusion::kScan, fusion.view(ScanFusion::kScan).place_of(X_SC * p_C)))
        << "the other surface is next";
    EXPECT_TRUE(fusion.pick(ScanFusion::kCt, fusion.view(ScanFusion::kCt).place_of(p_C)));
    EXPECT_LT(glm::length(fusion.points(ScanFusion::kCt).back() - p_C), 0.8e-3);
  }
  ASSERT_TRUE(fusion.can_register());
  fusion.drop_last();
  EXPECT_FALSE(fusion.can_register());
  EXPECT_TRUE(fusion.pick(ScanFusion::kCt, fusion.view(ScanFusion::kCt).place_of(dvec3(20, 9, 29.4) * kMillimetre)));
  ScanRegistration registration = fusion.registered();
  const dvec3 at_crown = dvec3(9.5, 12, 31) * kMillimetre;
  EXPECT_LT(glm::length(registration.fine.X_DS * (X_SC * at_crown) - at_crown), 0.05e-3);
  EXPECT_LT(registration.fine.predicted_error, 0.05e-3);
  EXPECT_GT(registration.fine.predicted_error, 0);
  fusion.show(registration);
  Progress progress;
  const haptics::Fused fused = fusion.fused(progress);
  EXPECT_EQ(fused.tissue.size, ct->size);
  EXPECT_GT(fused.report.covered_area, 50 * kSquareMillimetre);
  // After a point has changed, the old registration is no longer valid.
  fusion.drop_last();
  EXPECT_FALSE(fusion.registration());
}

}  // namespace
}  // namespace typodont
