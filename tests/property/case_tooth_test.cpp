// Parametric teeth of engine/app/cases against the published table, over many seeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <tuple>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/cases/draft.h"
#include "engine/app/cases/pocket_gum.h"
#include "engine/app/cases/scanned_tooth.h"
#include "engine/app/scene.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/render/look.h"
#include "haptics/tissue_volume.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

constexpr int kSeeds = 200;
constexpr double kAge = 35;

TEST(CaseTooth, SizesOfAllSixteenTypesHaveThePublishedMeansAndDeviations) {
  const Json table = Json::load(assets_folder() / "cases" / "teeth.json")["teeth"];
  ASSERT_EQ(tooth_types().size(), 16u);
  for (const std::string& type : tooth_types()) {
    double sum = 0, squares = 0, crown = 0, root = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SplitMix64 random{seed};
      const CaseTooth tooth = make_tooth(type, kAge, random);
      sum += tooth.md / kSeeds, squares += tooth.md * tooth.md / kSeeds;
      crown += tooth.crown / kSeeds, root += tooth.root / kSeeds;
    }
    const Json row = table[type];
    const double sd = row["size_sd"].number(), error = 4 * sd / std::sqrt(double(kSeeds));
    const double mean = row["md_mm"].number() * kMillimetre;
    EXPECT_NEAR(sum / mean, 1, error) << type;
    EXPECT_NEAR(crown / (row["crown_mm"].number() * kMillimetre), 1, error) << type;
    EXPECT_NEAR(root / (row["root_mm"].number() * kMillimetre), 1, error) << type;
    EXPECT_NEAR(std::sqrt(squares - sum * sum) / mean, sd, 0.35 * sd) << type;
  }
}

TEST(CaseTooth, TheSampledCrownHasTheSizesOfItsTooth) {
  constexpr double kVoxel = 0.25e-3;
  for (const std::string& type : tooth_types()) {
    SplitMix64 random{7};
    const CaseTooth tooth = make_tooth(type, kAge, random);
    const haptics::DenseTissue tissue = sample_tooth(tooth, kVoxel);
    dvec3 low(1), high(-1);
    for_each_voxel(tissue.size, [&](int x, int y, int z) {
      const std::size_t i = tissue.at(x, y, z);
      if (tissue.distance[i] > 0) return;
      const dvec3 p = tissue.frame.to_world(dvec3(x, y, z));
      high.z = std::max(high.z, p.z);
      if (tissue.tissue[i] != Tissue::kEnamel) low.z = std::min(low.z, p.z);
      if (p.z > 0) low.x = std::min(low.x, p.x), high.x = std::max(high.x, p.x);
    });
    EXPECT_NEAR(high.x - low.x, tooth.md, 0.6e-3) << type;
    EXPECT_NEAR(high.z, tooth.crown, 0.8e-3) << type;
    EXPECT_NEAR(-low.z, tooth.root, 1.2e-3) << type;
  }
}

/// Number of cusps: maxima of the chewing surface that stand at least 0.1 mm above the saddle to a higher one.
int cusps_of(const CaseTooth& tooth) {
  constexpr double kStep = 0.2e-3, kProminence = 0.1e-3;  // m
  const int nx = static_cast<int>(tooth.md / kStep), ny = static_cast<int>(tooth.bl / kStep);
  std::vector<double> height;
  for (int i = 0; i < nx * ny; ++i)
    height.push_back(tooth.surface((i / ny - 0.5 * nx) * kStep, (i % ny - 0.5 * ny) * kStep));
  // From the top downwards, each place joins the hills beside it; the lower one of two hills ends at their saddle.
  std::vector<int> order(height.size()), hill(height.size(), -1);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int a, int b) { return height[a] > height[b]; });
  const auto top = [&](int i) {
    while (hill[i] != i) i = hill[i];
    return i;
  };
  int cusps = 1;  // the highest one ends at no saddle
  for (const int i : order) {
    hill[i] = i;
    for (int k = 0; k < 9; ++k) {
      const int x = i / ny + k / 3 - 1, y = i % ny + k % 3 - 1, j = x * ny + y;
      if (x < 0 || x >= nx || y < 0 || y >= ny || hill[j] < 0) continue;
      int low = top(i), high = top(j);
      if (low == high) continue;
      if (height[low] > height[high]) std::swap(low, high);
      cusps += height[low] - height[i] > kProminence;
      hill[low] = high;
    }
  }
  return cusps;
}

