// The final surface from a fixed direction. Main thread only, except picture_of_result().
#pragma once

#include <optional>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/state.h"
#include "engine/session/report.h"

namespace typodont {

/// By software, on the window's background; with an ideal, the difference to it. Empty if the surface is unknown. Any
/// thread.
render::Picture picture_of_result(const session::ReportOptions& report);

class ResultPicture {
 public:
  ResultPicture(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~ResultPicture() { destroy(); }
  ResultPicture(const ResultPicture&) = delete;
  ResultPicture& operator=(const ResultPicture&) = delete;

  /// Uploads a new picture, before the page is drawn.
  void follow();
  /// GPU memory; the next follow() uploads again.
  void destroy();

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::optional<gpu::Image> image_;
  std::vector<std::uint8_t> shown_;  // pixels that are on the GPU
};

}  // namespace typodont
