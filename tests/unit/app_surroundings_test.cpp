// Tests the row of teeth, the gum, the mouth and the rubber dam around the working tooth.
#include <gmock/gmock.h>

#include <random>
#include <set>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/base/keys.h"
#include "engine/display/display_rig.h"
#include "engine/render/drawn_matter.h"
#include "tests/support/folder.h"

namespace typodont {
namespace {

using testing::HasSubstr;

constexpr const char* kToothScenes[] = {
    "molar-caries",    "class-1-cavity", "class-2-cavity",    "remove-caries",     "explore-caries",
    "amalgam-filling", "free-practice",  "crown-preparation", "root-canal-access", "root-canal-access-packing",
    "tutorial"};

Scene shipped(const std::string& name) {
  return read_scene(assets_folder() / "scenes" / (name + ".json"));
}
const ToothRow& lower_row() {
  static const ToothRow row = load_tooth_row(assets_folder() / "jaw/lower_row.json");
  return row;
}

/// Returns the smallest sum of two distances near the middle between two teeth. It is twice the gap, and negative if
/// the teeth overlap.
template <class First, class Second>
double gap(First&& first, Second&& second, const dvec3& middle, const dvec3& reach) {
  double least = 1;
  for (double x = -reach.x; x < reach.x; x += 0.12e-3)
    for (double y = -reach.y; y < reach.y; y += 0.2e-3)
      for (double z = -reach.z; z < reach.z; z += 0.3e-3) {
        const dvec3 p = middle + dvec3(x, y, z);
        least = std::min(least, first(p) + second(p));
      }
  return least;
}

TEST(ToothRowTest, NeighboursInTheRowTouchAndDoNotPierceEachOther) {
  const auto& teeth = lower_row().teeth;
  for (std::size_t i = 0; i + 1 < teeth.size(); ++i) {
    const RowTooth &a = teeth[i], &b = teeth[i + 1];
    if (glm::length(a.at - b.at) > 13e-3) continue;  // the working tooth is between them
    const double found =
        gap([&](const dvec3& p) { return a.distance(p); }, [&](const dvec3& p) { return b.distance(p); },
            0.5 * (a.at + b.at) + dvec3(0, 0, 5e-3), dvec3(2.5e-3, 2.5e-3, 3.5e-3));
    EXPECT_LT(found, 0.2e-3) << i;
    EXPECT_GT(found, -0.2e-3) << i;
  }
}

TEST(ToothRowTest, TheWorkingToothTouchesBothItsNeighboursAndIsNotPierced) {
  const SurroundingsShape shape = *surroundings_shape(shipped("class-2-cavity").surroundings);
  for (const double x : {1.1e-3, 12.6e-3}) {
    const double found =
        gap([&](const dvec3& p) { return shape.tooth(p); }, [&](const dvec3& p) { return shape.neighbour(p); },
            {x, 5.4e-3, 17e-3}, {1.6e-3, 3e-3, 2.5e-3});
    EXPECT_LT(found, 0.15e-3) << x;
    EXPECT_GT(found, -0.15e-3) << x;
  }
}

TEST(ToothRowTest, AFormIsSolidFromItsRootToItsCuspsAndItsDistanceIsNoSteeperThanTheMesherAllows) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const RowTooth& tooth : lower_row().teeth) {
    const ToothForm& form = tooth.form;
    EXPECT_LT(form.distance({0, 0, -0.5 * form.root}), 0);
    EXPECT_LT(form.distance({0, 0, 0.4 * form.height}), 0);
    const dvec3 size = form.high() - form.low();
    int steep = 0;
    for (int i = 0; i < 2000; ++i) {
      const dvec3 p = form.low() + size * dvec3(unit(random), unit(random), unit(random));
      const dvec3 step = 0.05e-3 * glm::normalize(dvec3(unit(random), unit(random), unit(random)) - 0.5);
      steep += std::abs(form.distance(p + step) - form.distance(p)) > 1.6 * 0.05e-3;
      dvec3 q = p;  // on the box
      q[i % 3] = i % 2 ? form.low()[i % 3] : form.high()[i % 3];
      EXPECT_GT(form.distance(q), 0);
    }
    EXPECT_LT(steep, 60);  // at the grooves
  }
}

