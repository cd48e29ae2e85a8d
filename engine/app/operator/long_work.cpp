#include "engine/app/operator/long_work.h"

#include <utility>

#include "engine/gpu/device.h"

namespace typodont {

void BackgroundTask::begin(std::function<void(Progress&)> work, std::function<void()> then,
                           std::function<void()> failed) {
  job_.reset();
  then_ = std::move(then);
  failed_ = std::move(failed);
  job_ = std::make_unique<Job>(std::move(work));
}

void BackgroundTask::cancel() {
  if (job_) job_->progress().cancel();
}

void BackgroundTask::drop() {
  job_.reset();
  then_ = failed_ = {};
  s_.busy = false;
}

bool BackgroundTask::look() {
  if (!job_) return false;
  s_.busy = !job_->done();
  s_.busy_fraction = job_->progress().fraction();
  s_.busy_what = s_.text(job_->progress().what());
  if (s_.busy) return false;
  const auto finished = std::move(job_);
  const auto then = std::exchange(then_, {}), failed = std::exchange(failed_, {});
  try {
    if (finished->failure() && failed) failed();
    if (finished->failure()) std::rethrow_exception(finished->failure());
    if (then) then();
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
