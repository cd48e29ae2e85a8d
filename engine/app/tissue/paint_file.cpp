#include "engine/app/tissue/paint_file.h"

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/solid.h"

namespace typodont {

namespace {

void describe_stroke(Keys& keys, PaintStroke& stroke) {
  if (const auto name = keys(must("tissue"), kName, "label of the stroke"))
    stroke.tissue = haptics::read_tissue_name(*name);
  keys(must("a_mm"), stroke.a_W, kMillimetre, "one end of the stroke");
  stroke.b_W = keys.json() ? stroke.a_W : dvec3(kNoDefault);
  keys("b_mm", stroke.b_W, kMillimetre, "the other end; default: `a_mm`");
  keys(must("radius_mm"), stroke.radius, {1e-3, 100, kMillimetre}, "radius of the stroke");
  keys("stiffness_factor", stroke.stiffness_factor, {0.01, 10}, "factor of the tissue's stiffness everywhere");
  keys("hardness", stroke.hardness, {0, 1}, "[hardness](#hardness) in the stroke");
  dvec3 color(kNoDefault);
  keys("color", color, read_color, "[colour](#color) of the stroke; default: the tissue's");
  if (is_finite(color)) stroke.color = voxel_color(color);
}

}  // namespace

void describe_paint_file(Keys& keys, std::vector<PaintStroke>& strokes) {
  keys(must("strokes"), strokes, describe_stroke, "the strokes");
}

std::vector<PaintStroke> read_paint(const std::filesystem::path& file) {
  return read_keys(Json::load(file), describe_paint_file);
}

bool paint(haptics::TissueVolume& volume, const std::vector<PaintStroke>& strokes) {
  bool any = false;
  for (const PaintStroke& s : strokes)
    any |=
        volume.paint(s.tissue, *haptics::capsule(s.a_W, s.b_W, s.radius), haptics::hardness_byte(s.hardness), s.color);
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
