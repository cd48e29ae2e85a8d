// The row of teeth around the working tooth: forms and poses of the teeth, and the curve on which they lie.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/surroundings/tooth_form.h"
#include "engine/base/pose.h"

namespace typodont {

/// A tooth of the row. In the frame of the row, x points along the arch at the working tooth (mesial), y to the cheek
/// and z out of the crown. Its origin is the origin of frame W. Lengths in m.
struct RowTooth {
  ToothForm form;
  dvec3 at{0, 0, 0};  // m, middle of the tooth's neck
  // Rotation from the frame of the row (R) to the frame of the tooth's form (F). It includes a reflection for a tooth
  // of the other side of the jaw.
  glm::dmat3 R_FR{1};

  dvec3 to_form(const dvec3& p_row) const { return R_FR * (p_row - at); }
  dvec3 from_form(const dvec3& p) const { return at + glm::transpose(R_FR) * p; }
  double distance(const dvec3& p_row) const { return form.distance(to_form(p_row)); }
};

/// The polyline through the necks of the teeth, from one end of the row to the other.
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

/// Reads a row of teeth (assets/jaw/lower_row.json) and the forms of its teeth. Throws Error.
ToothRow load_tooth_row(const std::filesystem::path& file);

}  // namespace typodont
