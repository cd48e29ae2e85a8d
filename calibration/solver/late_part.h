// The functions that need Ceres or OpenCV. They are in a shared object of their own, which is loaded at their first
// use.
#pragma once

#include "calibration/camera_solver.h"
#include "calibration/hand_eye_solver.h"

namespace typodont::calibration {

struct LatePart {
  decltype(&project) project_point;
  decltype(&solve_camera) camera;
  decltype(&solve_hand_eye) hand_eye;
#ifdef TYPODONT_CAMERA
  decltype(&find_board) board;
#endif
};

}  // namespace typodont::calibration

/// The variable of the shared object typodont-calibration.so.
extern "C" __attribute__((visibility("default"))) const typodont::calibration::LatePart typodont_calibration_part;
