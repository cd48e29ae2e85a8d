// The picture on the result page. It shows the final surface from a fixed direction. Main thread only, except
// picture_of_result().
#pragma once

#include <optional>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/state.h"
#include "engine/session/report.h"

namespace typodont {

/// Draws the final surface by software, on the background colour of the window. If there is an ideal result, the
/// picture shows the difference to the ideal. The picture is empty if the surface is unknown. For any thread.
render::Picture picture_of_result(const session::ReportOptions& report);

class ResultPicture {
 public:
  ResultPicture(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~ResultPicture() { destroy(); }
  ResultPicture(const ResultPicture&) = delete;
  ResultPicture& operator=(const ResultPicture&) = delete;

  /// Uploads the picture of the session's result if it is new. Call it before the page is drawn.
  void follow();
  /// Frees the GPU memory, for example after the GPU was lost. The next follow() uploads the picture again.
  void destroy();

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::optional<gpu::Image> image_;
  std::vector<std::uint8_t> shown_;  // pixels of the picture that is on the GPU
};

}  // namespace typodont
