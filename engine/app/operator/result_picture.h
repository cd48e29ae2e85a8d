// The picture of the result on the window's result page: what was left, from a set view. Main thread but for
// picture_of_result().
#pragma once

#include <optional>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/state.h"
#include "engine/session/report.h"

namespace typodont {

/// Drawn by the processor, on the window's ground; against the ideal where there is one. No pixels where nothing is
/// known of the surface. Any thread.
render::Picture picture_of_result(const session::ReportOptions& report);

class ResultPicture {
 public:
  ResultPicture(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~ResultPicture() { destroy(); }
  ResultPicture(const ResultPicture&) = delete;
  ResultPicture& operator=(const ResultPicture&) = delete;

  /// The outcome's picture on the GPU, before it is drawn; another outcome has another one.
  void follow();
  /// Its memory on the GPU, e.g. of one that is lost. It comes back with the next follow().
  void destroy();

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::optional<gpu::Image> image_;
  std::vector<std::uint8_t> shown_;  // pixels that are on the GPU
};

}  // namespace typodont
