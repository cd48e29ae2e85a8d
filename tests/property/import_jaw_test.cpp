// Tests of importing a jaw that is known exactly (synthetic, tests/support/jaw_phantom.h): which structures are
// recognised, how accurately, and whether the report states this.
#include <gmock/gmock.h>

#include <random>

#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "tests/support/folder.h"
#include "tests/support/jaw_phantom.h"
#include "tests/support/plate_root_phantom.h"

namespace typodont {
namespace {

using haptics::import_tissue;
using haptics::Imported;
using test::JawArtefacts;
using test::JawPhantom;

Imported imported(const JawPhantom& jaw, double scale = 1, const std::string& file = "jaw.nrrd") {
  haptics::ImportOptions options;
  options.preset = haptics::ImportPreset::kJaw;
  std::vector<double> greys = jaw.scan();
  for (double& g : greys) g *= scale;
  return import_tissue(test::write_nrrd(file, jaw.phantom(), test::bytes_as<float>(greys), "float"), options);
}

/// A jaw as present cone beam CTs show it, and the result of its import. The tests ImportUsualJaw use this result and
/// run in one process (TOGETHER in import.cmake).
const JawPhantom& usual_jaw() {
  static const JawPhantom jaw{JawArtefacts{}};
  return jaw;
}
const Imported& usual() {
  static const Imported i = imported(usual_jaw(), 1, "usual_jaw.nrrd");
  return i;
}

double relative_error(const Imported& i, const PerTissue& truth_mm3, Tissue t) {
  const auto k = static_cast<std::size_t>(t);
  return i.report.volume[k] / kCubicMillimetre / truth_mm3[k] - 1;
}
const PerTissue& usual_truth() {
  static const PerTissue truth = usual_jaw().volumes();
  return truth;
}

/// Returns the label of the nearest sample; air outside the surface.
Tissue label_at(const Imported& i, const dvec3& mm) {
  const haptics::DenseTissue& t = i.tissue;
  const glm::ivec3 p = glm::clamp(glm::ivec3(glm::round((mm * kMillimetre - t.frame.origin) / t.frame.voxel)),
                                  glm::ivec3(0), t.size - 1);
  const std::size_t k = t.at(p.x, p.y, p.z);
  return t.distance[k] < 0 ? t.tissue[k] : Tissue::kAir;
}

/// Returns the distance field in voxels at a position (mm).
double distance_at(const Imported& i, const dvec3& mm) {
  return test::distance_at(i.tissue, mm * kMillimetre) / i.tissue.frame.voxel;
}

TEST(ImportUsualJaw, ARegionThatCutsRootsAndTheCanalHasTheLabelsOfTheWholeJaw) {
  const Imported& whole_jaw = usual();
  // usual() has written the scan to this file. The walls of these regions cut both roots with their canals; one wall
  // cuts the nerve canal along its length.
  for (const auto& [from, to] :
       {std::pair{dvec3(0, 0, 17), dvec3(29.7, 23.7, 33.3)}, {dvec3(0), dvec3(20.8, 23.7, 33.3)}}) {
    haptics::ImportOptions options;
    options.preset = haptics::ImportPreset::kJaw;
    options.region = {from * kMillimetre, to * kMillimetre};
    const Imported part = import_tissue(test::scratch("usual_jaw.nrrd"), options);
    // The region's wall at x = 20.8 mm cuts the second tooth in half. The test does not examine this tooth.
    const double last = to.x < 25 ? 14.5 : 29;
    PerTissue same{}, all{};
    for (double x = 0.3; x < last; x += 0.3) {
      for (double y = 0.3; y < 23; y += 0.3) {
        for (double z = from.z + 0.9; z < 33; z += 0.3) {
          const Tissue whole = label_at(whole_jaw, {x, y, z});
          all[static_cast<std::size_t>(whole)] += 1;
          same[static_cast<std::size_t>(whole)] += label_at(part, {x, y, z}) == whole;
        }
      }
    }
    for (const Tissue t :
         {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone, Tissue::kCancellousBone})
      EXPECT_GT(same[static_cast<std::size_t>(t)], (t == Tissue::kPulp ? 0.9 : 0.95) * all[static_cast<std::size_t>(t)])
          << name_of(t) << " from z = " << from.z;
  }
}

struct Spread {
  double median, most_of;  // 95 %
};
Spread spread_of(std::vector<double> errors) {
  std::ranges::sort(errors);
  return {errors[errors.size() / 2], errors[errors.size() * 95 / 100]};
}

TEST(ImportUsualJaw, HardTissuesHaveTheirVolumesWithinThreePercent) {
  for (const Tissue t : {Tissue::kEnamel, Tissue::kDentin, Tissue::kCorticalBone, Tissue::kCancellousBone})
    EXPECT_NEAR(relative_error(usual(), usual_truth(), t), 0, 0.03) << name_of(t);
  EXPECT_EQ(usual().report.jaw->crowns(), 2);
  EXPECT_EQ(usual().report.volume[static_cast<std::size_t>(Tissue::kAmalgam)], 0);
}

TEST(ImportUsualJaw, PulpAndNerveHaveTheirVolumeWithinThreePercent) {
  EXPECT_NEAR(relative_error(usual(), usual_truth(), Tissue::kPulp), 0, 0.03);
}

TEST(ImportJaw, PulpAndNerveHaveTheirVolumeWithinThreePercentOnOtherPhantoms) {
  for (const JawArtefacts& other :
       {JawArtefacts{.fine = 6, .voxel = 0.26, .shift = 0.1, .seed = 5, .nerve = 1.45, .chamber = 1.3},
        JawArtefacts{.fine = 6, .seed = 10, .nerve_wall = 0},
        JawArtefacts{.fine = 6, .voxel = 0.4, .shift = 0.13, .seed = 7}}) {
    const JawPhantom jaw(other);
    EXPECT_NEAR(relative_error(imported(jaw), jaw.volumes(), Tissue::kPulp), 0, 0.03)
        << "voxel " << other.voxel << ", noise " << other.noise << ", wall " << other.nerve_wall;
  }
}

TEST(ImportUsualJaw, TheOuterSurfaceLiesWithinHalfAVoxel) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(3, 22);
  std::vector<double> errors;
  const auto solid = [](const dvec3& q) { return usual_jaw().tissue(q) != Tissue::kAir; };
  while (errors.size() < 2000) {
    // Goes down from above to the first solid voxel, and from there to the border between the two tissues.
    const dvec3 start(place(random) * 1.2, place(random), 32.5);
    dvec3 q = start;
    while (q.z > 2 && !solid(q)) q.z -= 0.1;
    if (q.z <= 2) continue;
    double in = q.z, out = q.z + 0.1;
    for (int k = 0; k < 30; ++k) (solid({q.x, q.y, 0.5 * (in + out)}) ? in : out) = 0.5 * (in + out);
    errors.push_back(std::abs(distance_at(usual(), {q.x, q.y, in})));
  }
  const Spread s = spread_of(errors);
  EXPECT_LT(s.median, 0.5);
  EXPECT_LT(s.most_of, 1);
}

TEST(ImportUsualJaw, ARootEndsInItsLigamentWithinHalfAVoxel) {
  std::vector<double> errors;
  for (const double x : JawPhantom::kTeeth) {
    for (double z = JawPhantom::kApex + 1; z < JawPhantom::kNeck - 0.5; z += 0.25) {
      for (double angle = 0; angle < 2 * kPi; angle += 0.2) {
        const dvec3 out(std::cos(angle), std::sin(angle), 0);
        double r = 0;
        const auto in_tooth = [&] {
          const Tissue t = label_at(usual(), dvec3(x, JawPhantom::kY, z) + r * out);
          return t == Tissue::kDentin || t == Tissue::kPulp || t == Tissue::kEnamel;
        };
        while (r < 6 && in_tooth()) r += 0.02;
        errors.push_back(std::abs(r - JawPhantom::root_radius(z)) / JawPhantom::kVoxel);
      }
    }
  }
  const Spread s = spread_of(errors);
  EXPECT_LT(s.median, 0.5);
  EXPECT_LT(s.most_of, 1);
}

TEST(ImportUsualJaw, TheNerveCanalIsFoundWithinHalfAMillimetre) {
  ASSERT_EQ(usual().report.jaw->canals.size(), 1U);
  double lo = 1e9, hi = -1e9;
  for (const dvec3& p : usual().report.jaw->canals[0].centre) {
    double nearest = 1e9;
    for (double x = 0; x < 30; x += 0.02)
      nearest = std::min(nearest, glm::length(p / kMillimetre - JawPhantom::canal_centre(x)));
    EXPECT_LT(nearest, 0.5);
    lo = std::min(lo, p.x / kMillimetre), hi = std::max(hi, p.x / kMillimetre);
  }
  EXPECT_LT(lo, 6);  // the canal extends from 3.8 to 25.7
  EXPECT_GT(hi, 24);
}

TEST(ImportJaw, AMetalCrownAndPulpInStreaksHaveTheirVolumesWithinThreePercent) {
  // Streaks brighten or darken whole pulps, so that their own grey value is no measure of soft tissue.
  const JawPhantom jaw({.streaks = 500, .metal = true, .fine = 6, .voxel = 0.25, .shift = 0.1, .seed = 4});
  const Imported i = imported(jaw);
  const PerTissue truth = jaw.volumes();
  for (const Tissue t : {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kAmalgam})
    EXPECT_NEAR(relative_error(i, truth, t), 0, 0.03) << name_of(t);
}

TEST(ImportJaw, InStreaksOf300UnitsOrStrongBlurTheVolumeOfASinglePulpIsWrongByAtMostTwiceItsUncertainty) {
  // The region contains only the first tooth, so its report states the volume of this tooth's pulp. With stronger
  // streaks, the error can exceed this (README.md of the import).
  constexpr double kBelow = 11.3;  // mm, a height between the nerve and the roots
  haptics::ImportOptions options;
  options.preset = haptics::ImportPreset::kJaw;
  options.region = {dvec3(4, 4, kBelow) * kMillimetre, dvec3(14.6, 20, 33) * kMillimetre};
  const auto k = static_cast<std::size_t>(Tissue::kPulp);
  for (const JawArtefacts& scan :
       {JawArtefacts{.blur = 0.3, .fine = 6}, JawArtefacts{.streaks = 300, .metal = true, .fine = 6},
        JawArtefacts{.streaks = 300, .metal = true, .second = 18.5, .fine = 6, .seed = 5, .chamber = 1.3}}) {
    const JawPhantom jaw(scan);
    const auto file = test::write_nrrd("jaw.nrrd", jaw.phantom(), test::bytes_as<float>(jaw.scan()), "float");
    const haptics::ImportReport report = import_tissue(file, options).report;
    EXPECT_NEAR(report.volume[k] / kCubicMillimetre, jaw.volumes(kBelow)[k] / 2,
                2 * report.volume_uncertainty[k] / kCubicMillimetre)
        << "streaks " << scan.streaks << ", seed " << scan.seed;
  }
}

TEST(ImportJaw, RootsInSocketsWithoutABrightWallStayTeeth) {
  JawArtefacts artefacts;
  artefacts.lamina = false;
  const JawPhantom jaw(artefacts);
  const Imported i = imported(jaw);
  EXPECT_NEAR(relative_error(i, jaw.volumes(), Tissue::kDentin), 0, 0.1);
}

bool notes_shading(const Imported& i) {
  return std::ranges::any_of(i.report.notes,
                             [](const std::string& note) { return note.find("(shading)") != std::string::npos; });
}

TEST(ImportUsualJaw, ShadingOf600HounsfieldUnitsIsCorrectedAndDensityOfBoneIsNot) {
  const JawPhantom shaded(JawArtefacts{.shading = 600});
  const Imported i = imported(shaded);
  for (const Tissue t :
       {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone, Tissue::kCancellousBone})
    EXPECT_NEAR(relative_error(i, usual_truth(), t), 0, 0.03) << name_of(t);
  EXPECT_EQ(i.report.jaw->crowns(), 2);
  EXPECT_EQ(i.report.jaw->canals.size(), 1U);
  EXPECT_TRUE(notes_shading(i));
  // A region is corrected like the whole scan, although it has too few cells for a correction of its own.
  haptics::ImportOptions options;
  options.preset = haptics::ImportPreset::kJaw;
  options.region = {dvec3(4, 6, 10) * kMillimetre, dvec3(15, 18, 33) * kMillimetre};
  const Imported part = import_tissue(test::scratch("jaw.nrrd"), options);
  for (double z = 13; z < 30; z += 0.3) EXPECT_EQ(label_at(part, {9.5, 12, z}), label_at(i, {9.5, 12, z})) << z;
  EXPECT_FALSE(notes_shading(usual()));
  EXPECT_FALSE(notes_shading(imported(JawPhantom(JawArtefacts{.density_slope = 25}))));
}

TEST(ImportJaw, RootCanalsOfLessThanFourVoxelsHaveTheirVolumeWithinTenPercent) {
  // The phantom's samples are so fine that its own canals have the right volume.
  for (const double noise : {50.0, 200.0}) {
    const JawPhantom jaw(JawArtefacts{.noise = noise, .fine = 6});
    const Imported i = imported(jaw);
    const haptics::DenseTissue& t = i.tissue;
    EXPECT_NEAR(relative_error(i, jaw.volumes(), Tissue::kPulp), 0, 0.03) << noise;
    // The slices of a canal between the apex and the chamber, whose radius is 0.5 mm.
    double pulp = 0;
    int slices = 0;
    for (int z = 0; z < t.size.z; ++z) {
      const double height = t.frame.to_world(dvec3(0, 0, z)).z / kMillimetre;
      if (height < JawPhantom::kApex + 2.6 || height > JawPhantom::kNeck - 0.6) continue;
      ++slices;
      for (int x = 0; x < t.size.x; ++x) {
        for (int y = 0; y < t.size.y; ++y) {
          const dvec3 q = t.frame.to_world(dvec3(x, y, z)) / kMillimetre;
          for (const double tooth : JawPhantom::kTeeth)
            pulp += std::hypot(q.x - tooth, q.y - JawPhantom::kY) < 2 && t.tissue[t.at(x, y, z)] == Tissue::kPulp;
        }
      }
    }
    const double voxels = 2 * slices * kPi * 0.25 / (JawPhantom::kVoxel * JawPhantom::kVoxel);
    EXPECT_NEAR(pulp / voxels, 1, 0.1) << noise;
  }
}

TEST(ImportUsualJaw, TeethThatTouchEachOtherAreSeparated) {
  // The crowns have a radius of 4 mm, so at a distance of 7 mm they overlap by 1 mm.
  for (const double second : {17.2, 16.5}) {
    const JawPhantom jaw(JawArtefacts{.second = second});
    const Imported i = imported(jaw);
    EXPECT_EQ(i.report.jaw->crowns(), 2) << second;
    ASSERT_EQ(i.report.jaw->teeth.size(), 2U) << second;
    std::vector<double> places;
    for (const haptics::JawTooth& tooth : i.report.jaw->teeth) {
      places.push_back(tooth.centre.x / kMillimetre);
      EXPECT_NEAR(tooth.volume, usual().report.jaw->teeth[0].volume, 0.05 * tooth.volume) << second;
    }
    std::ranges::sort(places);
    EXPECT_NEAR(places[0], 9.5, 0.2) << second;
    EXPECT_NEAR(places[1], second, 0.2) << second;
  }
}

TEST(ImportUsualJaw, VolumeErrorsAreAtMostTwiceTheReportedUncertainty) {
  JawArtefacts artefacts;
  artefacts.blur = 0.3;
  artefacts.noise = 100;
  const JawPhantom poor(artefacts);
  const Imported of_poor = imported(poor);
  const auto check = [](const Imported& i) {
    const PerTissue& truth = usual_truth();
    for (const Tissue t :
         {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone, Tissue::kCancellousBone}) {
      const auto k = static_cast<std::size_t>(t);
      EXPECT_NEAR(i.report.volume[k] / kCubicMillimetre, truth[k],
                  2 * i.report.volume_uncertainty[k] / kCubicMillimetre)
          << name_of(t);
    }
  };
  check(usual());
  check(of_poor);
  EXPECT_GT(of_poor.report.jaw->border, 1.5 * usual().report.jaw->border);
}

Imported imported(const std::string& name, const test::Phantom& phantom) {
  haptics::ImportOptions options;
  options.preset = haptics::ImportPreset::kJaw;
  return import_tissue(test::write_nrrd(name, phantom, test::bytes_as<float>(phantom.scan()), "float"), options);
}

TEST(ImportJaw, TheJawWithTeethIsImportedAlthoughTheSpineIsLargerAndItsBoneLessDense) {
  test::Phantom p = usual_jaw().phantom();
  p.size.y = 180;
  p.grey = [](const dvec3& q) {
    if (q.y < 25) return usual_jaw().hounsfield(q);
    const double out = std::hypot(q.x - 14.85, q.y - 39);
    return out < 9.5 ? 300.0 : out < 11.5 ? 1100.0 : 50.0;
  };
  const Imported i = imported("spine.nrrd", p);
  EXPECT_EQ(i.report.bodies_found, 2);
  EXPECT_EQ(i.report.jaw->crowns(), 2);
  for (const Tissue t : {Tissue::kEnamel, Tissue::kDentin, Tissue::kCorticalBone, Tissue::kCancellousBone})
    EXPECT_NEAR(relative_error(i, usual_truth(), t), 0, 0.05) << name_of(t);
  EXPECT_TRUE(std::ranges::any_of(i.report.notes, [](const std::string& note) {
    return note.find("another body of") == 0 && note.find("with teeth") == std::string::npos;
  }));
}

TEST(ImportJaw, ARootInsideTheOuterPlateOfBoneStaysATooth) {
  for (const test::PlateRootPhantom& jaw :
       {test::PlateRootPhantom{},
        test::PlateRootPhantom{
            .voxel = 0.3, .seed = 3, .deeper = -0.3, .dentin = 1550, .cortical = 1550, .turn = -0.2}}) {
    const Imported i = imported("plate.nrrd", jaw.phantom());
    double root = 0, tooth = 0;
    for (double x = 4; x < 26; x += 0.2) {
      for (double y = 2; y < 22; y += 0.2) {
        for (double z = 11; z < 23; z += 0.2) {
          if (!jaw.in_leaning_root({x, y, z})) continue;
          const Tissue t = label_at(i, {x, y, z});
          root += 1, tooth += t == Tissue::kDentin || t == Tissue::kPulp;
        }
      }
    }
    EXPECT_GT(tooth, 0.95 * root) << "seed " << jaw.seed;
  }
}

TEST(ImportJaw, AClosedSinusFullOfAirIsNoBoneAndAMarrowSpaceIs) {
  test::Phantom p;
  p.size = {94, 80, 90};
  p.spacing = dvec3(0.3);
  p.blur = 0.2, p.noise = 50, p.fine = 3;
  const auto within = [](const dvec3& q, const dvec3& centre, const dvec3& half) {
    const dvec3 r = (q - centre) / half;
    return glm::dot(r, r) < 1;
  };
  const dvec3 sinus(14, 12, 18), marrow(14, 12, 8);
  const auto bone = [](const dvec3& q, double shell) {
    const dvec3 r = glm::abs(q - dvec3(14, 12, 13.5)) / (dvec3(12, 10, 11.5) - shell);
    return glm::dot(r * r, r * r) < 1;
  };
  p.grey = [&](const dvec3& q) {
    if (within(q, sinus, {6, 5, 4})) return -1000.0;
    if (within(q, sinus, {7, 6, 5})) return 1500.0;
    if (within(q, marrow, {3, 3, 2.5})) return -80.0;
    return bone(q, 1.8) ? 450.0 : bone(q, 0) ? 1500.0 : q.z < 25 ? 40.0 : -1000.0;
  };
  double truth = 0;
  for (int k = 0; k < p.size.x * p.size.y * p.size.z; ++k) {
    const dvec3 q = 0.3 * dvec3(k % p.size.x, k / p.size.x % p.size.y, k / p.size.x / p.size.y);
    if (bone(q, 0) && !within(q, sinus, {6, 5, 4})) truth += 0.027;
  }
  const Imported i = imported("sinus.nrrd", p);
  EXPECT_NEAR(total(i.report.volume) / kCubicMillimetre / truth, 1, 0.02);
  EXPECT_GT(distance_at(i, sinus), 0);
  EXPECT_LT(distance_at(i, marrow), 0);
}

TEST(ImportJaw, ANerveCanalThatLeavesTheBoneAtBothEndsIsFound) {
  // As at the foramina of a jaw, the canal passes through the outer plate of bone into soft tissue.
  test::Phantom p = usual_jaw().phantom();
  const auto in_canal = [](const dvec3& q) {
    return glm::length(q - JawPhantom::canal_centre(q.x)) < JawPhantom::kCanal;
  };
  p.grey = [&](const dvec3& q) { return in_canal(q) ? 60.0 : usual_jaw().hounsfield(q); };
  const Imported i = imported("open.nrrd", p);
  ASSERT_EQ(i.report.jaw->canals.size(), 1U);
  for (const dvec3& c : i.report.jaw->canals[0].centre) {
    double nearest = 1e9;
    for (double x = 0; x < 30; x += 0.02)
      nearest = std::min(nearest, glm::length(c / kMillimetre - JawPhantom::canal_centre(x)));
    EXPECT_LT(nearest, 0.5);
  }
  constexpr double kStep = 0.1;  // mm
  double drilled = 0;            // mm³, part of the outer plate and of the canal's wall that the canal replaces
  for (double x = 0; x < 30; x += kStep) {
    for (double y = 10; y < 16; y += kStep) {
      for (double z = 5; z < 12; z += kStep)
        if (in_canal({x, y, z}) && usual_jaw().tissue({x, y, z}) == Tissue::kCorticalBone)
          drilled += kStep * kStep * kStep;
    }
  }
  EXPECT_GT(drilled, 5);
  const auto k = static_cast<std::size_t>(Tissue::kPulp);
  // Next to its mouths, a part of the canal counts as outside.
  EXPECT_NEAR(i.report.volume[k] / kCubicMillimetre / (usual_truth()[k] + drilled), 1, 0.1);
}

TEST(ImportJaw, GreysWithoutAKnownScaleAreRefused) {
  EXPECT_THAT(test::refusal([&] { imported(usual_jaw(), 0.3); }), testing::HasSubstr("--hounsfield"));
}

}  // namespace
}  // namespace typodont
