// Tests `typodont render` through the command line: pictures, compared with their matrices. (The
// matrices of random rigs are compared with formulas in property/display_frusta_test.cpp and
// unit/display_rig_test.cpp.)
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "engine/base/json.h"
#include "engine/render/picture.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using glm::dvec3;
using glm::dvec4;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kScene = R"({"tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"center_mm": [1, 2, 3], "radius_mm": 3}}}]},
  "tool": {"shape": "sphere", "diameter_mm": 1.0}, "parts": ["render"]})";

// A desk screen of 60 × 45 mm in the plane z = 0, and a panel that hangs face down over a level mirror.
constexpr const char* kDesk = R"({"display": "offscreen",
  "screen": {"corners_mm": {"lower_left": [-30,-22.5,0], "lower_right": [30,-22.5,0], "upper_left": [-30,22.5,0]},
             "pixels": [640,480], "layout": "LAYOUT"},
  "head": {"eye_center_mm": [5, 10, 400], "ipd_mm": 64}})";
constexpr const char* kMirror = R"({"display": "mirror",
  "screen": {"corners_mm": {"lower_left": [30,60,30], "lower_right": [-30,60,30], "upper_left": [30,60,-15]},
             "pixels": [640,480], "layout": "row_interleaved"},
  "mirror": {"normal": [0,1,0], "offset_mm": 30},
  "head": {"eye_center_mm": [0, 400, 20], "ipd_mm": 64}})";

struct RenderCommand : testing::Test {
  ProgramFolder folder{TYPODONT_PROGRAM};
  RenderCommand() { folder.write("scene.json", kScene); }

  Json render(const std::string& rig, const std::string& more = "") {
    folder.write("rig.json", rig);
    expect_ok(folder.run("render {}/scene.json --rig {}/rig.json --out {}/out --validate " + more));
    return Json::load(folder / "out/frame.json");
  }
  static std::string desk(std::string layout) {
    std::string rig = kDesk;
    return rig.replace(rig.find("LAYOUT"), 6, layout);
  }
};

using Matrix = std::array<double, 16>;
Matrix matrix(const Json& json) {
  const auto n = json.numbers(16);
  Matrix m;
  std::copy(n.begin(), n.end(), m.begin());
  return m;
}
dvec4 times(const Matrix& m, const dvec4& v) {
  dvec4 r(0);
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) r[i] += m[static_cast<std::size_t>(4 * i + k)] * v[k];
  return r;
}

TEST_F(RenderCommand, TheBallIsDrawnWhereTheMatricesProjectIt) {
  for (const std::string& rig : {desk("row_interleaved"), std::string(kMirror)}) {
    const Json frame = render(rig, "--size 800x600");
    EXPECT_EQ(frame["validation_messages"].integer(), 0);
    for (const char* name : {"left", "right"}) {
      const Json eye = frame[name];
      EXPECT_EQ(eye["flip"].boolean(), rig == kMirror) << "a mirror reverses the winding";
      const dvec4 e = times(matrix(eye["view"]), {1, 2, 3, 1}), c = times(matrix(eye["projection"]), e);
      const render::Picture picture = render::read_png(folder / fmt::format("out/{}.png", name));
      ASSERT_EQ(picture.size, glm::ivec2(800, 600));
      double x = 0, y = 0, weight = 0;
      for (int j = 0; j < 600; ++j)
        for (int i = 0; i < 800; ++i)
          if (picture.at(i, j)[0] > 80) x += i + 0.5, y += j + 0.5, ++weight;
      ASSERT_GT(weight, 1000) << name;
      EXPECT_NEAR(2 * x / weight / 800 - 1, c.x / c.w, 4.0 / 800) << name;
      EXPECT_NEAR(2 * y / weight / 600 - 1, c.y / c.w, 4.0 / 600) << name;
    }
  }
}

TEST_F(RenderCommand, TissueOutsideThePictureIsReported) {
  EXPECT_TRUE(render(desk("mono"))["shows_tissue"].boolean());
  std::string scene = kScene;
  const std::string center = "\"center_mm\": [1, 2, 3]";
  folder.write("far.json", scene.replace(scene.find(center), center.size(), "\"center_mm\": [90, 2, 3]"));
  const Ran ran = expect_ok(folder.run("render {}/far.json --rig {}/rig.json --out {}/out"));
  EXPECT_THAT(ran.err, HasSubstr("the tissue, around (90.0, 2.0, 3.0) mm, lies outside the picture"));
  EXPECT_FALSE(Json::load(folder / "out/frame.json")["shows_tissue"].boolean());
}

