#include "engine/app/tissue/row.h"

#include <cmath>

#include "engine/base/keys.h"
#include "engine/base/nearest.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

/// Rotation from the row's frame to a tooth form's frame. `turn`: about z; `lean`: towards the tongue; `mirrored`:
/// with a reflection, for a tooth on the other side of the jaw.
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
  // Distance to the nearest segment of the curve so far: its square, m²; the distance itself, m.
  double nearest = 1e9, reach = 1e9;
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    const glm::dvec2 r = p - points_[i];
    const double farthest = reach + along_[i + 1] - along_[i];
    // Skips a segment that cannot be nearer than the nearest segment so far.
    if (glm::dot(r, r) > farthest * farthest) continue;
    const glm::dvec2 d = points_[i + 1] - points_[i];
    const double t = nearest_fraction(points_[i], points_[i + 1], p);
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

void describe_row_tooth(Keys& keys, RowTooth& tooth, const std::filesystem::path& folder, ToothForms& forms) {
  if (const auto form = keys(must("form"), kName, "the file `FOLDER/FORM.json`")) {
    const std::string name = form->string();
    if (!forms.contains(name)) {
      const std::filesystem::path file = folder / (name + ".json");
      std::error_code code;
      if (!std::filesystem::exists(file, code)) form->fail("a form in " + folder.string());
      forms[name] = read_tooth_form(Json::load(file));
    }
    tooth.form = forms[name];
  }
  keys(must("at_mm"), tooth.at, kMillimetre, "middle of the tooth's neck");
  double turn = 0, lean = 0;
  bool mirrored = false;
  keys("turn_deg", turn, {-180, 180, kDegree}, "rotation about z");
  keys("lean_deg", lean, {-30, 30, kDegree}, "inclination towards the tongue");
  keys("mirrored", mirrored, "true: the mirror image of the form, for a tooth of the other side");
  tooth.R_FR = to_form(turn, lean, mirrored);
}

void describe_tooth_row(Keys& keys, ToothRow& row) {
  keys.ignore("source");
  std::filesystem::path folder;
  ToothForms forms;
  if (const auto json = keys(must("forms"), Form{"folder", kText.schema}, "shapes of teeth; relative to the row file"))
    folder = json->file().parent_path() / json->string();
  keys(
      must("teeth"), row.teeth, [&](Keys& of, RowTooth& tooth) { describe_row_tooth(of, tooth, folder, forms); },
      "at most 32 teeth");
  if (row.teeth.size() > 32) (*keys.json())["teeth"].fail("at most 32 teeth");
  const auto curve =
      keys(must("curve_mm"), kPoints,
           "2 to 200 points `[x, y]`: curve through the necks of the teeth (between crown and root), from "
           "the most distal tooth past the midline to the other side");
  if (!curve) return;
  for (const Json& item : curve->items()) {
    const std::vector<double> v = item.numbers(2);
    const glm::dvec2 p = glm::dvec2(v[0], v[1]) * kMillimetre;
    if (!row.curve.empty() && glm::length(p - row.curve.back()) < 1e-4) item.fail("a point away from the last one");
    row.curve.push_back(p);
  }
  if (row.curve.size() < 2 || row.curve.size() > 200) curve->fail("2 to 200 points");
}

ToothRow load_tooth_row(const std::filesystem::path& file) {
  return read_keys(Json::load(file), describe_tooth_row);
}

}  // namespace typodont
