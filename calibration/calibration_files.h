// Reads the captures and writes the results of the individual solvers, in the formats of docs/interface.md. The name of
// a key contains its unit; in the program, values are in metres and seconds. Throws Error with the file, the line, the
// column, the value that was found, and the value that was expected. Units: each group of length columns ends in _mm or
// in _m. A group in _mm is refused if all its coordinates are below 3 mm, because these are probably metres. A group
// with a coordinate beyond 10 m is also refused.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/camera_solver.h"
#include "calibration/delay_solver.h"
#include "calibration/hand_eye_solver.h"
#include "calibration/registration_solver.h"

namespace typodont::calibration {

struct PointPairs {
  std::vector<dvec3> H, D;
};

/// Poses of two sensors at the same times, with the same number of entries.
struct PosePairs {
  std::vector<Pose> A, B;
};

/// Reads pairs of points in the frames H (haptic base) and D (display), by default from the columns
/// hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm. The arguments `H` and `D` replace the prefixes "h" and "d" of the column names.
PointPairs read_pairs(const std::filesystem::path& file, const std::string& H = "h", const std::string& D = "d");
Stream read_stream(const std::filesystem::path& file);  // the file has the columns t_s,x_mm,y_mm,z_mm
/// Reads pairs of poses. Columns ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz, and the same columns for b. A quaternion's length
/// must be within 1 % of 1.
PosePairs read_pose_pairs(const std::filesystem::path& file);
/// Reads points in frame H of the haptic base. Columns x_mm,y_mm,z_mm or hx_mm,hy_mm,hz_mm. Points that all lie at the
/// origin are accepted.
std::vector<dvec3> read_points(const std::filesystem::path& file);

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H);
std::string delay_json(const DelayResult& result);
/// Writes the result as JSON. `X_name`, `Z_name`: for example "X_SM", "X_HK".
std::string hand_eye_json(const HandEyeResult& result, const char* X_name, const char* Z_name);
std::string camera_json(const CameraResult& result);

}  // namespace typodont::calibration
