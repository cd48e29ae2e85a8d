#include <fmt/format.h>

#include <cmath>

#include "engine/base/error.h"
#include "engine/base/voxels.h"
#include "haptics/import/import.h"

namespace typodont::haptics {

glm::dmat3 quarter_turns(const std::string& text) {
  const auto bad = [&] {
    return Error("--turn", "", '"' + text + '"', "quarter turns about axes, e.g. x180 or x90,z-90");
  };
  glm::dmat3 all(1);
  std::size_t at = 0;
  while (true) {
    std::size_t end = text.find(',', at);
    if (end == std::string::npos) end = text.size();
    const std::string one = text.substr(at, end - at);
    const int axis = one.empty() ? -1 : one[0] - 'x';
    const std::string degrees = one.empty() ? "" : one.substr(1);
    int quarters = 0;
    if (degrees == "90") quarters = 1;
    if (degrees == "180" || degrees == "-180") quarters = 2;
    if (degrees == "270" || degrees == "-90") quarters = 3;
    if (axis < 0 || axis > 2 || quarters == 0) throw bad();
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    glm::dmat3 quarter(0);  // rotation by 90 degrees: the axis u becomes v, and v becomes −u
    quarter[axis][axis] = 1;
    quarter[u][v] = 1;
    quarter[v][u] = -1;
    for (int k = 0; k < quarters; ++k) all = quarter * all;
    if (end == text.size()) return all;
    at = end + 1;
  }
}

void turn(Imported& imported, const glm::dmat3& by) {
  if (by == glm::dmat3(1)) return;
  // Axis w of the rotated volume is the axis from[w] of the old volume, multiplied by sign[w].
  glm::ivec3 from(0), sign(1);
  for (int w = 0; w < 3; ++w) {
    for (int f = 0; f < 3; ++f) {
      if (std::abs(by[f][w]) > 0.5) from[w] = f, sign[w] = by[f][w] > 0 ? 1 : -1;
    }
  }
  DenseTissue& in = imported.tissue;
  DenseTissue out;
  out.band = in.band;
  out.exact_outside = in.exact_outside;
  out.place = in.place;
  out.place.X_FW.R = glm::normalize(in.place.X_FW.R * glm::quat_cast(glm::transpose(by)));
  out.frame.voxel = in.frame.voxel;
  for (int w = 0; w < 3; ++w) out.size[w] = in.size[from[w]];
  // Position of the old voxel that becomes voxel (0,0,0) of the rotated volume.
  dvec3 first(0);
  for (int w = 0; w < 3; ++w) first[from[w]] = sign[w] > 0 ? 0 : in.size[from[w]] - 1;
  out.frame.origin = by * in.frame.to_world(first);
  out.distance.resize(in.distance.size());
  out.tissue.resize(in.tissue.size());
  out.hardness.resize(in.hardness.size());
  std::vector<float> grey(imported.grey.size());
  for_each_voxel(out.size, [&](const glm::ivec3& to) {
    glm::ivec3 old;
    for (int w = 0; w < 3; ++w) old[from[w]] = sign[w] > 0 ? to[w] : out.size[w] - 1 - to[w];
    const std::size_t i = out.at(to.x, to.y, to.z), was = in.at(old.x, old.y, old.z);
    out.distance[i] = in.distance[was];
    out.tissue[i] = in.tissue[was];
    if (!out.hardness.empty()) out.hardness[i] = in.hardness[was];
    if (!grey.empty()) grey[i] = imported.grey[was];
  });
  in = std::move(out);
  imported.grey = std::move(grey);
  ImportReport& report = imported.report;
  const auto turn_box = [&](dvec3& lo, dvec3& hi) {
    const dvec3 a = by * lo, b = by * hi;
    lo = glm::min(a, b), hi = glm::max(a, b);
  };
  turn_box(report.lo, report.hi);
  for (dvec3& p : report.repaired) p = by * p;
  for (ImportRegion& other : report.others) turn_box(other.lo, other.hi);
  report.size = in.size;
  report.world_rotation = report.world_rotation * glm::transpose(by);
}

}  // namespace typodont::haptics
