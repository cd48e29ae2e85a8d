// Tests light that travels inside tissue, against analytic cases.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "engine/render/light_passes.h"
#include "engine/render/look.h"
#include "engine/render/tissue_light.h"
#include "tests/support/default_colors.h"
#include "tests/support/lit_box.h"

namespace typodont::test {
namespace {

// These tests compute the light themselves: no file can be created in this folder.
[[maybe_unused]] const int g_no_cache = setenv("TYPODONT_CACHE", "/proc/self", 1);

using render::LitTriangle;
using render::TissueLight;

// m, edges of a cell, and numbers of random walks, of a usual and of the best quality level
constexpr double kCell = 0.3e-3, kFineCell = 0.15e-3;
constexpr int kWalks = 64, kFineWalks = 192;
constexpr float kPath = 0.6e-3f;  // m, mean free path of the tissue in the tests
const std::array<render::Look, render::kMatterCount> kLooks = render::appearances_of(render::default_colors());

std::vector<LitTriangle> box_of(const glm::vec3& lo, const glm::vec3& hi, const glm::vec3& color) {
  std::vector<LitTriangle> all;
  add_box(all, lo, hi, color, kPath);
  return all;
}
/// Returns a grid with the same light from all directions.
render::LightGrid uniform(const glm::vec3& light) {
  render::LightGrid grid{.origin = dvec3(-20e-3), .spacing = 40e-3, .size = glm::ivec3(2), .faces = {}, .images = {}};
  grid.faces.assign(render::LightGrid::kFaces * grid.samples(), glm::vec4(light, 1));
  grid.images.assign(grid.samples() * render::LightGrid::kImageSide * render::LightGrid::kImageSide, light);
  return grid;
}
render::LightSources lamp_above() {
  render::LightSources sources;
  sources.toward_lamp = {0, 0, 1};
  sources.lamp = glm::vec3(1);
  return sources;
}
/// Returns the light of the grid at a point, interpolated as in the shaders.
glm::vec4 at(const render::TissueLightGrid& grid, const dvec3& p) {
  const glm::vec3 q((p - grid.origin) / grid.spacing);
  const glm::ivec3 low(glm::floor(q));
  const glm::vec3 f = q - glm::vec3(low);
  glm::vec4 sum(0);
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 bit(k & 1, (k >> 1) & 1, k >> 2), i = low + bit;
    const glm::vec3 w = glm::mix(1.0f - f, f, glm::vec3(bit));
    sum += w.x * w.y * w.z * grid.values[static_cast<std::size_t>((i.x * grid.size.y + i.y) * grid.size.z + i.z)];
  }
  return sum;
}
/// Returns the mean light of points on the plane z = `height`, from x = `from` to x = `to`.
glm::vec4 mean(const render::TissueLightGrid& grid, double height, double from, double to) {
  constexpr int kPoints = 400;
  glm::vec4 sum(0);
  for (int i = 0; i < kPoints; ++i)
    sum += at(grid, {glm::mix(from, to, (i + 0.5) / kPoints), -1.5e-3 + 3e-3 * std::fmod(0.618 * i, 1.0), height});
  return sum / float{kPoints};
}
TissueLight scene_of(std::vector<LitTriangle> body, bool fine = false) {
  TissueLight light({dvec3(-6e-3, -6e-3, -6e-3), dvec3(6e-3, 6e-3, 4e-3)}, fine ? kFineCell : kCell,
                    fine ? kFineWalks : kWalks, kLooks);
  light.add_fixed(std::move(body), true);
  return light;
}

/// Returns the fraction of diffuse light that a thick layer of isotropically scattering tissue reflects, by
/// Chandrasekhar's H function (Radiative Transfer, 1950): R = 1 - 2 sqrt(1 - albedo) ∫ H(μ) μ dμ.
double reflectance_of(double albedo) {
  constexpr int kSteps = 200;
  std::array<double, kSteps> h;
  h.fill(1);
  for (int turn = 0; turn < 400; ++turn)
    for (int i = 0; i < kSteps; ++i) {
      double sum = 0;
      for (int k = 0; k < kSteps; ++k) sum += (k + 0.5) * h[static_cast<std::size_t>(k)] / (i + k + 1.0) / kSteps;
      h[static_cast<std::size_t>(i)] = 1 / (std::sqrt(1 - albedo) + 0.5 * albedo * sum);
    }
  double moment = 0;
  for (int k = 0; k < kSteps; ++k) moment += (k + 0.5) / kSteps * h[static_cast<std::size_t>(k)] / kSteps;
  return 1 - 2 * std::sqrt(1 - albedo) * moment;
}

TEST(TissueLight, ThePhotonsSurviveAsOftenAsChandrasekharsReflectanceOfAThickLayerNeeds) {
  for (const double reflectance : {0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9})
    EXPECT_NEAR(reflectance_of(render::scattering_albedo(static_cast<float>(reflectance))), reflectance,
                0.008 * reflectance);
}

TEST(TissueLight, AFlatLayerInUniformLightReflectsWhatItsColourSays) {
  for (const bool fine : {false, true}) {
    TissueLight light =
        scene_of(box_of({-20e-3f, -20e-3f, -20e-3f}, {20e-3f, 20e-3f, 0.1e-3f}, {0.6f, 0.35f, 0.15f}), fine);
    light.light(lamp_above(), uniform({0.8f, 0.5f, 0.3f}));
    const glm::vec4 found = mean(light.grid(), 0.1e-3, -3e-3, 3e-3);
    const glm::vec3 arrives(1.8f, 1.5f, 1.3f);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], arrives[c], 0.03f * arrives[c]) << c;
    EXPECT_NEAR(found.w, 0.65, 0.04) << "fraction of the lamp's light";
  }
}

