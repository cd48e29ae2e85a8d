#include "engine/display/display_rig.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "engine/base/line_of_sight.h"
#include "tests/support/folder.h"

namespace typodont::display {
namespace {

using ::testing::HasSubstr;

Screen worked_screen() {
  return {{-0.26, -0.145, 0}, {0.26, -0.145, 0}, {-0.26, 0.145, 0}, {1920, 1080}, Layout::kSideBySide};
}

TEST(Kooima, WorkedExampleIsReproducedInItsOwnForm) {
  const EyeView eye = eye_view(worked_screen(), {}, {.0315, .02, .6}, {0.1, 2.0});
  const dmat4 p = opengl_projection(eye.frustum);
  EXPECT_NEAR(p[0][0], 2.3076923077, 1e-9);
  EXPECT_NEAR(p[1][1], 4.1379310345, 1e-9);
  EXPECT_NEAR(p[2][0], -0.1211538462, 1e-9);
  EXPECT_NEAR(p[2][1], -0.1379310345, 1e-9);
  EXPECT_NEAR(p[2][2], -1.1052631579, 1e-9);
  EXPECT_NEAR(p[3][2], -0.2105263158, 1e-9);
  EXPECT_EQ(p[2][3], -1.0);
  EXPECT_FALSE(eye.flip);
}

TEST(Kooima, CornersOfTheScreenAreCornersOfThePicture) {
  const Screen s = worked_screen();
  const EyeView eye = eye_view(s, {}, {.1, -.05, .4}, {0.1, 2.0});
  const auto ndc = [&](const dvec3& p) {
    const glm::dvec4 c = eye.projection * eye.view * glm::dvec4(p, 1);
    return glm::dvec3(c) / c.w;
  };
  EXPECT_NEAR(glm::length(dvec2(ndc(s.lower_left)) - dvec2(-1, 1)), 0, 1e-12);
  EXPECT_NEAR(glm::length(dvec2(ndc(s.lower_right)) - dvec2(1, 1)), 0, 1e-12);
  EXPECT_NEAR(glm::length(dvec2(ndc(s.upper_left)) - dvec2(-1, -1)), 0, 1e-12);
}

TEST(Kooima, EyeBehindThePictureIsAnError) {
  EXPECT_THAT(test::refusal([&] {
                (void)eye_view(worked_screen(), {}, {0, 0, -.3}, {});
              }),
              HasSubstr("300.0 mm behind the picture"));
}

TEST(MirrorPlane, ThickGlassMovesThePictureTowardsTheEyeByItsApparentShift) {
  // Looking straight through: t (1 − 1/n).
  Mirror mirror{{0, 1, 0}, 0};
  Screen panel{{-0.26, 0.3, -0.145}, {0.26, 0.3, -0.145}, {-0.26, 0.3, 0.145}, {1920, 1080}, Layout::kMono};
  const dvec3 eye(0, 0.4, 0);
  const EyeView thin = eye_view(panel, mirror, eye, {});
  mirror.glass_thickness = 6e-3;
  mirror.glass_index = 1.5;
  const EyeView thick = eye_view(panel, mirror, eye, {}, glass_shift(panel, mirror, eye));
  const dvec3 shift = dvec3(thick.view[3]) - dvec3(thin.view[3]);
  EXPECT_NEAR(shift.z, 2e-3, 1e-12);  // towards the eye is +z in its frame
  EXPECT_NEAR(std::hypot(shift.x, shift.y), 0, 1e-12);
}

TEST(Warp, ThePixelOnTheLineOfSightToAPointShowsThePlaceOfThisPointInTheEyesPicture) {
  DisplayRig rig = load_rig("assets/rigs/mirror.json");
  EXPECT_FALSE(warp(rig));
  rig.screen.bow = {0.7e-3, -0.5e-3, 0.4e-3};
  rig.mirror->curvature = {0.03, 0.005, 0.05};
  rig.mirror->glass_thickness = 0;  // warp() does not include the glass, which shifts the eye's view
  const auto bent = warp(rig);
  ASSERT_TRUE(bent);
  const Screen& s = rig.screen;
  const sight::Panel<double> panel{sight::vec<double>(s.lower_left), sight::vec<double>(s.lower_right - s.lower_left),
                                   sight::vec<double>(s.upper_left - s.lower_left), sight::vec<double>(s.bow)};
  const auto mirror =
      sight::Mirror<double>::make(sight::vec<double>(rig.mirror->normal), rig.mirror->offset,
                                  sight::vec<double>(rig.mirror->middle), sight::vec<double>(rig.mirror->curvature));
  const auto views = eye_views(rig);
  const Screen image = reflect(*rig.mirror, s);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0.1, 0.9), depth(0.85, 1.1);
  double moved = 0;
  for (int n = 0; n < 400; ++n) {
    const EyeView& eye = views[static_cast<std::size_t>(n % 2)];
    const dvec3 behind = image.lower_left + part(random) * (image.lower_right - image.lower_left) +
                         part(random) * (image.upper_left - image.lower_left);
    const dvec3 p = eye.position + depth(random) * (behind - eye.position);
    const glm::dvec4 clip = eye.projection * eye.view * glm::dvec4(p, 1);
    const dvec2 drawn = 0.5 + 0.5 * dvec2(clip) / clip.w;  // place in the eye's picture
    const auto [u, v] = sight::pixel_through(panel, &mirror, eye.position, p);
    const double x = u * (kWarpSide - 1), y = (1 - v) * (kWarpSide - 1);
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const auto at = [&](int i, int j) {
      return dvec2(
          (*bent)[static_cast<std::size_t>(n % 2)][static_cast<std::size_t>((row + j) * kWarpSide + column + i)]);
    };
    const dvec2 shown =
        glm::mix(glm::mix(at(0, 0), at(1, 0), x - column), glm::mix(at(0, 1), at(1, 1), x - column), y - row);
    EXPECT_LT(glm::distance(shown, drawn), 2e-5) << n;  // a thirtieth of a pixel
    moved = std::max(moved, glm::distance(drawn, dvec2(u, 1 - v)));
  }
  EXPECT_GT(moved, 2e-3);
}

TEST(Upright, WritingIsMirroredInExactlyOneAxisByAMirror) {
  DisplayRig rig;
  EXPECT_EQ(upright(rig), dmat2(1.0));
  // A panel that lies face down above a level mirror, its upper edge away from the user.
  rig.screen = {{-0.26, 0.4, 0.2}, {0.26, 0.4, 0.2}, {-0.26, 0.4, -0.09}, {1920, 1080}, Layout::kSideBySide};
  rig.screen.lower_left = {0.26, 0.4, 0.2};
  rig.screen.lower_right = {-0.26, 0.4, 0.2};
  rig.screen.upper_left = {0.26, 0.4, -0.09};
  rig.mirror = Mirror{{0, 1, 0}, 0};
  rig.head.eye_center = {0, 0.3, 0.4};
  const dmat2 u = upright(rig);
  EXPECT_EQ(glm::determinant(u), -1);
  EXPECT_TRUE(eye_views(rig)[0].flip);
}

constexpr const char* kExample = R"({ "display": "mirror",
  "screen": { "corners_mm": { "lower_left": [260,400,200], "lower_right": [-260,400,200], "upper_left": [260,400,-90] },
              "pixels": [1920,1080], "layout": "side_by_side" },
  "mirror": { "normal": [0,2,0], "offset_mm": 10 },
  "head": { "eye_center_mm": [0,300,400], "ipd_mm": 64, "right": [2,0,0], "tracker": "opentrack:4242" },
  "X_WH": { "translation_mm": [1,2,3], "rotation_wxyz": [0.5,0.5,0.5,0.5] } })";