TEST_F(RenderCommand, AFrameIsDrawnOnceAndNotAgainUntilItChanges) {
  const Json frame = render(desk("side_by_side"));
  EXPECT_TRUE(frame["frame"]["drawn"].boolean());
  EXPECT_GT(frame["frame"]["bricks"]["drawn"].integer(), 0);
  EXPECT_FALSE(frame["unchanged"]["drawn"].boolean());
  EXPECT_EQ(frame["unchanged"]["commands"].integer(), 0);
  EXPECT_EQ(frame["unchanged"]["passes"].integer(), 0);
  EXPECT_EQ(frame["unchanged"]["frames"].integer(), 1);
  const Json timing = frame["timing"];
  EXPECT_GT(timing["record_ms"].number(), 0);
  EXPECT_GT(timing["gpu_ms"].number(), 0);
  EXPECT_NEAR(timing["frames_per_second"].number() * timing["frame_ms"].number(), 1e3, 1e-6);
}

TEST_F(RenderCommand, EveryLayoutWritesItsScreenPictureAndMonoHasOneView) {
  const std::pair<const char*, glm::ivec2> layouts[] = {{"mono", {200, 150}},
                                                        {"side_by_side", {400, 150}},
                                                        {"top_bottom", {200, 300}},
                                                        {"row_interleaved", {200, 150}},
                                                        {"anaglyph", {200, 150}},
                                                        {"two_outputs", {400, 150}},
                                                        {"frame_sequential", {200, 300}}};
  for (const auto& [layout, size] : layouts) {
    const Json frame = render(desk(layout), "--size 200x150");
    EXPECT_EQ(render::read_png(folder / "out/screen.png").size, size) << layout;
    EXPECT_EQ(render::read_png(folder / "out/right.png").size, glm::ivec2(200, 150)) << layout;
    EXPECT_EQ(frame["frame"]["views"].integer(), std::string(layout) == "mono" ? 1 : 2);
  }
}

TEST_F(RenderCommand, ViewsForTeachingAreDrawnAndNameMissingInput) {
  for (const char* view : {"--view section", "--view section --plane 0,0,-1,-2", "--view xray"}) {
    const Json frame = render(desk("mono"), view);
    EXPECT_TRUE(frame["frame"]["drawn"].boolean()) << view;
    EXPECT_EQ(frame["validation_messages"].integer(), 0) << view;
    EXPECT_THAT(view, HasSubstr(frame["view"].string()));
  }
  const auto refused = [&](const std::string& more) {
    return folder.run("render {}/scene.json --rig {}/rig.json --out {}/none " + more);
  };
  EXPECT_THAT(refused("--view difference").err, HasSubstr("--ideal"));
  EXPECT_THAT(refused("--view temperature").err, HasSubstr("\"heat\""));
  EXPECT_THAT(refused("--view section --plane 0,0,0,1").err, HasSubstr("--plane"));
  EXPECT_EQ(refused("--view inside").status, 2);
}

TEST_F(RenderCommand, ASectionRunsAlongTheToothThroughItsPulp) {
  // The canal is 1.5 mm in front of the tooth's middle. The viewer looks along -z, at the buccal side.
  folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"box": {"size_mm": [8, 14, 6]}}},
    {"tissue": "pulp", "solid": {"cylinder": {"center_mm": [0, 0, 1.5], "axis": [0, 1, 0], "radius_mm": 0.5, "height_mm": 11}}}]},
    "tooth": {"mesial": [1, 0, 0], "buccal": [0, 0, 1]},
    "tool": {"shape": "sphere", "diameter_mm": 1.0}, "parts": ["render"]})");
  const auto red = [&](const std::string& view) {
    render(desk("mono"), view);
    const render::Picture picture = render::read_png(folder / "out/right.png");
    int count = 0;
    for (std::size_t i = 0; i + 2 < picture.rgba.size(); i += 4)
      count += picture.rgba[i] > 60 && 5 * picture.rgba[i] > 8 * picture.rgba[i + 1];
    return count;
  };
  EXPECT_GT(red("--view section"), 500);
  EXPECT_EQ(red("--view section --plane 0,0,-1,0"), 0) << "through the middle";
}

