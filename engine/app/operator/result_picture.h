// A picture of the final surface from a fixed direction. Main thread only, except picture_of_result().
#pragma once

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/state.h"
#include "engine/session/report.h"

namespace typodont {

/// Draws the picture on the CPU, on the window's background. If there is an ideal shape,
/// colours show the difference from this shape. Empty if the surface is unknown. Any thread.
render::Picture picture_of_result(const session::ReportOptions& report);

class ResultPicture {
 public:
  ResultPicture(OperatorState& s, InterfaceWindow& w) : s_(s), pictures_(w) {}

  /// Uploads a new picture. Call before the page is drawn.
  void follow();
  /// Frees GPU memory; the next follow() uploads the picture again.
  void destroy();

 private:
  OperatorState& s_;
  UploadedPictures pictures_;
  std::vector<std::uint8_t> shown_;  // pixels that are on the GPU
};

}  // namespace typodont