TEST(RigFile, ReadsEveryKey) {
  const DisplayRig rig = parse_rig(Json::parse(kExample, "rig.json"));
  EXPECT_EQ(rig.kind, DisplayKind::kMirror);
  EXPECT_EQ(rig.screen.layout, Layout::kSideBySide);
  EXPECT_NEAR(rig.screen.upper_left.z, -0.09, 1e-15);
  EXPECT_EQ(rig.screen.pixels, ivec2(1920, 1080));
  ASSERT_TRUE(rig.mirror);
  EXPECT_EQ(rig.mirror->normal, dvec3(0, 1, 0));
  EXPECT_NEAR(rig.mirror->offset, 0.005, 1e-15);  // the same plane with its normal made unit
  EXPECT_NEAR(rig.head.ipd, 0.064, 1e-15);
  EXPECT_EQ(rig.head.right, dvec3(1, 0, 0));
  EXPECT_EQ(rig.head.tracker, "opentrack:4242");
  EXPECT_NEAR(rig.X_WH.p.y, 0.002, 1e-15);
}

std::string message_for(std::string text, std::string_view from, std::string_view to) {
  text.replace(text.find(from), from.size(), to);
  return test::refusal([&] { (void)parse_rig(Json::parse(text, "rig.json")); });
}

TEST(RigFile, BadValuesNameTheirPlaceWhatWasFoundAndWhatWasExpected) {
  EXPECT_THAT(message_for(kExample, "\"mirror\",", "\"mirorr\","),
              testing::AllOf(HasSubstr("rig.json"), HasSubstr("display"), HasSubstr("mirorr"), HasSubstr("offscreen")));
  EXPECT_THAT(message_for(kExample, "\"ipd_mm\": 64", "\"ipd_mm\": -1"),
              testing::AllOf(HasSubstr("head.ipd_mm"), HasSubstr("-1")));
  EXPECT_THAT(message_for(kExample, "[0,2,0]", "[0,0,0]"), testing::AllOf(HasSubstr("mirror.normal")));
  EXPECT_THAT(message_for(kExample, "opentrack:4242", "opentrack:99999"),
              testing::AllOf(HasSubstr("head.tracker"), HasSubstr("65535")));
  EXPECT_THAT(message_for(kExample, "[0.5,0.5,0.5,0.5]", "[1,1,0,0]"), HasSubstr("X_WH.rotation_wxyz"));
  EXPECT_THAT(message_for(kExample, "[260,400,-90]", "[200,300,-90]"),
              testing::AllOf(HasSubstr("screen.corners_mm"), HasSubstr("right angle")));
  EXPECT_THAT(message_for(kExample, "[0,300,400]", "[0,-500,400]"),
              testing::AllOf(HasSubstr("head.eye_center_mm"), HasSubstr("behind the picture")));
  EXPECT_THAT(message_for(kExample, "\"mirror\",", "\"mirror\", \"magnify_about_mm\": [1,2,3],"),
              testing::AllOf(HasSubstr("magnify_about_mm"), HasSubstr("\"magnify\" beside it")));
  EXPECT_THAT(message_for(R"({"display":"hmd", "hmd": {"magnify": 4}})", "\"hmd\",", "\"hmd\", \"magnify\": 3,"),
              testing::AllOf(HasSubstr("magnify"), HasSubstr("hmd")));
  EXPECT_THAT(message_for(R"({"display":"window"})", "window", "mirror"), HasSubstr("screen"));
}

