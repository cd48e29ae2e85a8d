// Tests tools and handpieces in pictures: the drawn tool is the tool that has contact; the files of handpieces, the
// rule that chooses one, their meshes, and their position on the tool.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <map>
#include <random>

#include "engine/app/assets.h"
#include "engine/app/picture/picture_stage.h"
#include "engine/app/scene.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/base/units.h"
#include "engine/render/handpiece_mesh.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

std::vector<std::string> names_in(const char* folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(assets_folder() / folder))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem());
  return names;
}

TEST(Handpieces, EveryPartOfEveryShippedHandpieceIsAClosedFiniteSolidWithFewTriangles) {
  for (const std::string& name : names_in("handpieces")) {
    const Handpiece whole = load_handpiece(name);
    for (const render::Quality& quality : render::kQualityLadder) {
      EXPECT_LT(render::make_handpiece_mesh(whole, quality.handpiece_side).indices.size() / 3, 20'000u)
          << name << ", " << quality.name;
      for (std::size_t i = 0; i < whole.parts.size(); ++i) {
        Handpiece one = whole;
        one.parts = {whole.parts[i]};
        one.parts[0].repeat = 1;
        const render::HandpieceMesh mesh = render::make_handpiece_mesh(one, quality.handpiece_side);
        for (const render::HandpieceVertex& v : mesh.vertices) {
          ASSERT_TRUE(is_finite(dvec3(v.p)) && is_finite(dvec3(v.n)) && is_finite(dvec3(v.around))) << name << i;
          ASSERT_NEAR(glm::length(v.n), 1, 1e-4) << name << i;
        }
        // For each edge between two positions, as many triangles must use it in one direction as in the other.
        std::map<std::array<float, 6>, int> edges;
        double volume = 0;
        for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
          glm::dvec3 p[3];
          for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 a = mesh.vertices[mesh.indices[t + k]].p,
                            b = mesh.vertices[mesh.indices[t + (k + 1) % 3]].p;
            p[k] = a;
            if (a == b) continue;
            ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
            --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
          }
          volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6;
        }
        for (const auto& [edge, count] : edges) ASSERT_EQ(count, 0) << name << ", part " << i;
        EXPECT_GT(volume, 0) << name << ", part " << i << " is inside out";
      }
    }
  }
}

TEST(Handpieces, NoHandpieceReachesTheWorkingPointOfAShippedTool) {
  const auto check = [](const haptics::Tool& tool, const haptics::Spindle& spindle) {
    const DrawnTool drawn = drawn_tool(tool, spindle, {});
    const render::HandpieceMesh mesh = render::make_handpiece_mesh(drawn.handpiece, 1e-3);
    for (const render::HandpieceVertex& v : mesh.vertices) {
      const dvec3 p = drawn.X_GH * dvec3(v.p);
      if (drawn.handpiece.from_head) {  // begins inside the head, and is thinner than the head there
        EXPECT_GE(p.z, -1e-9) << tool.name;
        if (p.z < tool.half()) {
          EXPECT_LE(glm::length(glm::dvec2(p)), tool.radius()) << tool.name;
        }
      } else {
        EXPECT_GT(tool.distance(p), 1e-3) << tool.name;
      }
    }
  };
  for (const std::string& name : names_in("tools"))
    for (const char* motor : {"air_turbine", "electric_1_5", "implant"}) check(load_tool(name), load_spindle(motor));
  for (const std::string& name : names_in("implants/bone_level"))
    check(load_set_tool(assets_folder() / "implants/bone_level", Json::parse(fmt::format("\"{}\"", name), "test")),
          load_spindle("implant"));
}

TEST(Handpieces, TheHandpieceFollowsFromTheToolAndItsMotor) {
  const auto of = [](const char* tool, const char* motor) {
    return handpiece_name(load_tool(tool), load_spindle(motor));
  };
  EXPECT_EQ(of("round_012", "air_turbine"), "turbine");
  EXPECT_EQ(of("round_012", "electric_1_5"), "contra_angle_1_5");
  EXPECT_EQ(of("implant_drill_028", "implant"), "contra_angle_implant");
  EXPECT_EQ(of("implant_drill_028", "air_turbine"), "contra_angle");
  EXPECT_EQ(of("round_040", "air_turbine"), "straight");
  EXPECT_EQ(of("explorer", "air_turbine"), "explorer");
  EXPECT_EQ(of("probe_who_621", "air_turbine"), "probe_who_621");
  EXPECT_EQ(of("carver_cleoid", "air_turbine"), "handle");
  EXPECT_EQ(of("gauge_22", "implant"), "gauge");
  const auto inline_tool = [](const char* text) { return haptics::read_tool(Json::parse(text, "test")); };
  EXPECT_EQ(handpiece_name(inline_tool(R"({"shape": "sphere", "diameter_mm": 14})"), {}), "") << "no dental handpiece";
  EXPECT_EQ(handpiece_name(inline_tool(R"({"shape": "sphere", "diameter_mm": 1, "handpiece": "none"})"), {}), "");
  EXPECT_EQ(handpiece_name(inline_tool(R"({"shape": "sphere", "diameter_mm": 1, "handpiece": "ultrasonic"})"), {}),
            "ultrasonic");
  const auto ratchet =
      load_set_tool(assets_folder() / "implants/bone_level", Json::parse(R"("implant_48_12_ratchet")", "test"));
  EXPECT_EQ(handpiece_name(ratchet, load_spindle("implant")), "ratchet");
  haptics::Spindle bare = load_spindle("air_turbine");
  bare.handpiece = "none";
  EXPECT_EQ(handpiece_name(load_tool("round_012"), bare), "");
  EXPECT_EQ(handpiece_name(load_tool("implant_drill_028"), bare), "") << "a shank for contra-angles";
}

