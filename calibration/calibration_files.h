// Reads captures, and writes results of single solvers, in the formats of docs/interface.md. Throws Error. A file is
// refused for a wrong unit if all lengths in columns _mm are below 3 mm, or if a point is beyond 10 m.
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

/// Poses of two devices at the same times; both lists have the same length.
struct PosePairs {
  std::vector<Pose> A, B;
};

/// Reads columns hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm. `H` and `D`: prefixes of the column names, here h and d.
PointPairs read_pairs(const std::filesystem::path& file, const std::string& H = "h", const std::string& D = "d");
Stream read_stream(const std::filesystem::path& file);  // the file has the columns t_s,x_mm,y_mm,z_mm
/// Reads columns ax_mm,ay_mm,az_mm,aqw,aqx,aqy,aqz and bx_mm … bqz; |q| must be within 1 % of 1.
PosePairs read_pose_pairs(const std::filesystem::path& file);
/// Reads columns x_mm,y_mm,z_mm or hx_mm,hy_mm,hz_mm, frame H. Accepts a file in which all points are zero.
std::vector<dvec3> read_points(const std::filesystem::path& file);

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H);
std::string delay_json(const DelayResult& result);
/// `X_name`, `Z_name`: names of the poses in the result, for example "X_SM", "X_HK".
std::string hand_eye_json(const HandEyeResult& result, const char* X_name, const char* Z_name);
std::string camera_json(const CameraResult& result);

}  // namespace typodont::calibration
