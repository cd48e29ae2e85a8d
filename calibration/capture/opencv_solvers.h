// OpenCV's solvers as baselines, with TYPODONT_CAMERA.
#pragma once

#include <span>

#include "calibration/camera_solver.h"

namespace typodont::calibration {

/// rms reprojection error of the panel's corners, pixels.
double opencv_calibration(std::span<const Sighting> sightings, int width_px, int height_px, double panel_width,
                          double panel_height, CameraIntrinsics& camera);
/// Rigid fit by cv::estimateAffine3D with a forced rotation (Umeyama).
Pose opencv_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D);
/// cv::estimateAffine3D (RANSAC): OpenCV has no robust rigid fit.
dvec3 opencv_robust(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double threshold, const dvec3& p_HQ);

}  // namespace typodont::calibration