TEST(Handpieces, TheBodyTurnsSteadilyWithTheAxisOfAHandThatGivesOnlyTheAxis) {
  const DrawnTool drawn = drawn_tool(load_tool("round_012"), load_spindle("air_turbine"), {});
  const auto body = [&](const dvec3& axis) {
    return (Pose{{0, 0, 0}, rotation_between({0, 0, 1}, axis)} * drawn.X_GH).rotate({1, 0, 0});
  };
  EXPECT_GT(body({0, 0, 1}).x, 0.7) << "to the right";
  EXPECT_LT(body({0, 0, 1}).y, 0) << "and to the user";
  std::mt19937_64 random(5);
  std::normal_distribution<double> step(0, 0.01);
  dvec3 axis(0, 0, 1);
  for (int i = 0; i < 20'000; ++i) {
    const dvec3 next = glm::normalize(axis + dvec3(step(random), step(random), step(random)));
    if (next.z < std::cos(120 * kDegree)) continue;  // the tool points up into the hand only beyond this
    // At 120° from W's z axis, a change of the tool's axis turns the body by at most 1 / cos² 60° = 4 times this
    // change, and additionally tilts it by the change itself. Together this is a factor of 5.
    const double turned = glm::length(body(next) - body(axis)), moved = glm::length(next - axis);
    ASSERT_LE(turned, 5 * moved + 1e-12) << "at z = " << next.z;
    axis = next;
  }
}

TEST(Handpieces, AHandWithItsOwnRollTurnsTheBody) {
  const DrawnTool drawn = drawn_tool(load_tool("round_012"), load_spindle("air_turbine"), {});
  const dvec3 axis = glm::normalize(dvec3(0.2, -0.3, 1));
  const dquat tilt = rotation_between({0, 0, 1}, axis), roll = glm::angleAxis(0.7, axis);
  const dvec3 at_rest = (Pose{{0, 0, 0}, tilt} * drawn.X_GH).rotate({1, 0, 0});
  const dvec3 rolled = (Pose{{0, 0, 0}, roll * tilt} * drawn.X_GH).rotate({1, 0, 0});
  EXPECT_LT(glm::length(rolled - roll * at_rest), 1e-12);
}

TEST(Handpieces, AMistakeInAFileIsNamed) {
  const auto read = [](const std::string& parts, const std::string& begins = "\"shank\"") {
    const std::string text = fmt::format(R"({{"name": "x", "begins_at": {}, "parts": {}}})", begins, parts);
    return test::refusal(
        [&] { (void)render::make_handpiece_mesh(read_handpiece(Json::parse(text, "h.json")), 0.5e-3); });
  };
  const std::string good = R"([{"rings_mm": [[0, 0, 1], [0, 5, 1]]}])";
  EXPECT_EQ(read(good), "");
  EXPECT_THAT(read(good, "\"tip\""), HasSubstr("\"begins_at\": found \"tip\", expected \"head\" or \"shank\""));
  EXPECT_THAT(read("[]"), HasSubstr("\"parts\": found 0 parts, expected 1 to 16 parts"));
  EXPECT_THAT(read(R"([{"rings_mm": [[0, 0, 1]]}])"), HasSubstr("found 1 rings, expected 2 to 64 rings"));
  EXPECT_THAT(read(R"([{"rings_mm": [[0, 0, 1], [0, 0, 2]]}])"), HasSubstr("expected a path with a length"));
  EXPECT_THAT(read(R"([{"rings_mm": [[0, 0, -1], [0, 5, 1]]}])"), HasSubstr("a radius of at least 0"));
  EXPECT_THAT(read(R"([{"rings_mm": [[0, 0, 1], [0, 5, 1]], "bands_mm": [[2, 6]]}])"),
              HasSubstr("0 <= from < to <= 5"));
  EXPECT_THAT(read(R"([{"rings_mm": [[0, 0, 1], [0, 5, 1]], "repeat": 13}])"), HasSubstr("\"parts[0].repeat\""));
  std::string many = "[";
  for (int i = 0; i < 16; ++i) {
    many += i ? ", " : "";
    many += R"({"repeat": 12, "rings_mm": [)";
    for (int k = 0; k < 64; ++k) many += fmt::format("{}[3, {}, {}]", k ? ", " : "", k, 20 + k % 2);
    many += "]}";
  }
  EXPECT_THAT(read(many + "]"), HasSubstr("triangles, expected at most 30000: fewer rings or copies"));
}