TEST(RubberDamTest, TheHoleClearsTheToothAndTheSheetCoversTheNeighbours) {
  const Scene scene = shipped("root-canal-access");
  const SurroundingsShape shape = *surroundings_shape(scene.surroundings);
  int on_tooth = 0, neighbours = 0;
  for (double x = -4e-3; x < 18e-3; x += 0.3e-3)
    for (double y = -1e-3; y < 12e-3; y += 0.3e-3)
      for (double z = 15.5e-3; z < 21e-3; z += 0.3e-3) {
        const dvec3 p(x, y, z);
        if (std::abs(shape.tooth(p)) < 0.1e-3) {
          EXPECT_GE(shape.dam(p), -1e-9);
          ++on_tooth;
        }
        if (shape.neighbour(p) < 0 && shape.tooth(p) > 0.3e-3) {
          EXPECT_LT(shape.dam(p), 0);
          ++neighbours;
        }
      }
  EXPECT_GT(on_tooth, 200);
  EXPECT_GT(neighbours, 1000);
}

TEST(SurroundingsOfTheScenes, NeverCoverTheOcclusalSurfaceAtTheShippedViews) {
  for (const char* name : kToothScenes) {
    const Scene scene = shipped(name);
    ASSERT_TRUE(scene.surroundings) << name;
    const SurroundingsShape shape = *surroundings_shape(scene.surroundings);
    for (const char* file : {"closeup", "window", "film", "mirror"}) {
      const display::DisplayRig rig = display::load_rig(assets_folder() / "rigs" / (std::string(file) + ".json"));
      dvec3 eye = rig.head.eye_center;
      int seen = 0;
      for (double x = 3e-3; x < 11e-3; x += 1e-3)
        for (double y = 2e-3; y < 9.5e-3; y += 1e-3) {
          double z = 22e-3;
          while (z > 15e-3 && shape.tooth({x, y, z}) > 0) z -= 0.1e-3;
          if (z < 17e-3) continue;
          ++seen;
          const dvec3 from(x, y, z + 0.2e-3), way = glm::normalize(eye - from);
          for (double s = 0.3e-3; s < 60e-3; s += 0.3e-3) {
            const dvec3 p = from + s * way;
            ASSERT_GT(std::min({shape.neighbour(p), shape.gum(p), shape.mouth(p), shape.dam(p), shape.clamp(p)}), 0)
                << name << " " << file << " from " << x << " " << y << " at " << s;
          }
        }
      EXPECT_GT(seen, 30);
    }
  }
}

TEST(SurroundingsOfTheScenes, HaveNoSecondGumBelowTheGumAroundTheWorkingTooth) {
  for (const char* name : {"molar-caries", "crown-preparation"}) {
    const Surroundings around = make_surroundings(shipped(name).surroundings);
    std::vector<const SurroundingMesh*> gums;  // first the fine one around the working tooth, then the rest of the row
    for (const SurroundingMesh& mesh : around.meshes) {
      const Tissue tissue = mesh.bricks.empty() ? Tissue::kAir : mesh.bricks[0].vertices[0].tissue[0];
      if (tissue == Tissue::kGingiva || tissue == render::kAcrylic) gums.push_back(&mesh);
    }
    ASSERT_EQ(gums.size(), 2u) << name;
    dvec3 lo(1e9), hi(-1e9);
    for (const auto& brick : gums[0]->bricks)
      for (const auto& v : brick.vertices) {
        lo = glm::min(lo, gums[0]->origin + dvec3(v.p));
        hi = glm::max(hi, gums[0]->origin + dvec3(v.p));
      }
    int beside = 0;
    for (const auto& brick : gums[1]->bricks)
      for (std::size_t i = 0; i + 2 < brick.indices.size(); i += 3) {
        double least = 1e9;  // m, depth of the triangle's outermost corner inside the box of the first gum
        for (std::size_t k = 0; k < 3; ++k) {
          const dvec3 p = gums[1]->origin + dvec3(brick.vertices[brick.indices[i + k]].p);
          const dvec3 inside = glm::min(p - lo, hi - p);
          least = std::min({least, inside.x, inside.y, inside.z});
        }
        EXPECT_LT(least, 7e-3) << name;  // the bricks of the first gum reach up to 5.8 mm beyond its box
        beside += least > 0;
      }
    EXPECT_GT(beside, 20) << name << ": the two overlap, so that no gap between them is visible";
  }
}

