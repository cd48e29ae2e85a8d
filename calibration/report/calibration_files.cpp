#include "calibration/calibration_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>

#include "calibration/report/json_values.h"
#include "engine/base/csv.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

// If all coordinates are below this, the file probably contains metres, not mm; m.
constexpr double kMinReach = 3e-3;
constexpr double kMaxReach = 10;           // m; points farther from the origin than this are refused
constexpr double kUnitLengthError = 0.01;  // largest accepted deviation of a quaternion's length from 1

/// Three columns such as "hx" to "hz". Their unit is mm, or metres if their names in the header end with _m.
struct LengthColumns {
  std::array<std::string, 3> names;
  double unit = kMillimetre;

  LengthColumns(const std::vector<std::string>& header, const std::string& prefix) {
    const auto named = [&](const char* axis) {
      return std::find(header.begin(), header.end(), prefix + axis + "_m") != header.end();
    };
    if (named("x") || named("y") || named("z")) unit = 1;
    const char* const axes[] = {"x", "y", "z"};
    for (std::size_t i = 0; i < 3; ++i) names[i] = prefix + axes[i] + (unit == 1 ? "_m" : "_mm");
  }
  void add_to(std::vector<std::string>& columns) const { columns.insert(columns.end(), names.begin(), names.end()); }
  dvec3 of(const CsvTable& table, std::size_t row) const {
    return dvec3(table.value(row, names[0]), table.value(row, names[1]), table.value(row, names[2])) * unit;
  }
  /// Throws Error if a file in mm has only coordinates below 3 mm (probably metres), or if a coordinate exceeds 10 m.
  void require_plausible(const std::filesystem::path& file, const std::vector<dvec3>& points) const {
    double reach = 0;
    for (const dvec3& p : points) reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const bool metres = unit == 1;
    const std::string place = fmt::format("columns {}", fmt::join(names, ","));
    std::array<std::string, 3> other = names;
    for (std::string& name : other) name = name.substr(0, name.rfind('_')) + (metres ? "_mm" : "_m");
    if (reach > kMaxReach) {
      throw Error(
          file.string(), place, fmt::format("a coordinate of {:.6g} {}", reach / unit, metres ? "m" : "mm"),
          metres ? fmt::format("at most 10 m; name the columns {} where they are millimetres", fmt::join(other, ","))
                 : "at most 10000 mm");
    }
    if (!metres && reach > 0 && reach <= kMinReach) {
      throw Error(file.string(), place, fmt::format("no coordinate larger than {:.4g} mm", reach / unit),
                  fmt::format("more than 3 mm; name the columns {} where they are metres", fmt::join(other, ",")));
    }
  }
};

}  // namespace

PointPairs read_pairs(const std::filesystem::path& file, const std::string& H_name, const std::string& D_name) {
  const auto header = csv_columns(file);
  const LengthColumns H(header, H_name), D(header, D_name);
  std::vector<std::string> columns;
  H.add_to(columns), D.add_to(columns);
  // The columns of the second list (positions of dots, joint angles) may be missing.
  const CsvTable table = read_csv(
      file, columns, {"left_u", "left_v", "right_u", "right_v", "a_rad", "b_rad", "c_rad", "d_rad", "e_rad", "f_rad"});
  if (table.rows.empty()) throw Error(file.string(), "", "no rows", "at least one pair of points");
  PointPairs pairs;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    pairs.H.push_back(H.of(table, i)), pairs.D.push_back(D.of(table, i));
  }
  H.require_plausible(file, pairs.H), D.require_plausible(file, pairs.D);
  return pairs;
}

Stream read_stream(const std::filesystem::path& file) {
  const LengthColumns lengths(csv_columns(file), "");
  std::vector<std::string> columns{"t_s"};
  lengths.add_to(columns);
  const CsvTable table = read_csv(file, columns);
  if (table.rows.size() < 16) {
    throw Error(file.string(), "", fmt::format("{} rows", table.rows.size()), "at least 16 samples");
  }
  Stream stream;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double t = table.value(i, "t_s");
    if (!stream.t.empty() && !(t > stream.t.back())) {
      table.fail(i, "t_s", fmt::format("{}", t), fmt::format("more than {}: times must increase", stream.t.back()));
    }
    stream.t.push_back(t);
    stream.p.push_back(lengths.of(table, i));
  }
  lengths.require_plausible(file, stream.p);
  return stream;
}