TEST(CaseTooth, CrownsHaveTheirNumberOfCuspsAndUnbrokenMarginalRidges) {
  const std::map<std::string, int> cusps{{"U3", 1}, {"U4", 2}, {"U5", 2}, {"U6", 4}, {"U7", 4}, {"U8", 3},
                                         {"L3", 1}, {"L5", 3}, {"L6", 5}, {"L7", 4}, {"L8", 5}};
  for (const auto& [type, number] : cusps)
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SplitMix64 random{seed};
      const CaseTooth tooth = make_tooth(type, kAge, random);
      EXPECT_EQ(cusps_of(tooth), number) << type << seed;
      if (number == 1) continue;
      // From the buccal to the lingual side, every path over a marginal ridge stays above the pit inside.
      for (const double side : {1.0, -1.0}) {
        double lowest = 1;
        for (double y = -0.2 * tooth.bl; y <= 0.2 * tooth.bl; y += 0.1e-3) {
          double ridge = 0;
          for (double x = 0.25; x < 0.5; x += 0.01) ridge = std::max(ridge, tooth.surface(side * x * tooth.md, y));
          lowest = std::min(lowest, ridge);
        }
        double pit = 1;
        for (double x = 0.05; x < 0.35; x += 0.01) {
          const double at = side * x * tooth.md;
          pit = std::min(pit, tooth.surface(at, tooth.fissure(at)));
        }
        EXPECT_GT(lowest, pit + 0.1e-3) << type << seed << " at " << side;
      }
    }
}

/// Half the width of the crown at the height z along a direction from the axis, m.
double reach(const CaseTooth& tooth, const glm::dvec2& along, const glm::dvec2& from, double z) {
  double low = 0, high = tooth.bl;
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    (tooth.distance(dvec3(from + middle * along, z)) < 0 ? low : high) = middle;
  }
  return low;
}

TEST(CaseTooth, MesialAndDistalSidesDifferAsTextBooksState) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto made = [&](const std::string& type) {
      SplitMix64 random{seed};
      return make_tooth(type, kAge, random);
    };
    // The distal corner of the edge is lower and rounder; the lower central incisor is symmetric.
    const auto corner = [&](const std::string& type) {
      const CaseTooth tooth = made(type);
      const double x = 0.44 * tooth.md;
      const auto edge = [&](double at) {
        double best = 0;
        for (double y = -0.3 * tooth.bl; y < 0.3 * tooth.bl; y += 0.1e-3) best = std::max(best, tooth.surface(at, y));
        return best;
      };
      return (edge(x) - edge(-x)) / tooth.crown;
    };
    for (const char* type : {"U1", "U2", "U3", "L2", "L3"}) EXPECT_GT(corner(type), 0.01) << type << seed;
    EXPECT_GT(corner("U2"), corner("U1")) << seed;
    EXPECT_NEAR(corner("L1"), 0, 0.005) << seed;
    for (const char* type : {"U6", "U7", "U8", "L6", "L7", "L8"}) {
      const CaseTooth tooth = made(type);
      const double z = tooth.form.proximal, x = 0.3 * tooth.md;
      const auto wide = [&](double at) { return reach(tooth, {0, 1}, {at, 0}, z) + reach(tooth, {0, -1}, {at, 0}, z); };
      EXPECT_GT(wide(x), 1.02 * wide(-x)) << type << seed << ": narrower at the distal side";
      if (type[0] == 'L') continue;
      const auto diagonal = [&](const glm::dvec2& to) {
        return reach(tooth, glm::normalize(to), {0, 0}, z) + reach(tooth, -glm::normalize(to), {0, 0}, z);
      };
      EXPECT_GT(diagonal({1, 1}), 1.05 * diagonal({1, -1})) << type << seed << ": a rhomboid, acute at mesiobuccal";
    }
    for (const char* type : {"U4", "L4"}) {
      const CaseTooth tooth = made(type);
      const double z = 0.4 * tooth.crown, y = 0.25 * tooth.bl, lean = tooth.form.lean * z;
      const auto wide = [&](double at) {
        return reach(tooth, {1, 0}, {0, at - lean}, z) + reach(tooth, {-1, 0}, {0, at - lean}, z);
      };
      EXPECT_GT(wide(y), 1.02 * wide(-y)) << type << seed << ": narrower at the lingual side";
    }
  }
}

