// Teeth of a jaw beside the working tooth: forms, poses, and the curve of the arch.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/app/tissue/tooth_form.h"
#include "engine/base/pose.h"

namespace typodont {

class Keys;

/// A tooth of the row, in m. Frame of the row: x along the arch (mesial), y to the cheek, z out of the crown, same
/// origin as W.
struct RowTooth {
  ToothForm form;
  dvec3 at{0, 0, 0};  // m, middle of the tooth's neck
  // Rotation from the row's frame to the frame of `form`. Mirrors the teeth on the jaw's other side.
  glm::dmat3 R_FR{1};

  dvec3 to_form(const dvec3& p_row) const { return R_FR * (p_row - at); }
  dvec3 from_form(const dvec3& p) const { return at + glm::transpose(R_FR) * p; }
  double distance(const dvec3& p_row) const { return form.distance(to_form(p_row)); }
};

/// The curve of the arch through the necks of the teeth, from end to end.
class ArchCurve {
 public:
  struct Place {
    double along = 0;   // m, position along the curve, from its first point
    double beside = 0;  // m, distance from the curve; positive towards the cheek
  };
  ArchCurve() = default;
  explicit ArchCurve(std::vector<glm::dvec2> points);
  Place place(const glm::dvec2& p) const;
  const std::vector<glm::dvec2>& points() const { return points_; }

 private:
  std::vector<glm::dvec2> points_;
  std::vector<double> along_;
};

struct ToothRow {
  std::vector<RowTooth> teeth;
  std::vector<glm::dvec2> curve;  // m, points of the curve along which the teeth stand
};

/// Shapes of teeth by name, as far as they were loaded.
using ToothForms = std::map<std::string, ToothForm>;
/// Declares the keys of a tooth. `folder`: files of tooth shapes. Throws Error.
void describe_row_tooth(Keys& keys, RowTooth& tooth, const std::filesystem::path& folder, ToothForms& forms);
/// Declares the keys of a file with a row of teeth. Throws Error.
void describe_tooth_row(Keys& keys, ToothRow& row);
/// Loads a row of teeth with their forms, for example assets/jaw/lower_row.json. Throws Error.
ToothRow load_tooth_row(const std::filesystem::path& file);

}  // namespace typodont