/// Returns the light on the wall of a slit between two black bodies, at this depth (m), under a uniform sky.
float on_wall_of_slit(double width, double depth, bool fine) {
  const auto half = static_cast<float>(width / 2);
  std::vector<LitTriangle> left = box_of({-5e-3f, -20e-3f, -20e-3f}, {-half, 20e-3f, 0}, glm::vec3(0)),
                           right = box_of({half, -20e-3f, -20e-3f}, {5e-3f, 20e-3f, 0}, glm::vec3(0));
  for (LitTriangle& t : left) t.free_path = glm::vec3(0);
  for (LitTriangle& t : right) t.free_path = glm::vec3(0);
  TissueLight light = scene_of(std::move(left), fine);
  light.add_fixed(std::move(right), true);
  light.light({}, uniform(glm::vec3(1)));
  return mean(light.grid(), -depth, width / 2, width / 2 + 1e-9).x;
}
TEST(TissueLight, TheFineGridLightsANarrowSlitLikeTheSkyThatItsWallSees) {
  constexpr double kWidth = 0.7e-3;
  for (const double depth : {0.5e-3, 1e-3}) {
    const double seen = 0.5 * (1 - depth / std::hypot(depth, kWidth));
    EXPECT_NEAR(on_wall_of_slit(kWidth, depth, true), seen, 0.03) << depth;
  }
}

TEST(TissueLight, AnOpenMeshThatEndsAtTheBorderOfTheGridIsAsBrightAsAClosedOne) {
  // A layer without its sides, as the mesh of gum. It ends 0.3 mm before the border of the grid.
  for (const bool fine : {false, true}) {
    std::vector<LitTriangle> body =
        box_of({-5.7e-3f, -5.7e-3f, -20e-3f}, {5.7e-3f, 5.7e-3f, 0.1e-3f}, {0.6f, 0.35f, 0.15f});
    std::erase_if(body, [](const LitTriangle& t) { return std::abs(t.normals[0].z) < 0.5f; });
    TissueLight light = scene_of(std::move(body), fine);
    light.light({}, uniform(glm::vec3(1)));
    // The mean of two sides has less noise than one.
    const glm::vec4 middle = mean(light.grid(), 0.1e-3, -1e-3, 1e-3),
                    side = 0.5f * (mean(light.grid(), 0.1e-3, 4e-3, 5e-3) + mean(light.grid(), 0.1e-3, -5e-3, -4e-3));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], 1, 0.05f) << c << ", fine " << fine;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(side[c], 1, 0.1f) << c << ", fine " << fine;
  }
}

TEST(TissueLight, ASheetThatEndsInsideTheGridIsAsBrightAsAThickLayer) {
  // The space below the sheet is connected to the space above it, so its deep part counts as outside.
  for (const bool fine : {false, true}) {
    std::vector<LitTriangle> body = box_of({-4e-3f, -4e-3f, -20e-3f}, {4e-3f, 4e-3f, 0.1e-3f}, {0.6f, 0.35f, 0.15f});
    std::erase_if(body, [](const LitTriangle& t) { return t.normals[0].z < 0.5f; });
    TissueLight light = scene_of(std::move(body), fine);
    light.light({}, uniform(glm::vec3(1)));
    const glm::vec4 middle = mean(light.grid(), 0.1e-3, -1e-3, 1e-3);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], 1, 0.06f) << c << ", fine " << fine;
  }
}

TEST(TissueLight, ABodyWithoutAbsorptionIsAsBrightAsItsSurroundingsEverywhere) {
  // A body that loses no light cannot be told from a uniform room: no light is lost or created at edges and corners.
  TissueLight light = scene_of(box_of({-2e-3f, -2e-3f, -2.5e-3f}, {2e-3f, 2e-3f, 0}, glm::vec3(0.999f)));
  render::LightSources dark;
  light.light(dark, uniform(glm::vec3(0.5f)));
  for (const dvec3& p : {dvec3(0, 0, 0), dvec3(2e-3, 0, -1e-3), dvec3(1.9e-3, 1.9e-3, -0.05e-3), dvec3(0, 0, -2.5e-3)})
    EXPECT_NEAR(at(light.grid(), p).x, 0.5, 0.02) << p.x << " " << p.z;
}

