// Tests of solids sampled on voxels. Testing whole blocks first changes only the time and not the result. The border
// between two tissues is at the right position.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {
namespace {

std::string random_solid(std::mt19937& random, int depth) {
  std::uniform_real_distribution<double> at(-2, 2), size(0.3, 2.5);
  const auto place = [&] { return fmt::format("[{:.3f}, {:.3f}, {:.3f}]", at(random), at(random), at(random)); };
  switch (std::uniform_int_distribution<int>(0, depth > 0 ? 7 : 4)(random)) {
    case 0:
      return fmt::format(R"({{"sphere": {{"center_mm": {}, "radius_mm": {:.3f}}}}})", place(), size(random));
    case 1:
      return fmt::format(R"({{"box": {{"center_mm": {}, "size_mm": [{:.3f}, {:.3f}, {:.3f}]}}}})", place(),
                         size(random), size(random), size(random));
    case 2:
      return fmt::format(R"({{"capsule": {{"a_mm": {}, "b_mm": {}, "radius_mm": {:.3f}}}}})", place(), place(),
                         0.5 * size(random));
    case 3:
      return fmt::format(R"({{"cylinder": {{"center_mm": {}, "axis": {}, "radius_mm": {:.3f}, "height_mm": {:.3f}}}}})",
                         place(), place(), size(random), size(random));
    case 4:
      return fmt::format(
          R"({{"cone": {{"center_mm": {}, "axis": {}, "radius_mm": {:.3f}, "top_radius_mm": {:.3f}, "height_mm": {:.3f}}}}})",
          place(), place(), size(random), size(random), size(random));
    default:
      break;
  }
  const char* kinds[] = {"union", "intersection", "difference"};
  return fmt::format(R"({{"{}": [{}, {}]}})", kinds[random() % 3], random_solid(random, depth - 1),
                     random_solid(random, depth - 1));
}

TEST(Sampling, EveryVoxelHasTheDistanceToTheSolidsAndALabelFromInsideItself) {
  constexpr const char* kNames[] = {"enamel", "dentin", "pulp", "cortical_bone"};
  constexpr Tissue kTissues[] = {Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp, Tissue::kCorticalBone};
  std::mt19937 random(11);
  int deep = 0, borders = 0;
  for (int scene = 0; scene < 12; ++scene) {
    std::vector<std::unique_ptr<Solid>> solids;
    std::string text;
    for (int k = 0; k < 4; ++k) {
      const std::string solid = random_solid(random, 2);
      solids.push_back(read_solid(Json::parse(solid, "solid")));
      text += fmt::format(R"({}{{"tissue": "{}", "solid": {}}})", k ? ", " : "", kNames[k], solid);
    }
    const DenseTissue dense = read_solids(Json::parse(
        fmt::format(R"({{"voxel_mm": 0.1, "band_mm": 0.5, "domain_mm": [[-4,-4,-4],[4,4,4]], "solids": [{}]}})", text),
        "tissue"));
    ASSERT_EQ(dense.size, glm::ivec3(81));
    for (int x = 0; x < dense.size.x; ++x) {
      for (int y = 0; y < dense.size.y; ++y) {
        for (int z = 0; z < dense.size.z; ++z) {
          const dvec3 p = dense.frame.to_world(dvec3(x, y, z));
          double least = 1e9, nearest = 3 * dense.frame.voxel;
          Tissue within = Tissue::kAir, beside = Tissue::kAir;
          bool at_border = false, may_show = false;
          for (std::size_t k = 0; k < solids.size(); ++k) {
            const double d = solids[k]->distance(p);
            if (d <= 0) {
              within = kTissues[k];
            } else if (d < nearest) {
              nearest = d;
              beside = kTissues[k];
            }
            least = std::min(least, d);
            const double corner = 0.5 * std::sqrt(3.0) * dense.frame.voxel + 1e-9;
            at_border = at_border || std::abs(d) <= corner;
            may_show = may_show || (d <= corner && dense.tissue[dense.at(x, y, z)] == kTissues[k]);
          }
          const std::size_t i = dense.at(x, y, z);
          ASSERT_EQ(dense.distance[i], static_cast<float>(std::clamp(least, -dense.band, dense.band))) << scene;
          if (!at_border)
            ASSERT_EQ(dense.tissue[i], least <= 0 ? within : beside) << scene;
          else
            ASSERT_TRUE(may_show) << scene;
          borders += at_border;
          deep += least <= -dense.band;
        }
      }
    }
    // The same must hold in the volume, where a tissue beyond the narrow band is stored once per leaf.
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
  EXPECT_GT(borders, 1000);
}

// A label states the tissue of a voxel, but not its fraction. If the label applied at the voxel's middle, borders would
// be wrong by up to half a voxel.
TEST(Sampling, ALayersThicknessUnderABurDoesNotDependOnItsPositionInTheGrid) {
  using namespace literals;
  struct Border {
    const char* what;
    dvec3 n;    // normal, out of the solid
    double at;  // m
  };
  const double radius = 0.5_mm;
  for (const double voxel : {0.1_mm, 0.05_mm}) {
    for (const Border& border :
         {Border{"level", {0, 0, -1}, 0.537_mm}, Border{"tilted", {0.28, 0, -0.96}, 0.471_mm},
          Border{"upright", {-1, 0, 0}, 0.412_mm}, Border{"askew", {0.6, 0.64, -0.48}, 0.318_mm}}) {
      const DenseTissue dense = read_solids(
          Json::parse(fmt::format(R"({{"voxel_mm": {}, "band_mm": 0.5, "domain_mm": [[-2,-2,-2],[2,2,2]], "solids": [
            {{"tissue": "dentin", "solid": {{"box": {{"size_mm": [6,6,6]}}}}}},
            {{"tissue": "enamel", "solid": {{"halfspace": {{"normal": [{},{},{}], "offset_mm": {}}}}}}}]}})",
                                  voxel / kMillimetre, border.n.x, border.n.y, border.n.z, border.at / kMillimetre),
                      "tissue"));
      for (const dvec3& aside : {dvec3(0), dvec3(0.43_mm, -0.7_mm, 0.31_mm), dvec3(-0.6_mm, 0.25_mm, -0.5_mm)}) {
        // axis of a hole across the border
        const dvec3 axis = aside + (border.at - glm::dot(aside, border.n)) * border.n;
        double surplus = 0;  // voxels, surplus of enamel in the hole
        for_each_voxel(dense.size, [&](int x, int y, int z) {
          const dvec3 p = dense.frame.to_world(dvec3(x, y, z));
          const double out = glm::dot(p, border.n) - border.at;
          if (std::abs(out) > voxel || glm::length(p - axis - out * border.n) > radius) return;
          constexpr int kParts = 16;
          int inside = 0;
          for (int part = 0; part < kParts * kParts * kParts; ++part) {
            const dvec3 place =
                (dvec3(part / kParts / kParts, part / kParts % kParts, part % kParts) + 0.5) / double{kParts} - 0.5;
            inside += out + voxel * glm::dot(place, border.n) < 0;
          }
          surplus += (dense.tissue[dense.at(x, y, z)] == Tissue::kEnamel) - inside / std::pow(double{kParts}, 3);
        });
        EXPECT_LT(std::abs(surplus) * std::pow(voxel, 3) / (kPi * radius * radius), 0.05 * voxel)
            << border.what << " " << voxel;
      }
    }
  }
}

}  // namespace
}  // namespace typodont::haptics
