// Aligns an intraoral scan with the CBCT of the scan page: reads the mesh, registers points that the user picks, draws
// both surfaces, replaces the crowns. Main thread only.
#pragma once

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/preview.h"
#include "engine/app/operator/state.h"

namespace typodont {

class FuseDesk {
 public:
  FuseDesk(OperatorState& s, InterfaceWindow& w, BackgroundTask& work)
      : s_(s), work_(work), preview_(s, w, s.fuse.pictures) {}

  /// Shows the page and reads OperatorState::fuse in the background. Needs the CBCT's tissue labels at full voxel size.
  void open();
  /// Registers the scan by the picked points. If the result is refused, the message line states the reason.
  void register_points();
  /// Replaces the crowns and shows the scan page.
  void take();
  /// Draws changed surfaces. True: the pictures have changed.
  bool look();
  /// Frees the memory of both surfaces.
  void close();

 private:
  OperatorState& s_;
  BackgroundTask& work_;
  Preview preview_;
};

}  // namespace typodont
