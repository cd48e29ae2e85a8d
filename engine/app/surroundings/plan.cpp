#include "engine/app/surroundings/plan.h"

#include <cmath>

#include "engine/app/assets.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr double kMegapascal = 1e6;

void describe_soft_law(Keys& keys, haptics::SoftLaw& law) {
  keys("modulus_MPa", law.elastic_modulus, {0.02, 20, kMegapascal}, "Young's modulus");
  keys("thickness_mm", law.thickness, {0.5, 5, kMillimetre}, "largest thickness of the soft layer");
  keys("return_s", law.return_time, {0.02, 5}, "time constant of the return");
  keys("friction", law.friction, {0, 1}, "coefficient of friction");
  keys("specific_energy_J_per_mm3", law.specific_energy, {0.01, 10, kJoulePerCubicMillimetre}, "energy of cutting");
  keys("bleeding_depth_mm", law.bleeding_depth, {0.05, 2, kMillimetre}, "cuts deeper than this bleed");
  keys("blood_radius_mm", law.blood_radius, {0, 8, kMillimetre}, "final radius of the blood around a wound");
  keys("blood_s", law.blood_time, {0.5, 600}, "time constant with which the blood spreads");
}

void describe_neighbour(Keys& keys, NeighbourTooth& tooth, const dvec3& arch) {
  keys(must("contact_mm"), tooth.contact, kMillimetre, "point where the two teeth touch");
  tooth.normal = arch;
  keys("normal", tooth.normal, read_direction, "normal of the mirror plane, within 60° of `arch` (default)");
  if (keys.json() && std::abs(glm::dot(tooth.normal, arch)) < 0.5)
    keys.json()->fail("normal far from arch", "them within 60°");
  if (const auto scale = keys("scale", kThree, "enlargement along the arch, across, and along the crown, 0.3–3")) {
    tooth.scale = scale->vec3();
    for (int a = 0; a < 3; ++a)
      if (tooth.scale[a] < 0.3 || tooth.scale[a] > 3) scale->fail("three factors from 0.3 to 3");
  }
}

void describe_gum(Keys& keys, SurroundingsPlan& plan) {
  keys(must("margin_mm"), plan.margin, kMillimetre, "a point of the gum's edge");
  plan.margin_normal = plan.crown;
  keys("normal", plan.margin_normal, read_direction, "normal of this edge, within 60° of `crown` (default)");
  if (keys.json() && glm::dot(plan.margin_normal, plan.crown) < 0.5)
    keys.json()->fail("normal far from crown", "them within 60°");
  keys("papilla_mm", plan.papilla, {0, 10, kMillimetre}, "additional height of the gum between two teeth");
  keys("thickness_mm", plan.thickness, {0.1, 5, kMillimetre}, "thickness of the gum on the root");
  keys("length_mm", plan.length, {5, 100, kMillimetre}, "length of the drawn part of the jaw");
  keys("soft", plan.soft, describe_soft_law, "[Soft gum](#soft-gum)");
}

void describe_dam(Keys& keys, RubberDam& dam) {
  keys("gap_mm", dam.gap, {0, 2, kMillimetre}, "distance of the hole's edge from the tooth");
  keys("clamp", dam.clamp, "a steel clamp holds the sheet");
}

}  // namespace

void describe_surroundings(Keys& keys, SurroundingsPlan& plan, const std::filesystem::path& volume,
                           const ScenePlace& place) {
  const Json* json = keys.json();
  plan.volume = volume;
  if (const auto v = keys("volume", kFile,
                          "the volume of the working tooth (`.vdb`); default: that of the scene. Required if the "
                          "tissue of the scene is not a volume file"))
    plan.volume = find_file(*v, place);
  if (json && plan.volume.empty()) json->fail("no \"volume\" in a scene whose tissue is made of solids", "\"volume\"");
  keys("crown", plan.crown, read_direction, "direction of the crown; default [0, 0, 1]");
  keys("arch", plan.arch, read_direction, "along the arch, nearly perpendicular to `crown`; default [1, 0, 0]");
  if (json && std::abs(glm::dot(plan.arch, plan.crown)) > 0.2)
    json->fail("arch nearly along crown", "them square to each other");
  plan.arch = glm::normalize(plan.arch - plan.crown * glm::dot(plan.arch, plan.crown));
  keys(
      "neighbours", plan.neighbours, [&](Keys& of, NeighbourTooth& tooth) { describe_neighbour(of, tooth, plan.arch); },
      "at most 8 copies of the tooth, mirrored at the contact");
  if (json && plan.neighbours.size() > 8) (*json)["neighbours"].fail("at most 8 neighbours");
  keys("gum", plan, describe_gum, "[Gum](#gum)");
  plan.gum = json && json->has("gum");
  if (const auto row =
          keys("row", kFile, "the other teeth of the jaw, instead of `neighbours` ([Row of teeth](#row-of-teeth))")) {
    if (!plan.neighbours.empty()) row->fail("row beside neighbours", "one of them");
    plan.row = load_tooth_row(find_file(*row, place));
  }
  keys("mouth", plan.mouth, {"none", "patient", "phantom"},
       "cheek, lips and tongue, or a phantom head with a mask, teeth of plastic and gum of acrylic; only with `row` "
       "and `gum`; only drawn");
  if (plan.mouth != Mouth::kNone && !(plan.row && plan.gum))
    (*json)["mouth"].fail("mouth alone", "row and gum beside it");
  keys("dam", plan.dam, describe_dam,
       "a rubber dam with a hole for the working tooth, which hides the other teeth and the gum; only with `row` and "
       "`gum`; only drawn");
  if (plan.dam && !(plan.row && plan.gum)) (*json)["dam"].fail("dam alone", "row and gum beside it");
  keys("monitored", plan.monitored,
       "false: the surroundings are only drawn. A bur then causes no damage in them, and a hand that plans its strokes "
       "(the expert) does not avoid them");
}

}  // namespace typodont
