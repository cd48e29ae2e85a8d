#include "engine/app/picture/picture_record.h"

namespace typodont {

session::StreamSpec picture_stream() {
  return {"picture",
          {{"period_s", "s"},
           {"record_s", "s"},
           {"gpu_s", "s"},
           {"motion_to_photon_s", "s"},
           {"redrawn", ""},
           {"quality_step", ""}}};
}

std::vector<double> picture_stream_row(const PictureTiming& timing) {
  return {timing.period,           timing.record,  timing.gpu,
          timing.motion_to_photon, timing.redrawn, static_cast<double>(timing.step)};
}

}  // namespace typodont
