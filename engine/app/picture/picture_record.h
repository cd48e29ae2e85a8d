// What the picture of a live session leaves in its recording: a row a frame.
#pragma once

#include <vector>

#include "engine/base/clock.h"
#include "engine/session/session_data.h"

namespace typodont {

struct PictureTiming {
  Nanos t = 0;                  // when it was begun, on the machine's clock
  double period = 0;            // s since the frame before
  double record = 0;            // s: preparing it and handing it over
  double gpu = 0;               // s: drawing it, by the GPU's own clock; of the newest frame that is done
  double motion_to_photon = 0;  // s, estimated: from the hand's sample shown to the middle of the screen's next picture
  double redrawn = 1;           // share of the picture that was drawn anew
  int step = 0;                 // of the quality ladder, 0: best
};

session::StreamSpec picture_stream();
std::vector<double> picture_stream_row(const PictureTiming& timing);

}  // namespace typodont
