// OpenCV's own solvers, for the rows of bench.h to be compared with. Only where TYPODONT_CAMERA is on.
#pragma once

#include <span>

#include "calibration/camera_solver.h"

namespace typodont::calibration {

/// Reprojection rms in pixels, of the panel's sightings.
double opencv_calibration(std::span<const Sighting> sightings, int width_px, int height_px, double panel_width,
                          double panel_height, CameraIntrinsics& camera);
/// cv::estimateAffine3D with a forced rotation (Umeyama).
Pose opencv_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D);
/// cv::estimateAffine3D by RANSAC (an affine motion: OpenCV has no robust rigid one), applied to a point.
dvec3 opencv_robust(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double threshold, const dvec3& p_HQ);

}  // namespace typodont::calibration