PosePairs read_pose_pairs(const std::filesystem::path& file) {
  const auto header = csv_columns(file);
  const LengthColumns a(header, "a"), b(header, "b");
  std::vector<std::string> columns;
  const auto turn_columns = [](const char* prefix) {
    std::array<std::string, 4> names;
    const char* const parts[] = {"qw", "qx", "qy", "qz"};
    for (std::size_t i = 0; i < 4; ++i) names[i] = std::string(prefix) + parts[i];
    return names;
  };
  const auto aq = turn_columns("a"), bq = turn_columns("b");
  a.add_to(columns), columns.insert(columns.end(), aq.begin(), aq.end());
  b.add_to(columns), columns.insert(columns.end(), bq.begin(), bq.end());
  const CsvTable table = read_csv(file, columns);
  const auto rotation = [&](const std::array<std::string, 4>& names, std::size_t row) {
    double q[4];
    for (std::size_t i = 0; i < 4; ++i) q[i] = table.value(row, names[i]);
    const dquat R(q[0], q[1], q[2], q[3]);
    if (const double length = glm::length(R); !(std::abs(length - 1) <= kUnitLengthError)) {
      table.fail(row, fmt::format("{} to {}", names[0], names[3]), fmt::format("a quaternion of length {:.4g}", length),
                 "length 1, within 1 %");
    }
    return glm::normalize(R);
  };
  PosePairs pairs;
  std::vector<dvec3> positions_a, positions_b;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    pairs.A.push_back({a.of(table, i), rotation(aq, i)});
    pairs.B.push_back({b.of(table, i), rotation(bq, i)});
    positions_a.push_back(pairs.A.back().p), positions_b.push_back(pairs.B.back().p);
  }
  a.require_plausible(file, positions_a), b.require_plausible(file, positions_b);
  return pairs;
}

std::vector<dvec3> read_points(const std::filesystem::path& file) {
  const auto header = csv_columns(file);
  const bool prefixed = std::any_of(header.begin(), header.end(), [](const std::string& n) { return n[0] == 'h'; });
  const LengthColumns lengths(header, prefixed ? "h" : "");
  std::vector<std::string> columns;
  lengths.add_to(columns);
  const CsvTable table = read_csv(file, columns);
  std::vector<dvec3> points;
  for (std::size_t i = 0; i < table.rows.size(); ++i) points.push_back(lengths.of(table, i));
  return points;
}

namespace {

/// 6×6 covariance, with m converted to mm.
Value covariance_value(const std::array<double, 36>& covariance) {
  Value rows = Value::array();
  for (std::size_t i = 0; i < 6; ++i) {
    Value row = Value::array();
    for (std::size_t j = 0; j < 6; ++j) row.push_back(covariance[6 * i + j] * (i < 3 ? 1 : 1e3) * (j < 3 ? 1 : 1e3));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H) {
  Value json;
  json["X_DH"] = pose_value(result.X_DH);
  json["fre_rms_mm"] = result.fre_rms * 1e3;
  json["sigma_mm"] = number_value(result.sigma * 1e3);
  json["covariance"] = covariance_value(result.covariance);
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

std::string hand_eye_json(const HandEyeResult& result, const char* X_name, const char* Z_name) {
  Value json;
  const auto sigmas = [](const std::array<double, 36>& covariance) {
    const auto largest = [&](std::size_t first) {
      double variance = 0;
      for (std::size_t i = first; i < first + 3; ++i) variance = std::max(variance, covariance[7 * i]);
      return std::sqrt(variance);
    };
    return std::pair(largest(0) / kDegree, largest(3) * 1e3);
  };
  const auto add = [&](const std::string& name, const Pose& X, const std::array<double, 36>& covariance) {
    json[name] = pose_value(X);
    json[name + "_covariance"] = covariance_value(covariance);
    std::tie(json[name + "_sigma_deg"], json[name + "_sigma_mm"]) = sigmas(covariance);
  };
  add(X_name, result.X, result.X_covariance);
  if (Z_name) add(Z_name, result.Z, result.Z_covariance);
  json["noise_deg"] = result.rotation_sigma / kDegree;
  json["noise_mm"] = result.translation_sigma * 1e3;
  json["main_turn_deg"] = result.main_turn / kDegree;
  json["second_turn_deg"] = result.second_turn / kDegree;
  json["inliers"] = result.inliers;
  json["outliers"] = result.outliers;
  json["residuals_deg"] = Value::array();
  for (const double r : result.rotation_residuals) json["residuals_deg"].push_back(r / kDegree);
  json["residuals_mm"] = Value::array();
  for (const double r : result.translation_residuals) json["residuals_mm"].push_back(r * 1e3);
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
