// Aligns an intraoral scan with the CBCT of the scan page: reads the mesh, registers points that the user picks, draws
// both surfaces, replaces the crowns. Main thread only.
#pragma once

#include <memory>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/scan_fusion.h"
#include "engine/app/planning/scan_review.h"

namespace typodont {

class FuseDesk {
 public:
  FuseDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work) : s_(s), work_(work), pictures_(w) {}

  /// Shows the page and reads OperatorState::fuse in the background. Needs the CBCT's tissue labels at full voxel size.
  void open();
  /// Registers the scan by the picked points. If the result is refused, the message line states the reason.
  void register_points();
  /// Replaces the crowns and shows the scan page.
  void take();
  /// Redraws changed surfaces. Call before the page is drawn.
  void follow();
  /// Frees the GPU memory of the pictures; the next follow() creates them again.
  void destroy();
  /// Frees the memory of both surfaces.
  void close();

 private:
  OperatorState& s_;
  BackgroundTask& work_;
  std::shared_ptr<ScanFusion> fusion_;
  UploadedPictures pictures_;
};

}  // namespace typodont
