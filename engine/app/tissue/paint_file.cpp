#include "engine/app/tissue/paint_file.h"

#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {

std::vector<PaintStroke> read_paint(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  json.allow_only({"strokes"});
  std::vector<PaintStroke> strokes;
  for (const Json& item : json["strokes"].items()) {
    item.allow_only({"tissue", "a_mm", "b_mm", "radius_mm", "stiffness_factor", "hardness"});
    PaintStroke stroke;
    const auto tissue = tissue_named(item["tissue"].string());
    if (!tissue || *tissue == Tissue::kAir) item["tissue"].fail("the name of a tissue");
    stroke.tissue = *tissue;
    stroke.a_W = item["a_mm"].vec3() * kMillimetre;
    const auto b = item.find("b_mm");
    stroke.b_W = b ? b->vec3() * kMillimetre : stroke.a_W;
    stroke.radius = item["radius_mm"].number(1e-3, 100) * kMillimetre;
    stroke.stiffness_factor = item.number_or("stiffness_factor", 1, 0.01, 10);
    stroke.hardness = item.number_or("hardness", 1, 0, 1);
    strokes.push_back(stroke);
  }
  return strokes;
}

bool paint(haptics::TissueVolume& volume, const std::vector<PaintStroke>& strokes) {
  bool any = false;
  for (const PaintStroke& s : strokes)
    any |= volume.paint(s.tissue, *haptics::capsule(s.a_W, s.b_W, s.radius), haptics::hardness_byte(s.hardness));
  return any;
}

double stiffness_factor(const std::vector<PaintStroke>& strokes, Tissue tissue) {
  double sum = 0, weight = 0;
  for (const PaintStroke& s : strokes) {
    if (s.tissue != tissue) continue;
    const double volume = kPi * s.radius * s.radius * (glm::length(s.b_W - s.a_W) + 4.0 / 3 * s.radius);
    sum += volume * s.stiffness_factor;
    weight += volume;
  }
  return weight > 0 ? sum / weight : 1;
}

}  // namespace typodont
