// Tests a scan before its import: sections, region, labels and corrections, without a window.
#include "engine/app/planning/scan_review.h"

#include <gmock/gmock.h>

#include "engine/base/units.h"
#include "tests/support/folder.h"
#include "tests/support/import_phantom.h"

namespace typodont {
namespace {

using haptics::ScanVolume;

constexpr dvec3 kLarge(5e-3, 7e-3, 8e-3), kSmall(15.5e-3, 7.5e-3, 8e-3);  // m, centres of two teeth
constexpr double kVoxel = 0.25e-3;

/// Writes a scan of two balls of dentin with shells of enamel. One ball is larger than the other.
std::filesystem::path write_scan(const std::string& name, const std::string& space) {
  test::Phantom p;
  p.size = {80, 60, 64};
  p.spacing = glm::dvec3(kVoxel / kMillimetre);
  p.fine = 3;
  p.noise = 10;
  p.grey = [](const glm::dvec3& q_mm) {
    const dvec3 q = q_mm * kMillimetre;
    const double r = glm::length(q - kLarge), s = glm::length(q - kSmall);
    return r < 3.2e-3 || s < 2.2e-3 ? 830.0 : r < 4.4e-3 || s < 3.2e-3 ? 1220.0 : 400.0;
  };
  std::string header =
      fmt::format("NRRD0004\ntype: float\ndimension: 3\nsizes: {} {} {}\n", p.size.x, p.size.y, p.size.z);
  header += space.empty() ? "spacings: 0.25 0.25 0.25\n"
                          : fmt::format("space: {}\nspace directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)\n", space);
  const auto file = test::scratch(name);
  test::write(file, header + "endian: little\nencoding: raw\n\n" + test::bytes_as<float>(p.scan()));
  return file;
}

std::shared_ptr<const ScanVolume> scan() {
  static const auto volume = std::make_shared<const ScanVolume>(write_scan("review.nrrd", "left-posterior-superior"),
                                                                haptics::ImportOptions{});
  return volume;
}

/// Computes what the review requests, as the worker thread of the window does.
void compute(ScanReview& review) {
  while (const auto request = review.request()) review.take(*request, scan()->import(request->options));
}
double volume(const ScanReview& review, Tissue tissue) {
  return review.volumes()[static_cast<std::size_t>(tissue)];
}
double ball(double r) {
  return 4.0 / 3 * kPi * r * r * r;
}
haptics::ImportRegion around_small() {
  return {kSmall - 4.2e-3, kSmall + 4.2e-3};
}

TEST(ScanReview, TheRegionIsImportedWithTheGreyValuesOfTheWholeScan) {
  // The import keeps the largest tooth: the larger one of the whole scan, and the smaller one of the region.
  haptics::ImportOptions options;
  const double dentin_of_large = ball(3.2e-3), dentin_of_small = ball(2.2e-3);
  EXPECT_NEAR(scan()->import(options).report.volume[static_cast<std::size_t>(Tissue::kDentin)], dentin_of_large,
              0.04 * dentin_of_large);
  options.region = around_small();
  const haptics::Imported small = scan()->import(options);
  EXPECT_NEAR(small.report.volume[static_cast<std::size_t>(Tissue::kDentin)], dentin_of_small, 0.04 * dentin_of_small);
  const double enamel = ball(3.2e-3) - dentin_of_small;
  EXPECT_NEAR(small.report.volume[static_cast<std::size_t>(Tissue::kEnamel)], enamel, 0.04 * enamel);
  EXPECT_NEAR(glm::length(0.5 * (small.report.lo + small.report.hi) - kSmall), 0, 0.1e-3);
  // This region contains no surroundings of the tooth, so their grey value is taken from the whole scan.
  options.region = {kSmall - 1.5e-3, kSmall + 1.5e-3};
  EXPECT_NEAR(total(scan()->import(options).report.volume), std::pow(3.25e-3, 3), 0.1 * std::pow(3.25e-3, 3));
  // The command imports the same.
  options.region = around_small();
  EXPECT_EQ(haptics::import_tissue(test::scratch("review.nrrd"), options).tissue.tissue, small.tissue.tissue);
}

TEST(ScanReview, ARegionOutsideTheScanIsRefused) {
  haptics::ImportOptions options;
  options.region = {dvec3(40e-3), dvec3(50e-3)};
  const std::string said = test::refusal([&] { scan()->import(options); });
  EXPECT_TRUE(said.starts_with("--region-mm")) << said;
  EXPECT_THAT(said, testing::HasSubstr("(19.8, 14.8, 15.8) mm"));
}

TEST(ScanReview, LabelsAreCoarseWhileAWallIsDraggedAndFullOnRelease) {
  ScanReview review(scan());
  ASSERT_TRUE(review.request());
  EXPECT_EQ(review.request()->detail, LabelDetail::kCoarse);
  compute(review);
  EXPECT_EQ(review.detail(), LabelDetail::kCoarse) << "full labels only on request";
  EXPECT_FALSE(review.can_correct());
  review.set_dragging(true);
  review.move_walls({-1, 0, 0}, {10e-3, 0, 0});
  EXPECT_FALSE(review.current());
  ASSERT_TRUE(review.request());
  EXPECT_EQ(review.request()->detail, LabelDetail::kCoarse);
  compute(review);
  EXPECT_EQ(review.detail(), LabelDetail::kCoarse);
  const LabelRequest stale{LabelDetail::kFull, review.request() ? 0u : 1u, review.options()};
  review.move_walls({-1, 0, 0}, {11e-3, 0, 0});
  review.take(stale, scan()->import(stale.options));
  EXPECT_NE(review.detail(), LabelDetail::kFull) << "full labels of another region";
  review.set_dragging(false);
  compute(review);
  EXPECT_TRUE(review.can_correct());
  const double dentin = ball(2.2e-3);
  EXPECT_NEAR(volume(review, Tissue::kDentin), dentin, 0.04 * dentin);
}

TEST(ScanReview, ACancelledComputationStartsAgainOnlyWhenTheUserAsks) {
  ScanReview review(scan());
  compute(review);
  for (int attempt = 0; attempt < 2; ++attempt) {
    review.want_full();
    ASSERT_TRUE(review.request());
    EXPECT_EQ(review.request()->detail, LabelDetail::kFull);
    review.give_up(*review.request());
    EXPECT_FALSE(review.request()) << "full labels without a request";
  }
  review.set_region(around_small());
  ASSERT_TRUE(review.request());
  review.give_up(*review.request());
  EXPECT_FALSE(review.request()) << "coarse labels that were given up";
}

TEST(ScanReview, TheMouseTakesTheWallNearItInEverySection) {
  ScanReview review(scan());
  review.set_region({dvec3(5e-3), dvec3(10e-3)});
  const auto planes = review.planes();
  constexpr std::array<int, 3> kNormal{2, 1, 0};
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      for (const int side : {-1, 1}) {
        dvec3 p(7.5e-3);
        p[a] = side < 0 ? 5.1e-3 : 9.9e-3;
        glm::ivec3 expected(0);
        if (a != kNormal[i]) expected[a] = side;
        EXPECT_EQ(review.walls_at(i, p, 0.3e-3), expected) << i << a << side;
      }
    }
    EXPECT_EQ(review.walls_at(i, dvec3(7.5e-3), 0.3e-3), glm::ivec3(0));
    EXPECT_EQ(review.walls_at(i, dvec3(14e-3, 14e-3, 14e-3), 0.3e-3), glm::ivec3(0)) << "beyond the box";
  }
  review.move_walls({1, -1, 0}, {12e-3, 4e-3, 1});
  EXPECT_EQ(review.region().hi.x, 12e-3);
  EXPECT_EQ(review.region().lo.y, 4e-3);
  EXPECT_EQ(review.region().hi.z, 10e-3);
  review.move_walls({1, 0, 0}, {-1, 0, 0});  // not beyond the opposite wall
  EXPECT_GE(review.region().hi.x - review.region().lo.x, 3e-3 - 1e-12);
  review.move_walls({0, 0, 1}, {0, 0, 1});  // not out of the scan
  EXPECT_EQ(review.region().hi.z, scan()->hi().z);
}

