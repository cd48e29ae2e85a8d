// Aligns an intraoral scan with the CBCT (cone beam CT) of the scan page. Reads the scan's mesh, registers the points
// that the user picks, draws both surfaces, and replaces the crowns. Main thread only.
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

  /// Shows the page and reads the mesh of OperatorState::fuse in the background. Before this, the scan page must have
  /// computed the tissue labels with the scan's own voxel size.
  void open();
  /// Registers the two surfaces by the picked points. If the result is refused, the message line states the reason.
  void register_points();
  /// Replaces the crowns in the CBCT of the scan page by the surface of the intraoral scan, then shows the scan page.
  void take();
  /// Draws the surfaces again if they have changed. Call it before the page is drawn.
  void follow();
  /// Frees the GPU memory of the pictures, for example after the GPU was lost. The next follow() creates them again.
  void destroy();
  /// Frees the memory of both surfaces (intraoral scan and CT).
  void close();

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  BackgroundTask& work_;
  std::shared_ptr<ScanFusion> fusion_;
  std::vector<gpu::Image> images_;
};

}  // namespace typodont
