// The only file with OpenCV. stb reads pictures: OpenCV's readers load a hundred libraries.
#include <stb/stb_image.h>

#include <map>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/camera_solver.h"
#include "calibration/capture/opencv_solvers.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"

namespace typodont::calibration {

std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored) {
  require_input(picture, InputKind::kPicture);
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> bytes(
      stbi_load(picture.c_str(), &width, &height, &channels, STBI_grey), stbi_image_free);
  if (!bytes) throw Error(picture.string(), "", "no picture", "a PNG, JPEG or PGM file");
  cv::Mat grey(height, width, CV_8U, bytes.get());
  // A mirror reverses the corners.
  if (mirrored) cv::flip(grey, grey, 1);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(grey, cv::Size(columns, rows), corners,
                                   cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY))
    return {};
  // A light first inner cell: found turned by 180°.
  const auto& at = [&](int x, int y) { return corners[static_cast<std::size_t>(y * columns + x)]; };
  const auto brightness = [&](int x, int y) {
    const cv::Point2f middle = 0.25f * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1));
    return static_cast<int>(grey.at<unsigned char>(cvRound(middle.y), cvRound(middle.x)));
  };
  if (brightness(0, 0) > brightness(columns - 2, rows - 2)) std::reverse(corners.begin(), corners.end());
  std::vector<Pixel> pixels;
  for (const cv::Point2f& c : corners) {
    pixels.push_back({mirrored ? static_cast<double>(grey.cols - 1) - c.x : static_cast<double>(c.x), c.y});
  }
  return pixels;
}

double opencv_calibration(std::span<const Sighting> sightings, int width_px, int height_px, double panel_width,
                          double panel_height, CameraIntrinsics& camera) {
  std::map<int, std::pair<std::vector<cv::Point3f>, std::vector<cv::Point2f>>> pictures;
  for (const Sighting& s : sightings) {
    if (s.on != SeenOn::kPanel) continue;
    auto& [object, image] = pictures[s.picture];
    object.emplace_back(static_cast<float>(s.corner.u * panel_width), static_cast<float>(s.corner.v * panel_height),
                        0.0f);
    image.emplace_back(static_cast<float>(s.px), static_cast<float>(s.py));
  }
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (auto& [id, pair] : pictures) objects.push_back(pair.first), images.push_back(pair.second);
  cv::Mat K, distortion;
  std::vector<cv::Mat> rotations, translations;
  const double rms =
      cv::calibrateCamera(objects, images, cv::Size(width_px, height_px), K, distortion, rotations, translations);
  camera.fx = K.at<double>(0, 0), camera.fy = K.at<double>(1, 1), camera.cx = K.at<double>(0, 2),
  camera.cy = K.at<double>(1, 2);
  for (int i = 0; i < 5; ++i) camera.distortion[static_cast<std::size_t>(i)] = distortion.at<double>(i);
  return rms;
}

namespace {
cv::Mat points_of(std::span<const dvec3> points) {
  cv::Mat m(static_cast<int>(points.size()), 3, CV_64F);
  for (int i = 0; i < m.rows; ++i) {
    for (int axis = 0; axis < 3; ++axis) m.at<double>(i, axis) = points[static_cast<std::size_t>(i)][axis];
  }
  return m;
}
}  // namespace

Pose opencv_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) {
  double scale = 1;
  const cv::Mat m = cv::estimateAffine3D(points_of(p_H), points_of(p_D), &scale, true);
  glm::dmat3 R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R[j][i] = m.at<double>(i, j);
  }
  return {dvec3(m.at<double>(0, 3), m.at<double>(1, 3), m.at<double>(2, 3)), glm::normalize(glm::quat_cast(R))};
}

dvec3 opencv_robust(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double threshold, const dvec3& p) {
  cv::Mat m, inliers;
  cv::estimateAffine3D(points_of(p_H), points_of(p_D), m, inliers, threshold, 0.99);
  if (m.empty()) return dvec3(std::nan(""));
  dvec3 q;
  for (int i = 0; i < 3; ++i)
    q[i] = m.at<double>(i, 0) * p.x + m.at<double>(i, 1) * p.y + m.at<double>(i, 2) * p.z + m.at<double>(i, 3);
  return q;
}

}  // namespace typodont::calibration