TEST(ScanReview, CorrectionsAreUndoneRedoneAndKeptForAnotherRegion) {
  ScanReview review(scan());
  review.set_region(around_small());
  const auto paint = [&](const dvec3& p, bool joins) {
    review.correct(haptics::LabelStroke{haptics::LabelKind::kMetal, {p}, 0.8e-3, true}, joins);
  };
  paint(kSmall, false);
  EXPECT_TRUE(review.corrections().empty()) << "without full labels";
  review.want_full();
  compute(review);
  const PerTissue before = review.volumes();
  paint(kSmall, false);
  paint(kSmall + dvec3(0.6e-3, 0, 0), true);
  const PerTissue painted = review.volumes();
  EXPECT_GT(volume(review, Tissue::kAmalgam), ball(0.8e-3));
  review.correct(haptics::LabelSeed{haptics::LabelKind::kNothing, kSmall + dvec3(0, 0, 1.5e-3), 9e-3, 0.3});
  EXPECT_LT(total(review.volumes()), 0.95 * total(painted));
  review.undo();
  for (std::size_t t = 0; t < painted.size(); ++t) EXPECT_NEAR(review.volumes()[t], painted[t], 1e-15);
  review.undo();
  for (std::size_t t = 0; t < painted.size(); ++t) EXPECT_NEAR(review.volumes()[t], before[t], 1e-15);
  EXPECT_FALSE(review.can_undo());
  review.redo();
  for (std::size_t t = 0; t < painted.size(); ++t) EXPECT_NEAR(review.volumes()[t], painted[t], 1e-15);
  EXPECT_EQ(review.corrections().size(), 2u);
  // After corrections, the volumes must equal a count of all samples.
  const haptics::DenseTissue& tissue = review.labels()->tissue;
  const PerTissue counted = haptics::volumes_in(tissue, {glm::ivec3(0), tissue.size - 1});
  for (std::size_t t = 1; t < painted.size(); ++t) EXPECT_NEAR(review.volumes()[t], counted[t], 1e-6 * total(counted));
  // Another region has the same stroke.
  const double metal = volume(review, Tissue::kAmalgam);
  review.set_region({kSmall - 4.4e-3, kSmall + 4.1e-3});
  EXPECT_FALSE(review.can_undo());
  review.want_full();
  compute(review);
  EXPECT_NEAR(volume(review, Tissue::kAmalgam), metal, 0.05 * metal);
  review.undo();
  EXPECT_EQ(volume(review, Tissue::kAmalgam), 0);
}