TEST(TissueLight, NoPointIsBrighterThanTheLightThatArrivesDividedByTheReflectance) {
  const glm::vec3 color(0.5f, 0.3f, 0.2f);
  TissueLight light = scene_of(box_of({-1e-3f, -1e-3f, -5e-3f}, {1e-3f, 1e-3f, 0}, color));
  light.light(lamp_above(), uniform(glm::vec3(0)));
  for (const glm::vec4& value : light.grid().values)
    for (int c = 0; c < 3; ++c) EXPECT_LE(value[c] * color[c], 1.0001f);
}

TEST(TissueLight, TheBorderOfAShadowIsAsSoftAsInAnIndependentRandomWalk) {
  // A roof hides the lamp where x < 0. Light that enters beside the roof's shadow leaves in the shadow.
  const glm::vec3 color(0.7f);
  std::vector<LitTriangle> body = box_of({-20e-3f, -20e-3f, -20e-3f}, {20e-3f, 20e-3f, 0.1e-3f}, color);
  std::vector<LitTriangle> roof = box_of({-20e-3f, -20e-3f, 3e-3f}, {0, 20e-3f, 3.6e-3f}, glm::vec3(0));
  for (LitTriangle& t : roof) t.free_path = glm::vec3(0);
  TissueLight light = scene_of(std::move(body));
  light.add_fixed(std::move(roof), true);
  light.light(lamp_above(), uniform(glm::vec3(0)));
  // Fractions of the light at a long distance from the border, of a random walk without a grid (numpy, 400,000 walks),
  // at this distance from the border in free paths. The grid rounds the roof's edge by a part of a cell, which moves
  // the border of the shadow. This matters most near the border.
  struct Point {
    double away, expected, tolerance;
  };
  for (const Point& point : {Point{0.95, 0.806, 0.08}, Point{1.95, 0.905, 0.05}}) {
    const double x = point.away * double{kPath};
    EXPECT_NEAR(mean(light.grid(), 0.1e-3, x, x + 1e-9).x, point.expected, point.tolerance) << point.away;
    EXPECT_NEAR(mean(light.grid(), 0.1e-3, -x, -x + 1e-9).x, 1 - point.expected, point.tolerance) << point.away;
  }
}

TEST(TissueLight, ASmallBallReflectsAsMuchAsInAnIndependentRandomWalk) {
  // Light leaves a convex body sooner than a flat layer, so a ball is brighter than its colour says.
  constexpr float kRadius = 2e-3f;
  constexpr int kRings = 80;
  const auto point = [](int i, int j) {
    const double a = kPi * i / kRings, b = kPi * j / kRings;
    return kRadius * glm::vec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
  };
  std::vector<LitTriangle> ball;
  const auto add = [&](const std::array<glm::vec3, 3>& corners) {
    LitTriangle t;
    t.corners = corners;
    for (std::size_t k = 0; k < 3; ++k) t.normals[k] = glm::normalize(corners[k]);
    t.color = {0.75f, 0.37f, 0.125f};
    t.free_path = glm::vec3(0.45e-3f);
    ball.push_back(t);
  };
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < 2 * kRings; ++j) {
      if (i > 0) add({point(i, j), point(i + 1, j), point(i, j + 1)});
      if (i < kRings - 1) add({point(i, j + 1), point(i + 1, j), point(i + 1, j + 1)});
    }
  TissueLight light = scene_of(std::move(ball), true);
  render::LightSources no_lamp = lamp_above();
  no_lamp.lamp = glm::vec3(0);
  light.light(no_lamp, uniform(glm::vec3(1)));
  constexpr int kPoints = 2000;
  glm::dvec3 sum(0);
  for (int i = 0; i < kPoints; ++i) {
    const double z = (2 * i + 1.0) / kPoints - 1, r = std::sqrt(1 - z * z);
    sum += dvec3(glm::vec3(at(light.grid(), double{kRadius} * dvec3(r * std::cos(2.4 * i), r * std::sin(2.4 * i), z))));
  }
  // reflectance divided by the colour, of a random walk in an exact ball (400,000 walks)
  const dvec3 expected(1.222, 1.371, 1.504);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / kPoints, expected[c], 0.02 * expected[c]);
}