constexpr double kTolerance = 2e-6;  // m

/// Every tool of assets/tools and of the implant set.
std::vector<haptics::Tool> shipped_tools() {
  std::vector<haptics::Tool> tools;
  for (const std::string& name : names_in("tools")) tools.push_back(load_tool(name));
  for (const std::string& name : names_in("implants/bone_level"))
    tools.push_back(load_set_tool(assets_folder() / "implants/bone_level", Json::parse("\"" + name + "\"", "test")));
  return tools;
}

render::ToolMesh drawn(const haptics::Tool& tool) {
  return drawn_tool(tool, {}, {.shown = false}).tool;
}

bool in_head(const render::ToolVertex& v) {
  return v.finish != static_cast<float>(render::Finish::kBrushed);
}

/// Calls `each` with three vertices of every triangle.
template <class Each>
void for_each_triangle(const render::ToolMesh& mesh, Each&& each) {
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
    each(mesh.vertices[mesh.indices[i]], mesh.vertices[mesh.indices[i + 1]], mesh.vertices[mesh.indices[i + 2]]);
}

TEST(DrawnTools, EveryDrawnPartLiesOnTheOutlineThatHasContact) {
  for (const haptics::Tool& tool : shipped_tools()) {
    const auto shank = haptics::shank_of(tool), pin = haptics::safe_end_of(tool);
    const auto error = [&](const dvec3& p, bool head) {
      if (head) return std::abs(tool.distance(p));
      const auto to = [&](const std::optional<haptics::NonCuttingPart>& part) {
        return part ? std::abs(part->shape.distance(p - dvec3(0, 0, part->z))) : 1.0;
      };
      return std::min(to(shank), to(pin));
    };
    const double end = shank ? shank->z + shank->shape.half() : tool.half();
    double worst = 0;
    for_each_triangle(drawn(tool), [&](const auto& a, const auto& b, const auto& c) {
      const bool head = in_head(a);
      if (!head && !shank && a.hull_p.z > -tool.half()) return;  // a shank without contact
      for (const glm::vec3& p : {a.hull_p, 0.5f * (a.hull_p + b.hull_p), (a.hull_p + b.hull_p + c.hull_p) / 3.0f})
        if (p.z < end - 1e-5) worst = std::max(worst, error(p, head));
    });
    EXPECT_LE(worst, kTolerance) << tool.name;
  }
}

TEST(DrawnTools, TheWholeHeadIsDrawnUpToItsNeck) {
  for (const haptics::Tool& tool : shipped_tools()) {
    const render::ToolMesh mesh = drawn(tool);
    for (int i = 0; i < 100; ++i) {
      const double z = tool.half() * (2 * (i + 0.5) / 100 - 1);
      double widest = 0;
      for_each_triangle(mesh, [&](const auto& a, const auto& b, const auto&) {
        const double za = a.hull_p.z, zb = b.hull_p.z;
        if (!(za <= z && z <= zb) && !(zb <= z && z <= za)) return;
        const double s = za == zb ? 0 : (z - za) / (zb - za);
        const glm::dvec2 p = glm::mix(glm::dvec2(a.hull_p), glm::dvec2(b.hull_p), s);
        widest = std::max(widest, glm::length(p));
      });
      EXPECT_GT(tool.distance({widest, 0, z}), -kTolerance) << tool.name << " at " << z;
    }
  }
}

TEST(DrawnTools, BladesAndThreadsLieInsideTheOutline) {
  for (const haptics::Tool& tool : shipped_tools())
    for (const render::ToolVertex& v : drawn(tool).vertices)
      ASSERT_LE(glm::length(glm::dvec2(v.p)), glm::length(glm::dvec2(v.hull_p)) + 1e-9) << tool.name;
}

TEST(DrawnTools, TrianglesFaceOutwards) {
  for (const haptics::Tool& tool : shipped_tools()) {
    double volume = 0;  // signed; positive if triangles run counter-clockwise, seen from outside
    for_each_triangle(drawn(tool), [&](const auto& a, const auto& b, const auto& c) {
      volume += glm::dot(dvec3(a.hull_p), glm::cross(dvec3(b.hull_p), dvec3(c.hull_p))) / 6;
    });
    EXPECT_GT(volume, 1e-8) << tool.name;
  }
}

}  // namespace
}  // namespace typodont