TEST_F(RenderCommand, TheGeometryIsTheDrawnBodyInMillimetresOfTheWorkbench) {
  const Json frame = render(desk("mono"), "--geometry");
  const std::string file = read_text(folder / "out/geometry.ply");
  const std::string end = "end_header\n";
  const std::size_t header = file.find(end) + end.size();
  std::size_t vertices = 0, triangles = 0;
  ASSERT_EQ(std::sscanf(file.c_str() + file.find("element vertex"), "element vertex %zu", &vertices), 1);
  ASSERT_EQ(std::sscanf(file.c_str() + file.find("element face"), "element face %zu", &triangles), 1);
  EXPECT_THAT(file.substr(0, header), HasSubstr("comment tissue 1 enamel\ncomment tissue 2"));
  EXPECT_THAT(file.substr(0, header), HasSubstr("comment origin 0 "));
  constexpr std::size_t kVertex = 6 * 4 + 4 + 3 * 4 + 3 * 4, kTriangle = 1 + 3 * 4;
  ASSERT_EQ(file.size(), header + vertices * kVertex + triangles * kTriangle);
  EXPECT_GT(triangles, 100u);
  // Every vertex must lie on the ball of the scene, with a normal that points outwards, and must be enamel of the
  // tooth.
  for (std::size_t v = 0; v < vertices; ++v) {
    float p[6];
    std::memcpy(p, file.data() + header + v * kVertex, sizeof p);
    const dvec3 away = dvec3(p[0], p[1], p[2]) - dvec3(1, 2, 3), normal(p[3], p[4], p[5]);
    ASSERT_NEAR(glm::length(away), 3, 0.05);
    ASSERT_GT(glm::dot(glm::normalize(away), normal), 0.95);
    const char* const tissue = file.data() + header + v * kVertex + sizeof p;
    ASSERT_EQ(tissue[0], 0);  // the working tooth
    ASSERT_EQ(tissue[1], 1);  // enamel
  }
  const auto lamp = frame["light"]["toward_lamp"].vec3();
  EXPECT_NEAR(glm::length(lamp), 1, 1e-9);
  EXPECT_GT(lamp.z, 0);  // above the desk
  EXPECT_EQ(frame["colors"]["enamel"].numbers(3).size(), 3u);
}

TEST_F(RenderCommand, BadInputExitsWithTwoAndLeavesNoFile) {
  const auto refuse = [&](const std::string& arguments, const testing::Matcher<std::string>& message) {
    const Ran ran = folder.run("render {}/scene.json --out {}/none " + arguments);
    EXPECT_EQ(ran.status, 2) << arguments << ran.err;
    EXPECT_THAT(ran.err, message);
    EXPECT_EQ(ran.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder / "none")) << arguments;
  };
  folder.write("rig.json", desk("cross_eyed"));
  refuse("--rig {}/rig.json", AllOf(HasSubstr("rig.json"), HasSubstr("screen.layout"), HasSubstr("cross_eyed"),
                                    HasSubstr("row_interleaved")));
  refuse("--rig nowhere.json", HasSubstr("nowhere.json"));
  refuse("--size 12x", AllOf(HasSubstr("--size"), HasSubstr("12x")));
  refuse("--at 3", HasSubstr("--pose"));
  refuse("--geometry --view section --plane 0,0,1,3", AllOf(HasSubstr("--geometry"), HasSubstr("--view look")));
  refuse("--finished --volume {}/any.vdb", AllOf(HasSubstr("--finished"), HasSubstr("--volume")));
  refuse("--pose {}/missing.csv", HasSubstr("missing.csv"));
}

TEST_F(RenderCommand, AHandpieceIsDrawnAsTheSceneSaysAndAMistakeIsRefused) {
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,1,2,6.5,1,0,0,0,0\n1,1,2,6.5,1,0,0,0,0\n");
  const auto differing = [&](const std::string& a, const std::string& b) {
    const auto drawn = [&](const std::string& shown) {
      std::string scene = kScene;
      scene.insert(1, fmt::format(R"("handpieces": {{"shown": "{}"}}, )", shown));
      folder.write("scene.json", scene);
      const Json frame = render(desk("mono"), "--pose {}/hand.csv --quality fast");
      EXPECT_EQ(frame["validation_messages"].integer(), 0);
      return render::read_png(folder / "out/left.png");
    };
    const render::Picture first = drawn(a), second = drawn(b);
    int pixels = 0;
    for (std::size_t i = 0; i < first.rgba.size(); i += 4)
      pixels += std::abs(first.rgba[i] - second.rgba[i]) > 20 ? 1 : 0;
    return pixels;
  };
  EXPECT_GT(differing("none", "solid"), 5000);
  EXPECT_GT(differing("open", "solid"), 300) << "the opening around the working point";
  EXPECT_LT(differing("open", "solid"), 4000);
  std::string scene = kScene;
  scene.insert(1, R"("handpieces": {"shown": "yes"}, )");
  folder.write("scene.json", scene);
  expect_exit(folder.run("render {}/scene.json --rig {}/rig.json --out {}/out"), 2,
              R"("handpieces.shown": found "yes", expected "open", "solid" or "none")");
}

}  // namespace
}  // namespace typodont
