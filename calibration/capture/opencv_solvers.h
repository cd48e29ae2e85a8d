// OpenCV's solvers, as baselines for the rows of bench.h. Available only if TYPODONT_CAMERA is on.
#pragma once

#include <span>

#include "calibration/camera_solver.h"

namespace typodont::calibration {

/// Calibrates with OpenCV. Returns the root-mean-square reprojection error (pixels) of the panel's corners.
double opencv_calibration(std::span<const Sighting> sightings, int width_px, int height_px, double panel_width,
                          double panel_height, CameraIntrinsics& camera);
/// Rigid fit by cv::estimateAffine3D with a forced rotation (Umeyama).
Pose opencv_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D);
/// Robust fit by cv::estimateAffine3D with RANSAC, applied to a point. The fit is an affine motion, because OpenCV has
/// no robust fit of a rigid motion.
dvec3 opencv_robust(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double threshold, const dvec3& p_HQ);

}  // namespace typodont::calibration
