#include "engine/app/surroundings/plan.h"

#include <cmath>

#include "engine/app/assets.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

haptics::SoftLaw read_soft_law(const Json& json) {
  json.allow_only({"modulus_MPa", "thickness_mm", "return_s", "friction", "specific_energy_J_per_mm3",
                   "bleeding_depth_mm", "blood_radius_mm", "blood_s"});
  constexpr double kMegapascal = 1e6, kJoulePerMillimetre3 = 1e9;
  haptics::SoftLaw law;
  law.elastic_modulus = json.number_or("modulus_MPa", law.elastic_modulus / kMegapascal, 0.02, 20) * kMegapascal;
  law.thickness = json.number_or("thickness_mm", law.thickness / kMillimetre, 0.5, 5) * kMillimetre;
  law.return_time = json.number_or("return_s", law.return_time, 0.02, 5);
  law.friction = json.number_or("friction", law.friction, 0, 1);
  law.specific_energy =
      json.number_or("specific_energy_J_per_mm3", law.specific_energy / kJoulePerMillimetre3, 0.01, 10) *
      kJoulePerMillimetre3;
  law.bleeding_depth = json.number_or("bleeding_depth_mm", law.bleeding_depth / kMillimetre, 0.05, 2) * kMillimetre;
  law.blood_radius = json.number_or("blood_radius_mm", law.blood_radius / kMillimetre, 0, 8) * kMillimetre;
  law.blood_time = json.number_or("blood_s", law.blood_time, 0.5, 600);
  return law;
}

}  // namespace

SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume, const ScenePlace& place) {
  json.allow_only({"volume", "crown", "arch", "neighbours", "gum", "row", "mouth", "dam", "monitored"});
  SurroundingsPlan plan;
  const auto direction = [](const Json& value) {
    const dvec3 v = value.vec3();
    if (glm::length(v) < 1e-9) value.fail("a direction, not zero");
    return glm::normalize(v);
  };
  if (const auto v = json.find("volume")) {
    plan.volume = find_file(*v, place);
  } else if (!volume.empty()) {
    plan.volume = volume;
  } else {
    json.fail("no \"volume\" in a scene whose tissue is made of solids", "\"volume\"");
  }
  if (const auto v = json.find("crown")) plan.crown = direction(*v);
  if (const auto v = json.find("arch")) plan.arch = direction(*v);
  if (std::abs(glm::dot(plan.arch, plan.crown)) > 0.2)
    json.fail("arch nearly along crown", "them square to each other");
  plan.arch = glm::normalize(plan.arch - plan.crown * glm::dot(plan.arch, plan.crown));
  if (const auto list = json.find("neighbours")) {
    if (list->items().size() > 8) list->fail("at most 8 neighbours");
    for (const Json& item : list->items()) {
      item.allow_only({"contact_mm", "scale", "turn_deg"});
      NeighbourTooth tooth;
      tooth.contact = item["contact_mm"].vec3() * kMillimetre;
      if (const auto scale = item.find("scale")) {
        tooth.scale = scale->vec3();
        for (int a = 0; a < 3; ++a)
          if (tooth.scale[a] < 0.3 || tooth.scale[a] > 3) scale->fail("three factors from 0.3 to 3");
      }
      tooth.turn = item.number_or("turn_deg", 0, -180, 180) * kPi / 180;
      plan.neighbours.push_back(tooth);
    }
  }
  if (const auto gum = json.find("gum")) {
    gum->allow_only({"margin_mm", "normal", "papilla_mm", "thickness_mm", "length_mm", "soft"});
    plan.gum = true;
    plan.margin = (*gum)["margin_mm"].vec3() * kMillimetre;
    plan.margin_normal = plan.crown;
    if (const auto v = gum->find("normal")) plan.margin_normal = direction(*v);
    if (glm::dot(plan.margin_normal, plan.crown) < 0.5) gum->fail("normal far from crown", "them within 60°");
    plan.papilla = gum->number_or("papilla_mm", plan.papilla / kMillimetre, 0, 10) * kMillimetre;
    plan.thickness = gum->number_or("thickness_mm", plan.thickness / kMillimetre, 0.1, 5) * kMillimetre;
    plan.length = gum->number_or("length_mm", plan.length / kMillimetre, 5, 100) * kMillimetre;
    if (const auto soft = gum->find("soft")) plan.soft = read_soft_law(*soft);
  }
  if (const auto row = json.find("row")) {
    if (!plan.neighbours.empty()) row->fail("row beside neighbours", "one of them");
    plan.row = load_tooth_row(find_file(*row, place));
  }
  if (const auto mouth = json.find("mouth")) {
    const std::string name = mouth->string();
    if (name == "patient" || name == "phantom")
      plan.mouth = name == "patient" ? Mouth::kPatient : Mouth::kPhantom;
    else if (name != "none")
      mouth->fail("none, patient or phantom");
    if (plan.mouth != Mouth::kNone && !(plan.row && plan.gum)) mouth->fail("mouth alone", "row and gum beside it");
  }
  if (const auto dam = json.find("dam")) {
    dam->allow_only({"gap_mm", "clamp"});
    if (!(plan.row && plan.gum)) dam->fail("dam alone", "row and gum beside it");
    plan.dam.emplace();
    plan.dam->gap = dam->number_or("gap_mm", plan.dam->gap / kMillimetre, 0, 2) * kMillimetre;
    plan.dam->clamp = dam->boolean_or("clamp", true);
  }
  plan.monitored = json.boolean_or("monitored", true);
  return plan;
}

}  // namespace typodont
