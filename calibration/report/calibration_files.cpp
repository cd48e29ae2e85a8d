#include "calibration/calibration_files.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calibration/report/json_values.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

dvec3 point(const CsvTable& table, const std::vector<double>& row, const char* x, const char* y, const char* z) {
  const auto at = [&](const char* name) { return row[static_cast<std::size_t>(table.column(name))]; };
  return dvec3(at(x), at(y), at(z)) * kMillimetre;
}

bool header_has(const std::filesystem::path& file, std::string_view column) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (!line.empty() && line.front() != '#') return line.find(column) != std::string::npos;
  }
  return false;
}

}  // namespace

Stream read_stream(const std::filesystem::path& file) {
  const CsvTable table = read_csv(file, {"t_s", "x_mm", "y_mm", "z_mm"});
  if (table.rows.size() < 16) {
    throw Error(file.string(), "", fmt::format("{} rows", table.rows.size()), "at least 16 samples");
  }
  Stream stream;
  const auto time = static_cast<std::size_t>(table.column("t_s"));
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double t = table.rows[i][time];
    if (!stream.t.empty() && !(t > stream.t.back())) {
      table.fail(i, "t_s", fmt::format("{}", t), fmt::format("more than {}: times must increase", stream.t.back()));
    }
    stream.t.push_back(t);
    stream.p.push_back(point(table, table.rows[i], "x_mm", "y_mm", "z_mm"));
  }
  return stream;
}

std::vector<dvec3> read_points(const std::filesystem::path& file) {
  const bool prefixed = header_has(file, "hx_mm");
  const char *x = prefixed ? "hx_mm" : "x_mm", *y = prefixed ? "hy_mm" : "y_mm", *z = prefixed ? "hz_mm" : "z_mm";
  const CsvTable table = read_csv(file, {x, y, z});
  std::vector<dvec3> points;
  for (const auto& row : table.rows) points.push_back(point(table, row, x, y, z));
  return points;
}

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H) {
  Value json;
  json["X_DH"] = pose_value(result.X_DH);
  json["fre_rms_mm"] = result.fre_rms * 1e3;
  json["sigma_mm"] = number_value(result.sigma * 1e3);
  // Rotation stays in rad; translation m -> mm.
  Value covariance = Value::array();
  for (std::size_t i = 0; i < 6; ++i) {
    Value row = Value::array();
    for (std::size_t j = 0; j < 6; ++j) {
      row.push_back(result.covariance[6 * i + j] * (i < 3 ? 1 : 1e3) * (j < 3 ? 1 : 1e3));
    }
    covariance.push_back(row);
  }
  json["covariance"] = covariance;
  json["predicted_tre_mm"]["rms"] = result.predicted_tre_rms * 1e3;
  json["predicted_tre_mm"]["targets"] = Value::array();
  for (const dvec3& target : targets_H) {
    json["predicted_tre_mm"]["targets"].push_back(predicted_tre(result, target) * 1e3);
  }
  json["inliers"] = result.inliers;
  json["outliers"] = result.outliers;
  json["condition"] = result.condition;
  if (result.degeneracy.defect == Defect::kNone) {
    json["degenerate"] = false;
  } else {
    Value directions = Value::array();
    for (const dvec3& axis : result.degeneracy.undetermined_H) directions.push_back(vec3_value(axis));
    json["degenerate"] = {{"kind", name(result.degeneracy.defect)}, {"reason", result.degeneracy.reason}};
    if (!directions.empty()) json["degenerate"]["direction"] = directions.front();
    json["degenerate"]["undetermined_rotation_axes_H"] = directions;
  }
  json["ambiguous"] = !result.rivals.empty();
  json["rivals"] = Value::array();
  for (const Rival& rival : result.rivals) {
    json["rivals"].push_back({{"X_DH", pose_value(rival.X_DH)}, {"pairs", rival.pairs}});
  }
  json["residuals_mm"] = Value::array();
  for (const double r : result.residuals) json["residuals_mm"].push_back(r * 1e3);
  json["degrees_of_freedom"] = result.degrees_of_freedom;
  return json.dump(2) + "\n";
}

std::string delay_json(const DelayResult& result) {
  Value json;
  json["delay_ms"] = result.delay * 1e3;
  json["sigma_ms"] = result.sigma * 1e3;
  json["ambiguous"] = result.ambiguous;
  json["rich"] = result.rich;
  json["reason"] = result.reason;
  json["candidates_ms"] = Value::array();
  for (const double c : result.candidates) json["candidates_ms"].push_back(c * 1e3);
  json["skew_ppm"] = result.skew * 1e6;
  json["skew_sigma_ppm"] = result.skew_sigma * 1e6;
  json["reference_time_s"] = result.reference_time;
  json["delay_at_end_ms"] = result.delay_at_end * 1e3;
  json["noise_mm"] = result.noise * 1e3;
  json["X_BA"] = pose_value(result.X_BA);
  json["rotated"] = result.rotated;
  json["samples"] = result.samples;
  json["lost"] = {{"a", result.lost_a}, {"b", result.lost_b}};
  json["frozen"] = {{"a", result.frozen_a}, {"b", result.frozen_b}};
  json["rejected"] = result.rejected;
  return json.dump(2) + "\n";
}

std::string camera_json(const CameraResult& result) {
  Value json;
  const auto lens = [](const CameraIntrinsics& c) {
    return Value{{"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}, {"distortion", c.distortion}};
  };
  json["camera_px"] = lens(result.camera);
  json["camera_sigma_px"] = lens(result.camera_sigma);
  json["rms_px"] = result.rms_px;
  json["worst_px"] = result.worst_px;
  json["outliers"] = result.outliers;
  json["screen"] = {{"corners_mm",
                     {{"lower_left", mm_value(result.panel.lower_left)},
                      {"lower_right", mm_value(result.panel.lower_right)},
                      {"upper_left", mm_value(result.panel.upper_left)}}},
                    {"width_mm", result.width * 1e3},
                    {"width_sigma_mm", result.width_sigma * 1e3},
                    {"height_mm", result.height * 1e3},
                    {"height_sigma_mm", result.height_sigma * 1e3},
                    {"centre_sigma_mm", mm_value(result.centre_sigma)},
                    {"tilt_sigma_rad", result.tilt_sigma}};
  if (result.mirror) {
    json["mirror"] = {{"normal", vec3_value(result.mirror->normal)},
                      {"offset_mm", result.mirror->offset * 1e3},
                      {"tilt_sigma_rad", result.mirror_tilt_sigma},
                      {"offset_sigma_mm", result.mirror_offset_sigma * 1e3}};
  }
  return json.dump(2) + "\n";
}

}  // namespace typodont::calibration
