// Measures how accurately the tissues of a jaw are recognised, as a function of the errors that the scanner adds. Uses
// the phantom of tests/support/jaw_phantom.h, with one row for each level of blur, noise, streaks and motion. Prints
// the rows, and checks that the jaw is still recognised.
#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/import.h"
#include "tests/support/jaw_phantom.h"

namespace typodont {
namespace {

using test::JawArtefacts;
using test::JawPhantom;

struct Level {
  const char* name;
  JawArtefacts artefacts;
};
const Level kLevels[] = {
    {"blur 0.15 mm, noise 10", {.blur = 0.15, .noise = 10, .texture = 0}},
    {"blur 0.2 mm, noise 50", {}},
    {"blur 0.2 mm, noise 100", {.noise = 100}},
    {"blur 0.2 mm, noise 200", {.noise = 200}},
    {"blur 0.3 mm, noise 50", {.blur = 0.3}},
    {"blur 0.3 mm, noise 100", {.blur = 0.3, .noise = 100}},
    {"blur 0.4 mm, noise 100", {.blur = 0.4, .noise = 100}},
    {"metal crown", {.metal = true}},
    {"metal crown, streaks 200", {.streaks = 200, .metal = true}},
    {"metal crown, streaks 500", {.streaks = 500, .metal = true}},
    {"sockets without a wall", {.lamina = false}},
    {"motion 0.3 mm", {.motion = 0.3}},
    {"motion 0.6 mm", {.motion = 0.6}},
    {"shading 300", {.shading = 300}},
    {"shading 600", {.shading = 600}},
    {"shading 600, metal crown, streaks", {.streaks = 500, .metal = true, .shading = 600}},
};

TEST(ImportJawBench, TeethBoneAndCanalAreSegmentedAtEveryNoiseLevel) {
  fmt::print("{:<34}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>12}{:>12}\n", "volumes wrong by %", "enamel", "dentin", "pulp",
             "cortical", "cancell.", "metal", "canal, mm", "border, mm");
  for (const Level& level : kLevels) {
    const JawPhantom jaw(level.artefacts);
    haptics::ImportOptions options;
    options.preset = haptics::ImportPreset::kJaw;
    options.greys = false;
    const auto file = test::write_nrrd("jaw.nrrd", jaw.phantom(), test::bytes_as<float>(jaw.scan()), "float");
    const haptics::ImportReport report = haptics::import_tissue(file, options).report;
    const PerTissue truth = jaw.volumes();
    fmt::print("{:<34}", level.name);
    for (const Tissue t : {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone,
                           Tissue::kCancellousBone, Tissue::kAmalgam}) {
      const auto k = static_cast<std::size_t>(t);
      if (truth[k] > 0)
        fmt::print("{:>+9.1f}", 100 * (report.volume[k] / kCubicMillimetre / truth[k] - 1));
      else
        fmt::print("{:>9}", report.volume[k] > 0 ? "found" : "none");
    }
    double worst = 0;
    for (const haptics::JawCanal& canal : report.jaw->canals) {
      for (const dvec3& p : canal.centre) {
        double nearest = 1e9;
        for (double x = 0; x < 30; x += 0.05)
          nearest = std::min(nearest, glm::length(p / kMillimetre - JawPhantom::canal_centre(x)));
        worst = std::max(worst, nearest);
      }
    }
    fmt::print("{:>12.2f}{:>12.2f}\n", worst, report.jaw->border / kMillimetre);
    EXPECT_GE(report.jaw->crowns(), 1) << level.name;
    EXPECT_FALSE(report.jaw->canals.empty()) << level.name;
  }
}

// Phantoms whose pulp and nerve differ from the usual phantom in shape, voxel size, position of the voxels, and seed.
const Level kCavities[] = {
    {"voxel 0.3", {.fine = 6}},
    {"voxel 0.3, noise 0", {.noise = 0, .fine = 6}},
    {"voxel 0.3, blur 0.1", {.blur = 0.1, .fine = 6}},
    {"voxel 0.3, blur 0.3", {.blur = 0.3, .fine = 6}},
    {"voxel 0.3, noise 100", {.noise = 100, .fine = 6}},
    {"voxel 0.3, noise 200", {.noise = 200, .fine = 6}},
    {"voxel 0.2, blur 0.2", {.fine = 6, .voxel = 0.2, .shift = 0.07, .seed = 2}},
    {"voxel 0.2, blur 0.1", {.blur = 0.1, .fine = 6, .voxel = 0.2, .shift = 0.07, .seed = 3}},
    {"voxel 0.25, blur 0.2, noise 100", {.noise = 100, .fine = 6, .voxel = 0.25, .shift = 0.1, .seed = 4}},
    {"voxel 0.26, canal 2.9, chamber 1.3",
     {.fine = 6, .voxel = 0.26, .shift = 0.1, .seed = 5, .nerve = 1.45, .chamber = 1.3}},
    {"voxel 0.35, blur 0.2", {.fine = 6, .voxel = 0.35, .shift = 0.11, .seed = 6}},
    {"voxel 0.4, blur 0.2", {.fine = 6, .voxel = 0.4, .shift = 0.13, .seed = 7}},
    {"voxel 0.4, blur 0.2, chamber 1.3", {.fine = 6, .voxel = 0.4, .shift = 0.13, .seed = 8, .chamber = 1.3}},
    {"thin nerve wall 0.25", {.fine = 6, .seed = 9, .nerve_wall = 0.25}},
    {"nerve without wall", {.fine = 6, .seed = 10, .nerve_wall = 0}},
    {"thick nerve wall 1", {.fine = 6, .seed = 11, .nerve_wall = 1}},
    {"nerve 2.2 mm, wall 0.35", {.fine = 6, .shift = 0.05, .seed = 12, .nerve = 1.1, .nerve_wall = 0.35}},
    {"nerve 3.2 mm", {.fine = 6, .shift = 0.05, .seed = 13, .nerve = 1.6}},
    {"root canals 0.7 mm", {.fine = 6, .seed = 14, .root_canal = 0.35}},
    {"root canals 1.4 mm", {.fine = 6, .seed = 15, .root_canal = 0.7}},
};

TEST(ImportJawBench, PulpAndNerveHaveTheirVolumeWithinFivePercentOnEveryPhantom) {
  fmt::print("{:<38}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "volumes wrong by %", "nerve", "pulp", "chamber", "canals",
             "all", "blur");
  for (const Level& level : kCavities) {
    const JawPhantom jaw(level.artefacts);
    haptics::ImportOptions options;
    options.preset = haptics::ImportPreset::kJaw;
    options.greys = false;
    const auto file = test::write_nrrd("jaw.nrrd", jaw.phantom(), test::bytes_as<float>(jaw.scan()), "float");
    const haptics::Imported imported = haptics::import_tissue(file, options);
    const haptics::DenseTissue& t = imported.tissue;
    // Heights that divide the nerve, the root canals and the chambers.
    constexpr double kRoots = 11.5, kChambers = JawPhantom::kNeck - 0.5;
    dvec3 found(0);
    for_each_voxel(t.size, [&](int x, int y, int z) {
      const std::size_t k = t.at(x, y, z);
      if (t.tissue[k] != Tissue::kPulp || t.distance[k] >= 0) return;
      const double height = t.frame.to_world(dvec3(x, y, z)).z / kMillimetre + level.artefacts.shift;
      found[height < kRoots ? 0 : height < kChambers ? 1 : 2] += std::pow(t.frame.voxel / kMillimetre, 3);
    });
    const auto k = static_cast<std::size_t>(Tissue::kPulp);
    const double all = jaw.volumes()[k], above = jaw.volumes(kRoots)[k], chambers = jaw.volumes(kChambers)[k];
    fmt::print("{:<38}{:>+9.1f}{:>+9.1f}{:>+9.1f}{:>+9.1f}{:>+9.1f}{:>9.2f}\n", level.name,
               100 * (found[0] / (all - above) - 1), 100 * ((found[1] + found[2]) / above - 1),
               100 * (found[2] / chambers - 1), 100 * (found[1] / (above - chambers) - 1),
               100 * ((found[0] + found[1] + found[2]) / all - 1), imported.report.blur / kMillimetre);
    EXPECT_NEAR((found[0] + found[1] + found[2]) / all, 1, 0.05) << level.name;
  }
}

}  // namespace
}  // namespace typodont