/// Returns the mesh of a box of dentin with this top (m).
render::MeshUpdate dentin_box(float top) {
  render::MeshUpdate update;
  for (const LitTriangle& t : box_of({-4e-3f, -4e-3f, -5e-3f}, {4e-3f, 4e-3f, top}, glm::vec3(0.5f)))
    for (std::size_t k = 0; k < 3; ++k) {
      render::Vertex v;
      v.p = t.corners[k], v.n = t.normals[k], v.tissue = {Tissue::kDentin, Tissue::kDentin};
      update.indices.push_back(static_cast<std::uint32_t>(update.vertices.size()));
      update.vertices.push_back(v);
    }
  return update;
}
void cut_to(TissueLight& light, float top) {
  const render::MeshUpdate now = dentin_box(top);
  light.put({&now, 1}, dvec3(0));
}

TEST(TissueLight, AfterACutTheLightIsThatOfABodyThatWasCutFromTheStart) {
  const auto fresh = [&] { return TissueLight({dvec3(-6e-3), dvec3(6e-3)}, kCell, kWalks, kLooks); };
  TissueLight whole = fresh();
  cut_to(whole, -1e-3f);
  whole.light(lamp_above(), uniform(glm::vec3(0.4f)));
  TissueLight cut = fresh();
  for (const float top : {0.0f, -0.3e-3f, -0.6e-3f, -1e-3f}) {
    cut_to(cut, top);
    if (top == 0) cut.light(lamp_above(), uniform(glm::vec3(0.4f)));
    int changes = 0;
    while (!cut.refresh(200).empty()) ++changes;
    EXPECT_EQ(changes > 0, top < 0);
  }
  const glm::vec4 expected = mean(whole.grid(), -1e-3, -3e-3, 3e-3), found = mean(cut.grid(), -1e-3, -3e-3, 3e-3);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.03f * expected[c]);
  EXPECT_GT(expected.x, 0.8f);
}

/// Light with passes on the software renderer. `lost`: the device fails at once.
TissueLight on_device(bool lost) {
  TissueLight light({dvec3(-6e-3), dvec3(6e-3)}, kCell, kWalks, kLooks);
  gpu::Device device = gpu::Device::create({});
  if (lost) device.lose();
  light.use(std::make_unique<render::LightPasses>(std::move(device)));
  return light;
}

TEST(TissueLight, ComputePassesGiveTheLightOfTheProcessorAlsoAfterACut) {
  TissueLight by_processor({dvec3(-6e-3), dvec3(6e-3)}, kCell, kWalks, kLooks), by_passes = on_device(false);
  render::LightGrid far = uniform(glm::vec3(0.4f));
  // Different light from each direction and at each corner of the box.
  for (std::size_t i = 0; i < far.images.size(); ++i) far.images[i] *= 0.5f + static_cast<float>(i % 97) / 97;
  for (std::size_t i = 0; i < far.faces.size(); ++i) far.faces[i].w = static_cast<float>(i % 7) / 7;
  for (TissueLight* const light : {&by_processor, &by_passes}) {
    // A roof hides the lamp from half of the body, and reflects light.
    std::vector<LitTriangle> roof = box_of({-5e-3f, -5e-3f, 2e-3f}, {0, 5e-3f, 3e-3f}, glm::vec3(0.6f));
    light->add_fixed(std::move(roof), false);
    cut_to(*light, 0);
    light->light(lamp_above(), far);
  }
  // Functions such as exp() differ in the last digit, so some walks end elsewhere.
  const auto compare = [&](const char* when) {
    const std::vector<glm::vec4>&a = by_processor.grid().values, &b = by_passes.grid().values;
    ASSERT_EQ(a.size(), b.size());
    double lit = 0, sum = 0, most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const glm::vec4 apart = glm::abs(a[i] - b[i]);
      const double worst = std::max({apart.x, apart.y, apart.z, apart.w});
      lit += a[i] != glm::vec4(0), sum += worst, most = std::max(most, worst);
    }
    EXPECT_GT(lit, 3000) << when;
    EXPECT_LT(sum / lit, 1e-5) << when;
    EXPECT_LT(most, 5e-3) << when;
  };
  compare("at first");
  for (TissueLight* const light : {&by_processor, &by_passes}) {
    cut_to(*light, -0.6e-3f);
    while (!light->refresh(200).empty()) {
    }
  }
  compare("after a cut");
  EXPECT_TRUE(by_passes.on_card());
}

TEST(TissueLight, TheProcessorContinuesIfTheDeviceOfThePassesIsLost) {
  TissueLight by_processor({dvec3(-6e-3), dvec3(6e-3)}, kCell, kWalks, kLooks), by_passes = on_device(true);
  for (TissueLight* const light : {&by_processor, &by_passes}) {
    cut_to(*light, 0);
    light->light(lamp_above(), uniform(glm::vec3(0.4f)));
  }
  EXPECT_FALSE(by_passes.on_card());
  EXPECT_EQ(by_passes.grid().values, by_processor.grid().values);
}

}  // namespace
}  // namespace typodont::test
