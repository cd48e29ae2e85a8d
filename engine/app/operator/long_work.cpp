#include "engine/app/operator/long_work.h"

#include "engine/gpu/device.h"

namespace typodont {

void BackgroundTask::drop() {
  Job::drop();
  s_.busy = false;
}

bool BackgroundTask::look() {
  if (!under_way()) return false;
  const bool ended = done();
  s_.busy = !ended;
  s_.busy_fraction = progress()->fraction();
  s_.busy_what = s_.text(progress()->what());
  if (!ended) return false;
  try {
    return Job::look();
  } catch (const gpu::DeviceLost& e) {
    s_.fail(e.what());
    throw;
  } catch (const Cancelled&) {
    s_.say(s_.text("op.cancelled"));
  } catch (const std::exception& e) {
    s_.fail(e.what());
  }
  return true;
}

}  // namespace typodont
