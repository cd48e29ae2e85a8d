// Solids on voxels: looking at whole blocks first changes nothing, only the time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont::haptics {
namespace {

std::string random_solid(std::mt19937& random, int depth) {
  std::uniform_real_distribution<double> at(-2, 2), size(0.3, 2.5);
  const auto place = [&] { return fmt::format("[{:.3f}, {:.3f}, {:.3f}]", at(random), at(random), at(random)); };
  switch (std::uniform_int_distribution<int>(0, depth > 0 ? 7 : 4)(random)) {
    case 0: return fmt::format(R"({{"sphere": {{"center_mm": {}, "radius_mm": {:.3f}}}}})", place(), size(random));
    case 1: return fmt::format(R"({{"box": {{"center_mm": {}, "size_mm": [{:.3f}, {:.3f}, {:.3f}]}}}})", place(), size(random),
                               size(random), size(random));
    case 2: return fmt::format(R"({{"capsule": {{"a_mm": {}, "b_mm": {}, "radius_mm": {:.3f}}}}})", place(), place(),
                               0.5 * size(random));
    case 3: return fmt::format(R"({{"cylinder": {{"center_mm": {}, "axis": {}, "radius_mm": {:.3f}, "height_mm": {:.3f}}}}})",
                               place(), place(), size(random), size(random));
    case 4: return fmt::format(R"({{"cone": {{"center_mm": {}, "axis": {}, "radius_mm": {:.3f}, "top_radius_mm": {:.3f}, "height_mm": {:.3f}}}}})",
                               place(), place(), size(random), size(random), size(random));
    default: break;
  }
  const char* kinds[] = {"union", "intersection", "difference"};
  return fmt::format(R"({{"{}": [{}, {}]}})", kinds[random() % 3], random_solid(random, depth - 1),
                     random_solid(random, depth - 1));
}

TEST(Sampling, EveryVoxelHasTheDistanceAndTheLabelThatTheSolidsGiveIt) {
  constexpr const char* kNames[] = {"enamel", "dentin", "pulp", "cortical_bone"};
  constexpr Tissue kTissues[] = {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone};
  std::mt19937 random(11);
  int deep = 0;
  for (int scene = 0; scene < 12; ++scene) {
    std::vector<std::unique_ptr<Solid>> solids;
    std::string text;
    for (int k = 0; k < 4; ++k) {
      const std::string solid = random_solid(random, 2);
      solids.push_back(read_solid(Json::parse(solid, "solid")));
      text += fmt::format(R"({}{{"tissue": "{}", "solid": {}}})", k ? ", " : "", kNames[k], solid);
    }
    const DenseTissue dense = read_solids(Json::parse(
        fmt::format(R"({{"voxel_mm": 0.1, "band_mm": 0.5, "domain_mm": [[-4,-4,-4],[4,4,4]], "solids": [{}]}})", text), "tissue"));
    ASSERT_EQ(dense.size, glm::ivec3(81));
    for (int x = 0; x < dense.size.x; ++x) {
      for (int y = 0; y < dense.size.y; ++y) {
        for (int z = 0; z < dense.size.z; ++z) {
          const dvec3 p = dense.frame.to_world(dvec3(x, y, z));
          double least = 1e9, nearest = 3 * dense.frame.voxel;
          Tissue within = Tissue::kAir, beside = Tissue::kAir;
          for (std::size_t k = 0; k < solids.size(); ++k) {
            const double d = solids[k]->distance(p);
            if (d <= 0) {
              within = kTissues[k];
            } else if (d < nearest) {
              nearest = d;
              beside = kTissues[k];
            }
            least = std::min(least, d);
          }
          const std::size_t i = dense.at(x, y, z);
          ASSERT_EQ(dense.distance[i], static_cast<float>(std::clamp(least, -dense.band, dense.band))) << scene;
          ASSERT_EQ(dense.tissue[i], least <= 0 ? within : beside) << scene;
          deep += least <= -dense.band;
        }
      }
    }
    // And in the volume: what lies beyond the band is there once per leaf, and says the same.
    const TissueVolume volume(dense);
    std::vector<float> distance(81 * 81 * 81);
    std::vector<Tissue> label(distance.size());
    volume.copy(glm::ivec3(0), dense.size, distance.data(), label.data());
    for (std::size_t i = 0; i < distance.size(); ++i) {
      ASSERT_NEAR(distance[i], dense.distance[i] / dense.frame.voxel, 1e-5);
      ASSERT_EQ(label[i], dense.tissue[i]);
    }
  }
  EXPECT_GT(deep, 1000) << "some of it lay beyond the band";
}

}  // namespace
}  // namespace typodont::haptics