TEST(CaseTooth, RootsHaveTheirNumberAndContinueTheTrunkWithoutASwelling) {
  const std::map<std::string, int> roots{{"U1", 1}, {"U3", 1}, {"U4", 2}, {"U5", 1}, {"U6", 3}, {"U7", 3},
                                         {"L1", 1}, {"L3", 1}, {"L5", 1}, {"L6", 2}, {"L7", 2}};
  constexpr double kVoxel = 0.2e-3;
  for (const auto& [type, number] : roots)
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      SplitMix64 random{seed};
      const CaseTooth tooth = make_tooth(type, kAge, random);
      const int nx = static_cast<int>(1.4 * tooth.md / kVoxel), ny = static_cast<int>(1.4 * tooth.bl / kVoxel);
      double last = 1;  // m, width along y, 0.5 mm higher
      for (double z = -0.5e-3; z > -0.8 * tooth.root; z -= 0.5e-3) {
        std::vector<bool> solid;
        for (int i = 0; i < nx * ny; ++i)
          solid.push_back(tooth.distance({(i / ny - 0.5 * nx) * kVoxel, (i % ny - 0.5 * ny) * kVoxel, z}) < 0);
        int low = ny, high = 0, parts = 0;
        for (int i = 0; i < nx * ny; ++i)
          if (solid[i]) low = std::min(low, i % ny), high = std::max(high, i % ny);
        // Roots of upper molars diverge; others taper.
        const double wide = (high - low) * kVoxel;
        if (number < 3) {
          EXPECT_LE(wide, last + 1.01 * kVoxel) << type << seed << " at " << z;
        }
        last = wide;
        if (z - 0.5e-3 > -0.8 * tooth.root) continue;
        for (int i = 0; i < nx * ny; ++i) {
          if (!solid[i]) continue;
          ++parts;
          std::vector<int> open{i};
          solid[i] = false;
          while (!open.empty()) {
            const int at = open.back(), x = at / ny, y = at % ny;
            open.pop_back();
            for (const auto& [u, v] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}})
              if (u >= 0 && u < nx && v >= 0 && v < ny && solid[u * ny + v]) {
                solid[u * ny + v] = false;
                open.push_back(u * ny + v);
              }
          }
        }
        EXPECT_EQ(parts, number) << type << seed;
      }
    }
}

TEST(CaseTooth, EachRootOfAMolarBendsByTheAngleAndItsCanalFollows) {
  const double curvature = glm::radians(40.0);
  for (const char* type : {"U6", "U7", "L6", "L7"}) {
    SplitMix64 random{7};
    const CaseTooth tooth = make_tooth(type, kAge, random, curvature);
    ASSERT_GE(tooth.roots.size(), 4u) << type;
    for (std::size_t k = 0; k < tooth.roots.size(); k += 2) {
      const TaperedTube &upper = tooth.roots[k], &lower = tooth.roots[k + 1];
      const dvec3 a = glm::normalize(upper.b - upper.a), b = glm::normalize(lower.b - lower.a);
      EXPECT_NEAR(std::acos(glm::dot(a, b)), curvature, 0.02) << type;
      EXPECT_LT(b.x, a.x) << type << ": to distal";
      EXPECT_EQ(tooth.tissue(glm::mix(lower.a, lower.b, 0.5)), Tissue::kPulp) << type;
      EXPECT_LT(tooth.distance(lower.b), 0) << type;
    }
  }
}

TEST(CaseTooth, AProbesBallFitsIntoEachPocketDownToItsFloorWhichIsGum) {
  constexpr double kBall = 0.25e-3;  // m, radius
  for (const char* type : {"U1", "U6", "U7", "L6", "L7"})
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      SplitMix64 random{seed};
      const CaseTooth tooth = make_tooth(type, kAge, random);
      PocketGum gum(tooth);
      for (const double side : {1.0, -1.0})
        for (const double along : {-0.36, 0.36})
          gum.add_pocket(along * tooth.form.neck.x, side, (1 + 7 * uniform(random)) * 1e-3, 0.6e-3);
      for (const Pocket& pocket : gum.pockets) {
        // At each height, some place in the plane of the pocket has room for the ball. Distances are too small by up to
        // 20 %.
        for (double z = pocket.floor.z + kBall; z < pocket.margin.z; z += 0.25e-3) {
          double room = 0;
          for (double out = -3e-3; out < 1e-3; out += 0.02e-3) {
            const dvec3 p = dvec3(pocket.margin.x, pocket.margin.y, z) + out * pocket.out;
            room = std::max(room, std::min(tooth.distance(p), gum.distance(p)));
          }
          EXPECT_GT(room, 0.75 * kBall) << type << seed << " at " << (pocket.margin.z - z) * 1e3 << " mm";
        }
        EXPECT_LT(gum.distance(pocket.floor - dvec3(0, 0, 0.2e-3)), 0) << type << seed;
      }
    }
}

