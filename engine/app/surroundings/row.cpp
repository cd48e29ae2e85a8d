#include "engine/app/surroundings/row.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

/// Rotation from the row's frame to the form's frame: `turn` about z, `lean` to the tongue, `mirrored` for the other
/// side.
glm::dmat3 to_form(double turn, double lean, bool mirrored) {
  const double c = std::cos(turn), s = std::sin(turn), cl = std::cos(lean), sl = std::sin(lean);
  const double x = mirrored ? -1 : 1;
  return glm::transpose(glm::dmat3(dvec3(x * c, x * s, 0), dvec3(-cl * s, cl * c, sl), dvec3(sl * s, -sl * c, cl)));
}

}  // namespace

ArchCurve::ArchCurve(std::vector<glm::dvec2> points) : points_(std::move(points)) {
  along_.push_back(0);
  for (std::size_t i = 1; i < points_.size(); ++i)
    along_.push_back(along_.back() + glm::length(points_[i] - points_[i - 1]));
}

ArchCurve::Place ArchCurve::place(const glm::dvec2& p) const {
  Place best;
  // Distance to the nearest segment so far: its square, m²; itself, m.
  double nearest = 1e9, reach = 1e9;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    const glm::dvec2 r = p - points_[i];
    const double farthest = reach + along_[i + 1] - along_[i];
    // No part of this segment is nearer.
    if (glm::dot(r, r) > farthest * farthest) continue;
    const glm::dvec2 d = points_[i + 1] - points_[i];
    const double t = std::clamp(glm::dot(r, d) / glm::dot(d, d), 0.0, 1.0);
    const glm::dvec2 off = r - t * d;
    const double d2 = glm::dot(off, off);
    if (d2 >= nearest) continue;
    nearest = d2;
    reach = std::sqrt(d2);
    best.along = along_[i] + t * (along_[i + 1] - along_[i]);
    best.beside = d.x * r.y - d.y * r.x > 0 ? 1 : -1;
  }
  best.beside *= std::sqrt(nearest);
  return best;
}

ToothRow load_tooth_row(const std::filesystem::path& file) {
  const Json json = Json::load(file);
  json.allow_only({"source", "forms", "teeth", "curve_mm"});
  const std::filesystem::path folder = file.parent_path() / json["forms"].string();
  ToothRow row;
  std::map<std::string, ToothForm> forms;
  for (const Json& item : json["teeth"].items()) {
    item.allow_only({"form", "at_mm", "turn_deg", "lean_deg", "mirrored"});
    const std::string name = item["form"].string();
    if (!forms.contains(name)) {
      const std::filesystem::path form = folder / (name + ".json");
      std::error_code code;
      if (!std::filesystem::exists(form, code)) item["form"].fail("a form in " + folder.string());
      forms[name] = read_tooth_form(Json::load(form));
    }
    row.teeth.push_back(
        {forms[name], item["at_mm"].vec3() * kMillimetre,
         to_form(item.number_or("turn_deg", 0, -180, 180) * kDegree, item.number_or("lean_deg", 0, -30, 30) * kDegree,
                 item.boolean_or("mirrored", false))});
  }
  if (row.teeth.size() > 32) json["teeth"].fail("at most 32 teeth");
  for (const Json& item : json["curve_mm"].items()) {
    const std::vector<double> v = item.numbers(2);
    const glm::dvec2 p = glm::dvec2(v[0], v[1]) * kMillimetre;
    if (!row.curve.empty() && glm::length(p - row.curve.back()) < 1e-4) item.fail("a point away from the last one");
    row.curve.push_back(p);
  }
  if (row.curve.size() < 2 || row.curve.size() > 200) json["curve_mm"].fail("2 to 200 points");
  return row;
}

}  // namespace typodont