TEST(ScanReview, ThePatientsLeftIsAtTheRightOfTheSections) {
  // The phantom's small tooth has the larger x. In LPS coordinates it is the left one, in RAS coordinates the right
  // one.
  for (const auto& [space, left] : {std::pair{"left-posterior-superior", true}, {"right-anterior-superior", false}}) {
    ScanReview review(
        std::make_shared<const ScanVolume>(write_scan(fmt::format("{}.nrrd", left), space), haptics::ImportOptions{}));
    EXPECT_EQ(review.sides(0)[1], "L");
    const SectionPlane plane = review.planes()[0];
    EXPECT_EQ(glm::dot(kSmall - kLarge, plane.right_W) > 0, left) << space;
    // In the axial section the patient's front is at the top; in the other sections the head is at the top.
    EXPECT_EQ(plane.up_W.y < 0, left);
    for (const std::size_t i : {1, 2}) EXPECT_EQ(review.planes()[i].up_W, dvec3(0, 0, 1));
    for (const SectionPlane& p : review.planes()) EXPECT_EQ(glm::dot(p.right_W, p.up_W), 0);
  }
  ScanReview unknown(std::make_shared<const ScanVolume>(write_scan("unknown.nrrd", ""), haptics::ImportOptions{}));
  EXPECT_EQ(unknown.sides(0)[1], "");
}

TEST(ScanReview, ASectionShowsLabelsInTheRegionAndDarkerGreysOutside) {
  ScanReview review(scan());
  constexpr int kPixels = 96;
  const auto pixel = [&](const dvec3& p) {
    const SectionPlane plane = review.planes()[0];
    const render::Picture picture = review.picture(plane, kPixels);
    const dvec3 from = p - plane.center_W;
    const auto x = static_cast<int>((0.5 + glm::dot(from, plane.right_W) / plane.width) * kPixels),
               y = static_cast<int>((0.5 - glm::dot(from, plane.up_W) / plane.height) * kPixels);
    const std::uint8_t* c = picture.at(x, y);
    return glm::ivec3(c[0], c[1], c[2]);
  };
  review.look_at(kSmall);
  const glm::ivec3 plain = pixel(kSmall);
  EXPECT_EQ(plain.x, plain.y);
  review.set_region(around_small());
  review.want_full();
  compute(review);
  const glm::ivec3 dentin = pixel(kSmall), outside = pixel(kLarge);
  EXPECT_GT(dentin.x, dentin.z + 30) << "dentin is yellow";
  EXPECT_EQ(outside.x, outside.z);
  EXPECT_LT(outside.x, plain.x - 20);
}

}  // namespace
}  // namespace typodont