// The scan is turned and shifted.
TEST(CaseTooth, AScanOfAToothHasTheMeasuresOfThatTooth) {
  const glm::dmat3 turn{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  const dvec3 shift(3e-3, -2e-3, 40e-3);
  const test::Folder folder;
  for (const char* type : {"U1", "U4", "L6"}) {
    SplitMix64 random{7};
    const CaseTooth tooth = make_tooth(type, kAge, random);
    haptics::DenseTissue tissue = turned(sample_tooth(tooth, 0.15e-3), turn);
    tissue.frame.origin += shift;
    haptics::TissueVolume(tissue).save(folder / "tooth.vdb");
    std::ofstream(folder / "scan.json") << R"({"tissue": {"volume": "tooth.vdb"}, "parts": ["haptics"],
      "tool": {"shape": "sphere", "diameter_mm": 1}, "tooth": {"mesial": [0, 1, 0], "buccal": [0, 0, 1]}})";
    const CaseTooth scan = scanned_tooth(type, folder / "scan.json");
    const auto near = [&](double is, double should, double within) { EXPECT_NEAR(is, should, within) << type; };
    near(scan.md, tooth.md, 0.4e-3);
    near(scan.crown + scan.root, tooth.crown + tooth.root, 0.8e-3);
    near(scan.form.proximal / scan.crown, tooth.form.proximal / tooth.crown, 0.25);
    near(scan.crown, tooth.crown, 0.9e-3);  // near its edge, the enamel is thinner than a voxel
    near(scan.cej_mesial, tooth.cej_mesial, 0.6e-3);
    // Surfaces and pulps agree, up to the place of the origin.
    const dvec3 from(0, 0, tooth.crown - scan.crown);
    for (const dvec3& p : {dvec3(0, 0, 0.5e-3), dvec3(1e-3, 0.5e-3, 2e-3), dvec3(0, -1e-3, -2e-3)}) {
      near(scan.pulp_distance(p - from), tooth.pulp_distance(p), 0.35e-3);
      near(scan.surface(p.x, p.y), tooth.surface(p.x, p.y) - from.z, 0.5e-3);  // grooves are steep
    }
  }
}

TEST(CaseLesion, ItsDepthFollowsItsIcdasCodeThroughEnamelAndDentin) {
  for (const Layers& layers : {Layers{1.1e-3, 3.2e-3}, Layers{0.4e-3, 1.5e-3}}) {
    double last = 0;
    for (int code = 1; code <= 6; ++code)
      for (const double within : {0.01, 0.5, 1.0}) {
        const double depth = lesion_depth(code, within, layers);
        EXPECT_GT(depth, last) << code;
        EXPECT_EQ(icdas_of(depth, layers), code);
        last = depth;
      }
    EXPECT_NEAR(lesion_depth(1, 1, layers), 0.5 * layers.enamel, 1e-9);
    EXPECT_NEAR(lesion_depth(2, 1, layers), layers.enamel, 1e-9);
    EXPECT_NEAR(lesion_depth(3, 1, layers), layers.enamel + layers.dentin / 3, 1e-9);
    EXPECT_NEAR(lesion_depth(4, 1, layers), layers.enamel + layers.dentin * 2 / 3, 1e-9);
    EXPECT_LT(last, layers.enamel + layers.dentin);
  }
}

/// A lesion through 1 mm of enamel into dentin.
Lesion coded(int icdas) {
  Lesion lesion{.top = 2e-3, .border = 1e-3, .depth = 2.5e-3, .opening = 0.3e-3, .width = 1e-3};
  lesion.icdas = icdas;
  return lesion;
}

