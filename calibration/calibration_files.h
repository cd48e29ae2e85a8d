// Captures and results of single solvers, in the formats of docs/interface.md. Keys have units; values are SI. Throws
// Error. A length group in _mm within 3 mm, or beyond 10 m, is refused.
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

/// At the same times; equally many.
struct PosePairs {
  std::vector<Pose> A, B;
};

/// Columns hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm; `H`, `D` replace the prefixes.
PointPairs read_pairs(const std::filesystem::path& file, const std::string& H = "h", const std::string& D = "d");
Stream read_stream(const std::filesystem::path& file);  // the file has the columns t_s,x_mm,y_mm,z_mm
/// Columns ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz, the same for b; |q| within 1 % of 1.
PosePairs read_pose_pairs(const std::filesystem::path& file);
/// Columns x_mm,y_mm,z_mm or hx_mm,hy_mm,hz_mm, frame H. All zero is accepted.
std::vector<dvec3> read_points(const std::filesystem::path& file);

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H);
std::string delay_json(const DelayResult& result);
/// `X_name`, `Z_name`: for example "X_SM", "X_HK".
std::string hand_eye_json(const HandEyeResult& result, const char* X_name, const char* Z_name);
std::string camera_json(const CameraResult& result);

}  // namespace typodont::calibration
