// This is the only file that uses OpenCV. Pictures are read with stb, because OpenCV's readers need a hundred further
// libraries.
#include <stb/stb_image.h>

#include <map>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/camera_solver.h"
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
  // A mirror reverses the order of the corners.
  if (mirrored) cv::flip(grey, grey, 1);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(grey, cv::Size(columns, rows), corners,
                                   cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY))
    return {};
  // A light first inner cell means that OpenCV found the board rotated by 180°.
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

}  // namespace typodont::calibration
