// An intraoral scan laid over the CBCT of the scan page: reads the mesh, registers the points that the user picks,
// draws both surfaces, and replaces the crowns. Main thread.
#pragma once

#include <memory>
#include <vector>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/scan_fusion.h"
#include "engine/app/planning/scan_review.h"

namespace typodont {

class FuseDesk {
 public:
  FuseDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work) : s_(s), window_(w), work_(work) {}
  ~FuseDesk() { destroy(); }
  FuseDesk(const FuseDesk&) = delete;
  FuseDesk& operator=(const FuseDesk&) = delete;

  /// Shows the page and reads the mesh of OperatorState::fuse while the window continues. The scan page must have
  /// exact labels.
  void open();
  /// Registers the picked points; refused results are reported in the message line.
  void register_points();
  /// Replaces the crowns in the review of the scan page, and returns to this page.
  void take();
  /// Draws the surfaces if they changed. Call before drawing the page.
  void follow();
  /// Destroys the pictures' GPU memory, e.g. of a lost device. The next follow() draws them again.
  void destroy();
  /// Frees the surfaces.
  void close();

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  BackgroundTask& work_;
  std::shared_ptr<ScanFusion> fusion_;
  std::vector<gpu::Image> images_;
};

}  // namespace typodont