TEST(RigFile, MagnifiesAnyRigWithAScreen) {
  for (const char* kind : {"window", "mirror", "offscreen"}) {
    const std::string text = std::string(R"({"display":")") + kind +
                             R"(", "magnify": 8, "magnify_about_mm": [6,5,18], "screen": {"corners_mm":
          {"lower_left": [-100,-80,0], "lower_right": [100,-80,0], "upper_left": [-100,80,0]}}})";
    const DisplayRig rig = parse_rig(Json::parse(text, "rig.json"));
    EXPECT_EQ(rig.magnify, 8);
    ASSERT_TRUE(rig.magnify_about);
    EXPECT_NEAR(rig.magnify_about->z, 18e-3, 1e-15);
  }
}

TEST(Layouts, EyePixelsComposeToTheScreensPixels) {
  for (const Layout layout :
       {Layout::kMono, Layout::kSideBySide, Layout::kTopBottom, Layout::kRowInterleaved, Layout::kAnaglyph})
    EXPECT_EQ(screen_pixels(layout, eye_pixels(layout, {1920, 1080})), ivec2(1920, 1080)) << name_of(layout);
  for (int i = 0; i < 7; ++i) {
    const auto layout = static_cast<Layout>(i);
    EXPECT_EQ(eye_pixels_in(layout, screen_pixels(layout, {640, 480})), ivec2(640, 480)) << name_of(layout);
  }
  EXPECT_EQ(screen_pixels(Layout::kTwoOutputs, eye_pixels(Layout::kTwoOutputs, {1920, 1080})), ivec2(3840, 1080));
}

TEST(RigFile, EveryShippedRigWithAScreenShowsTheShippedToothToBothEyes) {
  int rigs = 0;
  for (const auto& entry : std::filesystem::directory_iterator("assets/rigs")) {
    if (entry.path().extension() != ".json") continue;
    const DisplayRig rig = load_rig(entry.path());
    ++rigs;
    if (rig.kind == DisplayKind::kHmd) continue;
    for (const EyeView& eye : eye_views(rig)) {
      const glm::dvec4 clip =
          eye.projection * (eye.view * glm::dvec4(6.8e-3, 5.5e-3, 18e-3, 1));  // its occlusal surface
      EXPECT_GT(clip.w, 0) << entry.path();
      for (int axis = 0; axis < 2; ++axis) EXPECT_LT(std::abs(clip[axis] / clip.w), 0.9) << entry.path();
      EXPECT_EQ(eye.flip, rig.kind == DisplayKind::kMirror) << entry.path();
    }
  }
  EXPECT_GE(rigs, 4);
}

}  // namespace
}  // namespace typodont::display
