// Measures how accurately the tissues of a jaw are recognised, as a function of the errors that the scanner adds. Uses
// the phantom of tests/support/jaw_phantom.h, with one row for each level of blur, noise, streaks and motion. Prints
// the rows, and checks that the jaw is still recognised.
#include <gtest/gtest.h>

#include "engine/base/units.h"
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

}  // namespace
}  // namespace typodont