TEST(CaseLesion, CariesIsSofterWithTheCodeAndHardensFromTheAxisToTheEdge) {
  const double below = 0.9999e-3;
  for (int code = 1; code <= 6; ++code) {
    const Lesion lesion = coded(code);
    const auto axis = [&](double down) { return lesion.at({0, 0, 2e-3 - down}, Tissue::kDentin).hardness; };
    if (code > 1) {
      EXPECT_LE(axis(below), coded(code - 1).at({0, 0, 2e-3 - below}, Tissue::kEnamel).hardness) << code;
    }
    EXPECT_NEAR(axis(below), axis(1.0001e-3), 1e-3) << code << ": no step at the border of enamel and dentin";
    EXPECT_NEAR(axis(2.4999e-3), 0.9, 1e-3) << code << ": firm at the front";
    // Across enamel, across dentin and along the axis: harder up to the edge, affected beyond it, then sound.
    for (const auto& [from, along, sound] : {std::tuple{dvec3(0, 0, 1.5e-3), dvec3(1, 0, 0), Tissue::kEnamel},
                                             std::tuple{dvec3(0, 0, 0.6e-3), dvec3(0, 1, 0), Tissue::kDentin},
                                             std::tuple{dvec3(0, 0, 1e-3), dvec3(0, 0, -1), Tissue::kDentin}}) {
      double last = 0, last_affected = 0;
      for (double way = 0; way < 2.2e-3; way += 0.02e-3) {
        const Lesion::Point here = lesion.at(from + way * along, sound);
        double& before = here.tissue == Tissue::kCaries ? last : last_affected;
        EXPECT_GE(here.hardness, before - 1e-9) << code << " at " << way;
        EXPECT_TRUE(here.tissue == sound || last_affected == 0) << code << ": one edge";
        before = here.hardness;
      }
      EXPECT_EQ(last_affected, 1) << code;
    }
  }
  // Shimizu 2015: enamel of code 3 has a tenth of its hardness; caries has 0.3 of enamel's stiffness.
  EXPECT_NEAR(coded(3).at({0, 0, 2e-3}, Tissue::kEnamel).hardness * 0.3, 0.1, 0.01);
  EXPECT_NEAR(coded(1).at({0.3001e-3, 0, 2e-3}, Tissue::kEnamel).hardness, 0.7, 0.01);
}

TEST(CaseLesion, SoftensNoTissueFarAwayEvenIfItHardlyReachesDentin) {
  SplitMix64 random{5};
  for (const double deep : {0.0, 1e-6, 0.02e-3, 0.5e-3}) {
    Lesion lesion = coded(3);
    lesion.depth = lesion.border + deep;
    for (int i = 0; i < 2000; ++i) {
      const dvec3 p(4e-3 * uniform(random), 4e-3 * uniform(random), lesion.top - 4e-3 * uniform(random));
      const bool far =
          std::hypot(p.x, p.y) > lesion.width + lesion.affected || lesion.top - p.z > lesion.depth + lesion.affected;
      EXPECT_TRUE(!far || lesion.at(p, Tissue::kDentin).hardness == 1) << deep;
    }
  }
}

TEST(CaseLesion, ItsColourIsDarkestWhereItIsSoftestAndTheEnamelBesideItIsWhiterThanSound) {
  const MaterialTable materials = read_scene("remove-caries").servo.materials;
  const auto light = [&](const Lesion::Point& point) {
    const dvec3 own = render::linear_light(materials[static_cast<std::size_t>(point.tissue)].color);
    return glm::dot(render::painted_color(own, render::decay_paint(point.tissue, point.hardness)),
                    dvec3(0.2126, 0.7152, 0.0722));
  };
  const double enamel = light({Tissue::kEnamel, 1}), dentin = light({Tissue::kDentin, 1});
  for (int code = 3; code <= 6; ++code) {
    const Lesion lesion = coded(code);
    double last = 0;
    for (double way = 0; way < 2.2e-3; way += 0.02e-3) {
      const double here = light(lesion.at({way, 0, 0.8e-3}, Tissue::kDentin));
      EXPECT_GE(here, last) << code << " at " << way;
      last = here;
    }
    EXPECT_EQ(last, dentin);
    EXPECT_LT(light(lesion.at({0, 0, 1.9e-3}, Tissue::kEnamel)), 0.5 * dentin) << code << ": a stained entrance";
    EXPECT_GT(light(lesion.at({0.4e-3, 0, 2e-3}, Tissue::kEnamel)), 1.1 * enamel) << code << ": a chalky rim";
  }
}

TEST(CaseTooth, ThePulpIsInsideDentinOnlyAndShrinksWithAge) {
  for (const std::string& type : tooth_types()) {
    std::array<double, 2> volume{};
    for (const int old : {0, 1}) {
      SplitMix64 random{11};
      const CaseTooth tooth = make_tooth(type, old ? 60 : 20, random);
      const haptics::DenseTissue tissue = sample_tooth(tooth, 0.3e-3);
      for (std::size_t i = 0; i < tissue.tissue.size(); ++i) {
        if (tissue.tissue[i] != Tissue::kPulp) continue;
        EXPECT_LT(tissue.distance[i], -0.2e-3) << type;
        ++volume[static_cast<std::size_t>(old)];
      }
    }
    EXPECT_GT(volume[0], 1.15 * volume[1]) << type;
  }
}

}  // namespace
}  // namespace typodont
