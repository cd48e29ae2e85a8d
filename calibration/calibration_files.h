// The files of the single solvers, as INTERFACE.md describes them: reading captures, writing results. Keys carry the
// unit; inside it is metres and seconds. Throws Error naming file, line, column, found, expected.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/camera_solver.h"
#include "calibration/delay_solver.h"
#include "calibration/registration_solver.h"

namespace typodont::calibration {

struct PointPairs {
  std::vector<dvec3> H, D;
};

PointPairs read_pairs(const std::filesystem::path& file);  // hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm
Stream read_stream(const std::filesystem::path& file);     // t_s,x_mm,y_mm,z_mm
/// Points in H: columns x_mm,y_mm,z_mm or hx_mm,hy_mm,hz_mm.
std::vector<dvec3> read_points(const std::filesystem::path& file);

std::string registration_json(const RegistrationResult& result, const std::vector<dvec3>& targets_H);
std::string delay_json(const DelayResult& result);
std::string camera_json(const CameraResult& result);

}  // namespace typodont::calibration