TEST(SurroundingsOfTheScenes, ThePhantomHasTeethOfPlasticAndGumOfAcrylic) {
  const Surroundings around = make_surroundings(shipped("crown-preparation").surroundings);
  std::set<Tissue> found;
  for (const SurroundingMesh& mesh : around.meshes)
    for (const auto& brick : mesh.bricks)
      for (const auto& v : brick.vertices) found.insert(v.tissue[0]);
  EXPECT_TRUE(found.contains(render::kPlastic));
  EXPECT_TRUE(found.contains(render::kAcrylic));
  EXPECT_FALSE(found.contains(Tissue::kGingiva));
  EXPECT_FALSE(found.contains(render::kTongue));
}

TEST(SurroundingsFile, MistakesAreNamed) {
  const auto message = [](const std::string& text) {
    SurroundingsPlan plan;
    return test::refusal([&] {
      read_keys(Json::parse(text, "scene.json"),
                [&](Keys& keys) { describe_surroundings(keys, plan, "tooth.vdb", assets_folder()); });
    });
  };
  const std::string row = R"("row": "jaw/lower_row.json", "gum": {"margin_mm": [7, 5, 14]})";
  EXPECT_EQ(message("{" + row + R"(, "mouth": "patient", "dam": {"gap_mm": 0.2, "clamp": false}, "monitored": false})"),
            "");
  EXPECT_THAT(message(R"({"row": "no_row.json"})"), HasSubstr("no_row.json"));
  EXPECT_THAT(message(R"({"row": "jaw/lower_row.json", "neighbours": [{"contact_mm": [0, 0, 0]}]})"),
              HasSubstr("row beside neighbours"));
  EXPECT_THAT(message("{" + row + R"(, "mouth": "horse"})"), HasSubstr("none, patient or phantom"));
  EXPECT_THAT(message(R"({"mouth": "patient"})"), HasSubstr("row and gum beside it"));
  EXPECT_THAT(message(R"({"dam": {}})"), HasSubstr("row and gum beside it"));
  EXPECT_THAT(message(R"({"neighbours": [{"contact_mm": [0, 0, 0], "scale": [1, 0, 1]}]})"), HasSubstr("scale"));
  EXPECT_THAT(message(R"({"crown": [0, 0, 1], "arch": [0, 0, 1]})"), HasSubstr("square"));
  EXPECT_EQ(message(R"({"gum": {"margin_mm": [0, 0, 14]}})"), "");
}

TEST(ToothFormFile, MistakesAreNamed) {
  const auto message = [](const std::string& change, const std::string& to) {
    std::string text = R"({"widest_mm": [7, 8], "neck_mm": [5, 7], "table_mm": [5, 5], "height_mm": 8,
      "contour_mm": [5, 3, 4], "rounding_mm": 1.5, "root_mm": 14, "groove_mm": [0.3, 0.3],
      "hills": [{"at_mm": [0, 0], "height_mm": 8, "slope": 0.6}]})";
    if (!change.empty()) text.replace(text.find(change), change.size(), to);
    return test::refusal([&] { read_tooth_form(Json::parse(text, "form.json")); });
  };
  EXPECT_EQ(message("", ""), "");
  EXPECT_THAT(message("[5, 3, 4]", "[5, 3, 9]"), HasSubstr("within the crown"));
  EXPECT_THAT(message(R"([{"at_mm": [0, 0], "height_mm": 8, "slope": 0.6}])", "[]"), HasSubstr("1 to 12 hills"));
}

TEST(SurroundingsOfTheScenes, ThatAreNotMonitoredHaveNoShapeForDamage) {
  EXPECT_FALSE(monitored_shape(shipped("crown-preparation").surroundings));
  EXPECT_TRUE(monitored_shape(shipped("class-2-cavity").surroundings));
  EXPECT_TRUE(surroundings_shape(shipped("crown-preparation").surroundings));
}

}  // namespace
}  // namespace typodont
